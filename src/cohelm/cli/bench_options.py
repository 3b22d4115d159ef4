"""The options of ``cohelm bench``: those of every benchmark, and those that some have."""

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
    """The annotation: its type, its name if that is not the key's, its help."""
    unset: Any = None
    into: Callable[[Any], Mapping[str, Any]] | None = None
    """What a benchmark's ``create`` is given for it; None: the value, by the key's name."""


COMMON: Mapping[str, Option] = {
    "seeds": Option(
        Annotated[
            int | None,
            typer.Option(min=1, max=10_000, help="How many; unset, what is usual for it."),
        ]
    ),
    "first": Option(
        Annotated[
            int, typer.Option(min=0, max=2**31, help="The first seed; others give other scenes.")
        ],
        0,
    ),
    "out": Option(
        Annotated[
            Path | None,
            typer.Option(metavar="DIR", help="What to write to; unset, benches/ and its name."),
        ]
    ),
    "workers": Option(
        Annotated[
            int | None,
            typer.Option(min=1, max=256, help="Processes; unset, what is usual for it."),
        ]
    ),
    "resume": Option(
        Annotated[
            bool,
            typer.Option("--resume", help="Go on with what the folder has of the same sweep."),
        ],
        False,
    ),
    "overwrite": Option(
        Annotated[
            bool,
            typer.Option("--overwrite", help="Throw away the results that the folder has."),
        ],
        False,
    ),
    "cluster": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="local|tcp://…",
                help="Ride on Dask: on a cluster of --workers processes here, or at a scheduler.",
            ),
        ]
    ),
    "json": Option(Json, False),
}
"""Those of every benchmark; they do not reach its ``create``."""


def _settings(text: str) -> Any:
    return Annotated[
        list[str] | None,
        typer.Option("--set", metavar="KEY=VALUE", help=f"{text}; again for more."),
    ]


def _flag(name: str, text: str) -> Any:
    return Annotated[bool, typer.Option(name, help=text)]


def _as_settings(given: Any) -> Mapping[str, Any]:
    return {"settings": given}


OWN: Mapping[str, Option] = {
    "planners": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="Local planners; unset, all that are installed."),
        ]
    ),
    "barn_planners": Option(
        Annotated[
            str | None,
            typer.Option(
                "--planners", metavar="A,B", help="Local planners; unset, ss_mpc_dcbf and dwa."
            ),
        ],
        into=lambda given: {"planners": given},
    ),
    "global_planners": Option(
        Annotated[
            str | None,
            typer.Option(
                "--planners",
                metavar="A,B",
                help="Global planners, or rows of the table by name; unset, all there are.",
            ),
        ],
        into=lambda given: {"planners": given},
    ),
    "scenes": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="Scenarios by name or file; unset, the usual ones."),
        ]
    ),
    "cards": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="Cards by name or file; unset, all there are."),
        ]
    ),
    "vary": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="KEY=A,B,C",
                help="Ride with each of these values, a column of its own; again for another key.",
            ),
        ]
    ),
    "riders": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="Riders; unset, all who steer somewhere."),
        ]
    ),
    "modes": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="manual, assisted, shared, autonomous; unset, all."),
        ]
    ),
    "films": Option(
        Annotated[
            str | None,
            typer.Option(metavar="A,B", help="zara01, eth, or files of walks; unset, those two."),
        ]
    ),
    "blind": Option(_flag("--blind", "No one sees the chair."), False),
    "both": Option(_flag("--both", "Ride as the scenarios are, and --blind."), False),
    "seeing": Option(
        _flag("--seeing", "People see the chair where the scenario says so."),
        False,
        into=lambda given: {"blind": not given},
    ),
    "true_people": Option(_flag("--true-people", "Tell the chair where people truly are."), False),
    "tuned": Option(
        _flag("--tuned", "With the parameters that were found by one search for all."), False
    ),
    "settings": Option(_settings("Any key of the scenarios, dotted")),
    "plan_settings": Option(
        _settings("robot, clearance, cost_weight, inflation.… or preference.…"), into=_as_settings
    ),
    "part_settings": Option(
        _settings("Of a part that sees or foresees, as in tracker.gate=4"), into=_as_settings
    ),
    "solver_settings": Option(
        _settings("Of the planner, as in local_planner.iterations=5"), into=_as_settings
    ),
    "worlds": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="N|A,B", help="So many worlds, spread evenly, or these; unset, all 300."
            ),
        ]
    ),
    "replay": Option(
        Annotated[
            Path | None,
            typer.Option(metavar="FILE.npz", help="Recorded people; unset, those in COHELM_DATA."),
        ]
    ),
    "kinematics": Option(
        Annotated[
            str | None,
            typer.Option(metavar="MODEL", help="unicycle or holonomic; unset, both."),
        ]
    ),
    "planner": Option(
        Annotated[
            str | None,
            typer.Option(metavar="NAME", help="Local planner; or best_arc, straight, orca."),
        ]
    ),
    "layout": Option(
        Annotated[
            str | None,
            typer.Option(
                metavar="NAME", help="Cases of our own, circle or square, not the recorded ones."
            ),
        ]
    ),
    "people": Option(
        Annotated[int | None, typer.Option(min=1, max=20, help="In cases of our own; 5.")]
    ),
    "caution": Option(
        Annotated[
            list[float] | None,
            typer.Option(metavar="M", help="Tell the planner wider people; again for a curve."),
        ]
    ),
    "driver_settings": Option(
        _settings("Of the driver, as in planner.sampling.margin=0.3"), into=_as_settings
    ),
    "map_file": Option(
        Annotated[
            Path | None,
            typer.Option(
                "--map", metavar="FILE.yaml", help="A map to stretch; unset, seeded floors."
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
                help="Side of the map in cells; may be given again. Unset, 384, 1000 and 4000.",
            ),
        ],
        into=lambda given: {"sizes": tuple(given)},
    ),
    "part": Option(
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="NAME",
                help="speed, optima, commands or failures; again for more. Unset, all.",
            ),
        ],
        into=lambda given: {"parts": tuple(given)},
    ),
    "share": Option(
        Annotated[
            float | None,
            typer.Option(min=0.001, max=100.0, help="Of the usual number of states; 1."),
        ]
    ),
}
"""Those that some benchmarks have, which go to the ``create`` of its module."""


def parameters(names: tuple[str, ...]) -> list[inspect.Parameter]:
    """The common options and those named, as the parameters of a command."""
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
