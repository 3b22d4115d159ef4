"""``cohelm bench``: a command for every benchmark; one line in ``BENCHES`` adds one."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import typer

from cohelm.cli.bench_options import COMMON, for_bench, parameters

BENCHES = {
    "ablation": (
        "cohelm.benchmarks.rides.ablation",
        "Ablation of ss_mpc_dcbf: leave out one component at a time.",
    ),
    "barn": (
        "cohelm.benchmarks.external.barn",
        "300 BARN worlds in this 2-D simulator: success, collisions, score.",
    ),
    "calm": (
        "cohelm.benchmarks.rides.calm",
        "Arrivals, collisions, stops and jerk on a hospital floor and on real floors.",
    ),
    "cards": (
        "cohelm.benchmarks.rides.cards",
        "All local planners on social navigation cards (Francis et al. 2023).",
    ),
    "crowdnav": (
        "cohelm.benchmarks.external.crowdnav",
        "CrowdNav's circle crossing: people do not see the robot.",
    ),
    "crowds": (
        "cohelm.benchmarks.rides.crowds",
        "All local planners across filmed crowds, which do not react.",
    ),
    "destinations": (
        "cohelm.benchmarks.destinations",
        "Inference of the destination of a rider who has named none, and the offers.",
    ),
    "doorways": (
        "cohelm.benchmarks.rides.doorways",
        "Narrow doorways among people with hands of all kinds: who gets through.",
    ),
    "faults": (
        "cohelm.benchmarks.rides.faults",
        "Faults of sensors, wheels and stick: detected, stopped, contacts; false alarms.",
    ),
    "lost": (
        "cohelm.benchmarks.lost",
        "Localisation health on real floors: chairs carried elsewhere, and false alarms.",
    ),
    "manoeuvres": (
        "cohelm.benchmarks.rides.manoeuvres",
        "Lifts, niches, toilets, dead ends and side doors: in, and out again.",
    ),
    "paper-dynamic": (
        "cohelm.benchmarks.paper.dynamic",
        "All local planners in the paper's dynamic scenes (Xu et al., Table 3).",
    ),
    "paper-global": (
        "cohelm.benchmarks.paper.global_planners",
        "Distance of all global planners from the rider's own path (Xu et al., Table 2).",
    ),
    "paper-static": (
        "cohelm.benchmarks.rides.modes:create_corridors",
        "All driving modes in the paper's corridors (Xu et al., Fig. 13).",
    ),
    "perception": (
        "cohelm.benchmarks.perception.bench",
        "Detection, tracking and prediction of people: scores and computing time.",
    ),
    "planning": (
        "cohelm.benchmarks.planning",
        "Time and memory of global planning, compared with scikit-image and SciPy.",
    ),
    "riders": (
        "cohelm.benchmarks.rides.modes:create_riders",
        "All driving modes with all simulated riders, in five scenes.",
    ),
    "rides": (
        "cohelm.benchmarks.rides.rides",
        "All local planners in the same scenes with people (Xu et al., Table 3).",
    ),
    "sharing": (
        "cohelm.benchmarks.rides.sharing",
        "All driving modes where rider and chair know different things.",
    ),
    "simulation": (
        "cohelm.benchmarks.simulation",
        "Simulated people compared with RVO2; computing time of crowds and 3-D sensors.",
    ),
    "solver": (
        "cohelm.benchmarks.solver.bench",
        "Solver of ss_mpc_dcbf compared with IPOPT: time, optima and failures.",
    ),
    "speed": (
        "cohelm.benchmarks.ride_speed",
        "Real-time factor of simulation, perception and planning.",
    ),
    "twin": (
        "cohelm.benchmarks.rides.twin",
        "Planar simulation beside the MuJoCo twin: arrivals, contacts, forces.",
    ),
}
"""Name → ``module`` or ``module:function`` (default ``create``) that returns a bench, and help."""

OPTIONS: dict[str, tuple[str, ...]] = {
    "ablation": ("scenes", "seeing", "true_people", "tuned", "settings"),
    "barn": ("barn_planners", "worlds", "settings"),
    "calm": ("ride_parts", "ride_modes", "ride_share", "settings"),
    "cards": ("planners", "cards", "vary", "true_people", "tuned", "settings"),
    "crowdnav": (
        *("replay", "kinematics", "planner", "layout", "people", "caution"),
        "driver_settings",
    ),
    "crowds": ("planners", "films", "true_people", "settings"),
    "destinations": ("floors", "goals", "destination_settings"),
    "doorways": ("riders", "modes", "settings"),
    "faults": ("faults", "scenes", "ride_modes", "unwatched", "settings"),
    "manoeuvres": ("robots", "places", "settings"),
    "paper-dynamic": ("planners", "settings"),
    "paper-global": ("global_planners", "settings"),
    "paper-static": ("riders", "modes", "scenes", "true_people", "settings"),
    "perception": ("perception_parts", "part_settings"),
    "planning": ("map_file", "size", "plan_settings"),
    "riders": ("riders", "modes", "scenes", "true_people", "settings"),
    "rides": ("planners", "scenes", "blind", "both", "true_people", "tuned", "settings"),
    "sharing": ("families", "modes", "rotate", "settings"),
    "solver": ("part", "share", "solver_settings"),
    "speed": ("planners", "scenes", "settings"),
    "twin": ("scenes", "settings"),
}
"""Benchmark → its own options, by their names in ``bench_options.OWN``."""

app = typer.Typer(
    name="bench",
    help="Benchmarks: each writes its rows, a summary and its pictures to a folder.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


def _command(name: str, module: str) -> Callable[..., int]:
    def command(**given: Any) -> int:
        from cohelm.cli import bench

        common = {option: given[option] for option in COMMON}
        return bench.bench(name, module, bench.BenchRequest(**common, options=for_bench(given)))

    return _taking(OPTIONS.get(name, ()), command)


def _taking(own: tuple[str, ...], command: Callable[..., int]) -> Callable[..., int]:
    """Set the signature from which typer makes the options of the command."""
    signature = inspect.Signature(parameters(own), return_annotation=int)
    vars(command)["__signature__"] = signature
    command.__annotations__ = {name: p.annotation for name, p in signature.parameters.items()}
    return command


for _name, (_module, _help) in BENCHES.items():
    app.command(_name, help=_help)(_command(_name, _module))
