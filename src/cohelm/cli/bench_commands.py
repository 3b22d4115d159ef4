"""``cohelm bench``: a command for every benchmark; one line in ``BENCHES`` adds one."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import typer

from cohelm.cli import compiled_code
from cohelm.cli.bench_options import COMMON, for_bench, parameters

BENCHES = {
    "ablation": (
        "cohelm.benchmarks.rides.ablation",
        "What each idea in ss_mpc_dcbf is worth: one at a time left out.",
    ),
    "barn": (
        "cohelm.benchmarks.external.barn",
        "The 300 BARN worlds in this 2-D simulator: success, collisions, score.",
    ),
    "cards": (
        "cohelm.benchmarks.rides.cards",
        "Social navigation cards, every local planner on each (Francis et al. 2023).",
    ),
    "crowdnav": (
        "cohelm.benchmarks.external.crowdnav",
        "CrowdNav's circle crossing past people who do not see the robot.",
    ),
    "crowds": (
        "cohelm.benchmarks.rides.crowds",
        "Every local planner across filmed crowds, who do not react.",
    ),
    "paper-dynamic": (
        "cohelm.benchmarks.paper.dynamic",
        "Every local planner in the paper's dynamic scenes, beside Table 3 of Xu et al.",
    ),
    "paper-global": (
        "cohelm.benchmarks.paper.global_planners",
        "Global planners by how near they come to the rider's own way (Xu et al., Table 2).",
    ),
    "paper-static": (
        "cohelm.benchmarks.rides.modes:create_corridors",
        "Riders in the paper's corridors by hand, assisted, shared and alone (Xu et al., Fig. 13).",
    ),
    "perception": (
        "cohelm.benchmarks.perception.bench",
        "People in recordings and in crowds: found, followed, foreseen, and at what cost.",
    ),
    "planning": (
        "cohelm.benchmarks.planning",
        "Time and memory of global planning beside scikit-image and SciPy.",
    ),
    "riders": (
        "cohelm.benchmarks.rides.modes:create_riders",
        "Riders of all kinds by hand, assisted, shared and alone, in five scenes.",
    ),
    "rides": (
        "cohelm.benchmarks.rides.rides",
        "Every local planner in the same scenes among people (Xu et al., Table 3).",
    ),
    "simulation": (
        "cohelm.benchmarks.simulation",
        "The simulated people against recorded RVO2, and the cost of crowds and 3-D sensors.",
    ),
    "solver": (
        "cohelm.benchmarks.solver.bench",
        "The local planner's solver: time over people, optima and failures, beside IPOPT.",
    ),
    "speed": (
        "cohelm.benchmarks.ride_speed",
        "How many times faster than the clock rides are simulated, perceived and planned.",
    ),
}
"""Name → ``module`` or ``module:function`` (default ``create``) that returns a bench, and help."""

OPTIONS: dict[str, tuple[str, ...]] = {
    "ablation": ("scenes", "seeing", "true_people", "tuned", "settings"),
    "barn": ("barn_planners", "worlds", "settings"),
    "cards": ("planners", "cards", "vary", "true_people", "tuned", "settings"),
    "crowdnav": (
        *("replay", "kinematics", "planner", "layout", "people", "caution"),
        "driver_settings",
    ),
    "crowds": ("planners", "films", "true_people", "settings"),
    "paper-dynamic": ("planners", "settings"),
    "paper-global": ("global_planners", "settings"),
    "paper-static": ("riders", "modes", "scenes", "true_people", "settings"),
    "perception": ("part_settings",),
    "planning": ("map_file", "size", "plan_settings"),
    "riders": ("riders", "modes", "scenes", "true_people", "settings"),
    "rides": ("planners", "scenes", "blind", "both", "true_people", "tuned", "settings"),
    "solver": ("part", "share", "solver_settings"),
    "speed": ("planners", "scenes", "settings"),
}
"""Those that take options of their own, by the names in ``bench_options.OWN``."""

app = typer.Typer(
    name="bench",
    help="Benchmarks: each writes its rows, a summary and its pictures to a folder.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


def _command(name: str, module: str) -> Callable[..., int]:
    def command(**given: Any) -> int:
        compiled_code.choose_folder()
        from cohelm.cli import bench  # noqa: PLC0415 # lazy

        common = {option: given[option] for option in COMMON}
        return bench.bench(name, module, bench.BenchRequest(**common, options=for_bench(given)))

    return _taking(OPTIONS.get(name, ()), command)


def _taking(own: tuple[str, ...], command: Callable[..., int]) -> Callable[..., int]:
    """The command with the signature that typer makes its options from."""
    signature = inspect.Signature(parameters(own), return_annotation=int)
    vars(command)["__signature__"] = signature
    command.__annotations__ = {name: p.annotation for name, p in signature.parameters.items()}
    return command


for _name, (_module, _help) in BENCHES.items():
    app.command(_name, help=_help)(_command(_name, _module))
