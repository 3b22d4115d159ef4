"""Options of ``cohelm bench``: common ones, and those of single benchmarks."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, NamedTuple

import typer

from cohelm.cli.requests import Json


class Option(NamedTuple):
    """One option of a command."""

    form: Any
    """Annotation: type, help, and the name where it differs from the key."""
    unset: Any = None
    into: Callable[[Any], Mapping[str, Any]] | None = None
    """Arguments of ``create`` for a value; None: the value itself, under the key's name."""


COMMON: Mapping[str, Option] = {
    "seeds": Option(
        Annotated[
            int | None,
            typer.Option(
                min=1, max=10_000, help="Number of seeds; default: that of the benchmark."
            ),
        ]
    ),
    "first": Option(
        Annotated[int, typer.Option(min=0, max=2**31, help="First seed.")],
        0,
    ),
    "out": Option(
        Annotated[
            Path | None,
            typer.Option(metavar="DIR", help="Result folder; default: benches/NAME."),
        ]
    ),
    "workers": Option(
        Annotated[
            int | None,
            typer.Option(
                min=1, max=256, help="Number of processes; default: that of the benchmark."
            ),
        ]
    ),
    "resume": Option(
        Annotated[
            bool,
            typer.Option("--resume", help="Continue the sweep in the result folder."),
        ],
        False,
    ),
    "overwrite": Option(
        Annotated[
            bool,
            typer.Option("--overwrite", help="Remove the results in the folder first."),
        ],
        False,
    ),
    "cluster": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="local|tcp://…",
                help="Run on Dask: a local cluster of --workers processes, or a scheduler.",
            ),
        ]
    ),
    "json": Option(Json, False),
}
"""Options of every benchmark; they are not arguments of its ``create``."""


def _names(text: str, *flags: str) -> Any:
    return Annotated[str | None, typer.Option(*flags, metavar="A,B", help=text)]


def _settings(text: str) -> Any:
    return Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help=f"{text}; repeatable."),
    ]


def _flag(name: str, text: str) -> Any:
    return Annotated[bool, typer.Option(name, help=text)]


def _as_settings(given: Any) -> Mapping[str, Any]:
    return {"settings": given}


