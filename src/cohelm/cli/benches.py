"""``cohelm bench``: a command for every benchmark; one line in ``BENCHES`` adds one."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any

import typer

from cohelm.cli import compiled_code, options

BENCHES = {
    "ablation": (
        "cohelm.evaluation.benches.ablation",
        "What each idea in ss_mpc_dcbf is worth: one at a time left out.",
    ),
    "barn": (
        "cohelm.evaluation.benches.barn",
        "The 300 BARN worlds in this 2-D simulator: success, collisions, score.",
    ),
    "crowdnav": (
        "cohelm.evaluation.benches.crowdnav",
        "CrowdNav's circle crossing past people who do not see the robot.",
    ),
    "paper-dynamic": (
        "cohelm.evaluation.benches.paper_dynamic",
        "Every local planner in the paper's dynamic scenes, beside Table 3 of Xu et al.",
    ),
    "paper-global": (
        "cohelm.evaluation.benches.paper_global",
        "Global planners by how near they come to the rider's own way (Xu et al., Table 2).",
    ),
    "perception": (
        "cohelm.evaluation.benches.perception",
        "People in recordings and in crowds: found, followed, foreseen, and at what cost.",
    ),
    "planning": (
        "cohelm.evaluation.benches.planning",
        "Time and memory of global planning beside scikit-image and SciPy.",
    ),
    "rides": (
        "cohelm.evaluation.benches.rides",
        "Every local planner in the same scenes among people (Xu et al., Table 3).",
    ),
    "solver": (
        "cohelm.testing.benches.solver",
        "The local planner's solver: time over people, optima and failures, beside IPOPT.",
    ),
}
"""Name → the module, which is a ``Bench``, and what it measures."""

app = typer.Typer(
    name="bench",
    help="Benchmarks: each writes its rows, a summary and its pictures to a folder.",
    no_args_is_help=True,
    rich_markup_mode="rich",
)


Seeds = Annotated[
    int | None,
    typer.Option(min=1, max=10_000, help="How many; unset, what is usual for it."),
]
First = Annotated[
    int, typer.Option(min=0, max=2**31, help="The first seed; others give other scenes.")
]
Out = Annotated[
    Path | None, typer.Option(metavar="DIR", help="What to write to; unset, benches/ and its name.")
]
Workers = Annotated[
    int | None, typer.Option(min=1, max=256, help="Processes; unset, what is usual for it.")
]
Map = Annotated[
    Path | None,
    typer.Option("--map", metavar="FILE.yaml", help="A map to stretch; unset, seeded floors."),
]

Size = Annotated[
    list[int] | None,
    typer.Option(
        "--size",
        metavar="CELLS",
        min=64,
        max=20_000,
        help="Side of the map in cells; may be given again. Unset, 384, 1000 and 4000.",
    ),
]

Planners = Annotated[
    str | None, typer.Option(metavar="A,B", help="Local planners; unset, all that are installed.")
]
Scenes = Annotated[
    str | None,
    typer.Option(metavar="A,B", help="Scenarios by name or file; unset, the usual ones."),
]
Blind = Annotated[bool, typer.Option("--blind", help="No one sees the chair.")]
Both = Annotated[bool, typer.Option("--both", help="Ride as the scenarios are, and --blind.")]
Seeing = Annotated[
    bool, typer.Option("--seeing", help="People see the chair where the scenario says so.")
]
TruePeople = Annotated[
    bool, typer.Option("--true-people", help="Tell the chair where people truly are.")
]
Tuned = Annotated[
    bool, typer.Option("--tuned", help="With the parameters that were found by one search for all.")
]
ScenarioSettings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Any key of the scenarios, dotted."),
]

BarnPlanners = Annotated[
    str | None,
    typer.Option("--planners", metavar="A,B", help="Local planners; unset, ss_mpc_dcbf and dwa."),
]
Worlds = Annotated[
    str | None,
    typer.Option(metavar="N|A,B", help="So many worlds, spread evenly, or these; unset, all 300."),
]

Replay = Annotated[
    Path | None,
    typer.Option(metavar="FILE.npz", help="Recorded people; unset, those in COHELM_DATA."),
]
Kinematics = Annotated[
    str | None,
    typer.Option(metavar="MODEL", help="unicycle or holonomic; unset, both."),
]
Driver = Annotated[
    str | None,
    typer.Option("--planner", metavar="NAME", help="Local planner; or best_arc, straight, orca."),
]
Layout = Annotated[
    str | None,
    typer.Option(metavar="NAME", help="Cases of our own, circle or square, not the recorded ones."),
]
Crowd = Annotated[
    int | None, typer.Option("--people", min=1, max=20, help="In cases of our own; 5.")
]
Caution = Annotated[
    list[float] | None,
    typer.Option(metavar="M", help="Tell the planner wider people; again for a curve."),
]
DriverSettings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="As in planner.arcs.margin=0.3."),
]


Part = Annotated[
    list[str] | None,
    typer.Option(
        metavar="NAME", help="speed, optima, commands or failures; again for more. Unset, all."
    ),
]
Share = Annotated[
    float | None, typer.Option(min=0.001, max=100.0, help="Of the usual number of states; 1.")
]


def _command(name: str, module: str) -> Callable[..., int]:
    def command(
        seeds: Seeds = None,
        first: First = 0,
        out: Out = None,
        workers: Workers = None,
        json: options.Json = False,
    ) -> int:
        compiled_code.place()
        from cohelm.cli import bench  # noqa: PLC0415 # lazy

        return bench.bench(name, module, bench.Asked(seeds, out, workers, json, first))

    return command


def _planning(
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    json: options.Json = False,
    map_file: Map = None,
    size: Size = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    name, module = "planning", BENCHES["planning"][0]
    own = _given(map_file=map_file, sizes=tuple(size) if size else None)
    asked = bench.Asked(seeds, out, None, json, first, own)
    return bench.bench(name, module, asked)


def _ablation(  # noqa: PLR0913, PLR0917  # each is an option
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    workers: Workers = None,
    json: options.Json = False,
    scenes: Scenes = None,
    seeing: Seeing = False,
    true_people: TruePeople = False,
    tuned: Tuned = False,
    settings: ScenarioSettings = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(scenes=scenes, settings=settings)
    own |= {"blind": not seeing, "true_people": true_people, "tuned": tuned}
    asked = bench.Asked(seeds, out, workers, json, first, own)
    return bench.bench("ablation", BENCHES["ablation"][0], asked)


def _rides(  # noqa: PLR0913, PLR0917  # each is an option
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    workers: Workers = None,
    json: options.Json = False,
    planners: Planners = None,
    scenes: Scenes = None,
    blind: Blind = False,
    both: Both = False,
    true_people: TruePeople = False,
    tuned: Tuned = False,
    settings: ScenarioSettings = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(planners=planners, scenes=scenes, settings=settings)
    own |= {"blind": blind, "both": both, "true_people": true_people, "tuned": tuned}
    asked = bench.Asked(seeds, out, workers, json, first, own)
    return bench.bench("rides", BENCHES["rides"][0], asked)


def _paper_dynamic(  # noqa: PLR0917  # each is an option
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    workers: Workers = None,
    json: options.Json = False,
    planners: Planners = None,
    settings: ScenarioSettings = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(planners=planners, settings=settings)
    asked = bench.Asked(seeds, out, workers, json, first, own)
    return bench.bench("paper-dynamic", BENCHES["paper-dynamic"][0], asked)


def _barn(  # noqa: PLR0917  # each is an option
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    workers: Workers = None,
    json: options.Json = False,
    planners: BarnPlanners = None,
    worlds: Worlds = None,
    settings: ScenarioSettings = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(planners=planners, worlds=worlds, settings=settings)
    asked = bench.Asked(seeds, out, workers, json, first, own)
    return bench.bench("barn", BENCHES["barn"][0], asked)


def _crowdnav(  # noqa: PLR0913, PLR0917  # each is an option
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    workers: Workers = None,
    json: options.Json = False,
    replay: Replay = None,
    kinematics: Kinematics = None,
    planner: Driver = None,
    layout: Layout = None,
    people: Crowd = None,
    caution: Caution = None,
    settings: DriverSettings = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(replay=replay, kinematics=kinematics, planner=planner, layout=layout)
    own |= _given(people=people, caution=caution or None, settings=settings)
    asked = bench.Asked(seeds, out, workers, json, first, own)
    return bench.bench("crowdnav", BENCHES["crowdnav"][0], asked)


def _solver(
    seeds: Seeds = None,
    first: First = 0,
    out: Out = None,
    json: options.Json = False,
    part: Part = None,
    share: Share = None,
) -> int:
    compiled_code.place()
    from cohelm.cli import bench  # noqa: PLC0415 # lazy

    own = _given(parts=tuple(part) if part else None, share=share)
    asked = bench.Asked(seeds, out, None, json, first, own)
    return bench.bench("solver", BENCHES["solver"][0], asked)


def _given(**own: Any) -> dict[str, Any]:
    """Those that are set."""
    return {name: each for name, each in own.items() if each is not None}


SPECIAL: dict[str, Callable[..., int]] = {
    "ablation": _ablation,
    "barn": _barn,
    "crowdnav": _crowdnav,
    "paper-dynamic": _paper_dynamic,
    "planning": _planning,
    "rides": _rides,
    "solver": _solver,
}
"""Those that take options of their own, which go to the module's ``on``."""

for _name, (_module, _help) in BENCHES.items():
    app.command(_name, help=_help)(SPECIAL.get(_name) or _command(_name, _module))