OWN: Mapping[str, Option] = {
    "planners": Option(_names("Local planners; default: all that are installed.")),
    "barn_planners": Option(
        _names("Local planners; default: ss_mpc_dcbf and dwa.", "--planners"),
        into=lambda given: {"planners": given},
    ),
    "global_planners": Option(
        _names("Global planners, or methods of the table; default: all.", "--planners"),
        into=lambda given: {"planners": given},
    ),
    "scenes": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="A,B", help="Scenarios by name or file; default: those of the benchmark."
            ),
        ]
    ),
    "cards": Option(_names("Cards by name or file; default: all.")),
    "vary": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="KEY=A,B,C",
                help="Ride with each value; the key becomes a column; repeatable.",
            ),
        ]
    ),
    "riders": Option(_names("Riders; default: all with a destination.")),
    "modes": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="A,B", help="manual, stop_only, assisted, shared, autonomous; default: all."
            ),
        ]
    ),
    "faults": Option(
        _names("Kinds, or KIND:MAGNITUDE; default: all."), into=lambda given: {"kinds": given}
    ),
    "unwatched": Option(_flag("--unwatched", "Ride again without the health monitor."), False),
    "families": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="unseen, old-map, goal, way, hands; default: all."),
        ]
    ),
    "rotate": Option(
        _flag("--rotate", "One rider per scene and seed, in turn: a quarter of the rides."), False
    ),
    "ride_modes": Option(
        Annotated[
            str | None,
            typer.Option(
                "--modes",
                metavar="A,B",
                help="autonomous, shared, assisted, stop_only, manual; default: by part.",
            ),
        ],
        into=lambda given: {"modes": given},
    ),
    "films": Option(_names("zara01, eth, or files of trajectories; default: both films.")),
    "blind": Option(_flag("--blind", "People do not see the chair."), False),
    "both": Option(_flag("--both", "Ride every scenario unchanged and with --blind."), False),
    "seeing": Option(
        _flag("--seeing", "People see the chair as the scenario specifies."),
        False,
        into=lambda given: {"blind": not given},
    ),
    "true_people": Option(
        _flag("--true-people", "Give the chair the true positions of people."), False
    ),
    "tuned": Option(_flag("--tuned", "Use the parameters of one search for all planners."), False),
    "settings": Option(_settings("Any scenario key, dotted")),
    "plan_settings": Option(
        _settings("robot, clearance, cost_weight, inflation.… or preference.…"), into=_as_settings
    ),
    "part_settings": Option(
        _settings("Parameter of a perception part: tracker.gate=4"), into=_as_settings
    ),
    "solver_settings": Option(
        _settings("Parameter of the planner: local_planner.iterations=5"), into=_as_settings
    ),
    "floors": Option(
        _names(
            "Floors of cohelm or of ros_maps in COHELM_DATA; default: hospital, and "
            "utexas_gdc_3ne where there is COHELM_DATA."
        )
    ),
    "robots": Option(_names("Robots by name or file; default: quantum_q6_edge and rear_drive.")),
    "places": Option(_names("lift, dead end, niche, toilet, side door; default: all.")),
    "goals": Option(_names("uniform, habits, elsewhere (a point without a name); default: all.")),
    "destination_settings": Option(
        _settings("Parameter of the inference: inference.beta=2 or offers.show=0.1"),
        into=_as_settings,
    ),
    "worlds": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="N|A,B",
                help="A number of worlds, spread evenly, or indices; default: all 300.",
            ),
        ]
    ),
    "replay": Option(
        Annotated[
            Path | None,
            typer.Option(
                metavar="FILE.npz", help="Recorded people; default: those in COHELM_DATA."
            ),
        ]
    ),
    "kinematics": Option(
        Annotated[
            str | None,
            typer.Option(metavar="MODEL", help="unicycle or holonomic; default: both."),
        ]
    ),
    "planner": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="NAME", help="Local planner, or a reference: best_arc, straight, orca."
            ),
        ]
    ),
    "layout": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="NAME", help="Own cases, circle or square, instead of the recorded ones."
            ),
        ]
    ),
    "people": Option(
        Annotated[
            int | None,
            typer.Option(min=1, max=20, help="Number of people in own cases; default: 5."),
        ]
    ),
    "caution": Option(
        Annotated[
            list[float] | None,
            typer.Option(
                metavar="M", help="Added to every person's radius for the planner, m; repeatable."
            ),
        ]
    ),
    "driver_settings": Option(
        _settings("Parameter of the driver: planner.clearance.now=0.3"), into=_as_settings
    ),
    "map_file": Option(
        Annotated[
            Path | None,
            typer.Option(
                "--map", metavar="FILE.yaml", help="Map to scale; default: random floors."
            ),
        ]
    ),
    "size": Option(
        Annotated[
            list[int] | None,
            typer.Option(
                "--size",
                metavar="CELLS",
                min=64,
                max=20_000,
                help="Side of the map, cells; repeatable; default: 384, 1000 and 4000.",
            ),
        ],
        into=lambda given: {"sizes": tuple(given)},
    ),
    "part": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="NAME",
                help="speed, optima, commands or failures; repeatable; default: all.",
            ),
        ],
        into=lambda given: {"parts": tuple(given)},
    ),
    "perception_parts": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                "--part",
                metavar="NAME",
                help="held_out (leave one recording out), walking_aids, crowd, …; repeatable; "
                "default: all.",
            ),
        ],
        into=lambda given: {"parts": tuple(given)},
    ),
    "ride_parts": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                "--part",
                metavar="NAME",
                help="hospital, blind, floors or narrow; repeatable; default: all.",
            ),
        ],
        into=lambda given: {"part": tuple(given)},
    ),
    "ride_share": Option(
        Annotated[
            float | None,
            typer.Option(
                "--share",
                min=0.001,
                max=1.0,
                help="Share of the usual number of rides; default: 1.",
            ),
        ],
        into=lambda given: {"share": given},
    ),
    "share": Option(
        Annotated[
            float | None,
            typer.Option(
                min=0.001, max=100.0, help="Share of the usual number of states; default: 1."
            ),
        ]
    ),
}
"""Options of single benchmarks; they are arguments of ``create``."""


def parameters(names: tuple[str, ...]) -> list[inspect.Parameter]:
    """Parameters of a command: the common options, and those named."""
    chosen = {**COMMON, **{name: OWN[name] for name in names}}
    return [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=each.unset, annotation=each.form
        )
        for name, each in chosen.items()
    ]


def for_bench(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Arguments of ``create``: the benchmark's own options that are set, and all flags."""
    out: dict[str, Any] = {}
    for name, value in given.items():
        if name in OWN and value is not None and value != []:
            into = OWN[name].into
            out |= into(value) if into else {name: value}
    return MappingProxyType(out)
