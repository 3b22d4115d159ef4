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
    argument: str = ""
    """Argument of ``create``; empty: the key."""
    into: Callable[[Any], Any] = lambda given: given
    """Value of the argument."""


def _option(
    kind: Any,
    text: str,
    metavar: str | None = None,
    *,
    flag: str = "",
    argument: str = "",
    into: Callable[[Any], Any] = lambda given: given,
    bounds: tuple[float | None, float | None] = (None, None),
) -> Option:
    """Option that is None or empty unless it is given; a list may be given several times."""
    text = f"{text[:-1]}; repeatable." if kind in _LISTS else text
    names = (flag,) if flag else ()
    low, high = bounds
    form = Annotated[
        kind | None, typer.Option(*names, metavar=metavar, min=low, max=high, help=text)
    ]
    return Option(form, None, argument, into)


_LISTS = (list[str], list[float], list[int])


def _names(text: str, flag: str = "", argument: str = "") -> Option:
    return _option(str, text, "A,B", flag=flag, argument=argument)


def _settings(text: str) -> Option:
    return _option(list[str], f"{text}.", "KEY=VALUE", flag="--set", argument="settings")


def _parts(text: str, argument: str = "parts", flag: str = "--part") -> Option:
    return _option(list[str], text, "NAME", flag=flag, argument=argument, into=tuple)


def _flag(text: str, name: str, argument: str = "", *, off: bool = False) -> Option:
    """Flag; ``off``: it sets its argument to False."""
    into: Callable[[Any], Any] = (lambda given: not given) if off else (lambda given: given)
    return Option(Annotated[bool, typer.Option(name, help=text)], False, argument, into)


COMMON: Mapping[str, Option] = {
    "seeds": _option(int, "Number of seeds; default: that of the benchmark.", bounds=(1, 10_000)),
    "first": Option(Annotated[int, typer.Option(min=0, max=2**31, help="First seed.")], 0),
    "out": _option(Path, "Result folder; default: benches/NAME.", "DIR"),
    "workers": _option(
        int, "Number of processes; default: that of the benchmark.", bounds=(1, 256)
    ),
    "resume": _flag("Continue the sweep in the result folder.", "--resume"),
    "overwrite": _flag("Remove the results in the folder first.", "--overwrite"),
    "cluster": _option(
        str,
        "Run on Dask: a local cluster of --workers processes, or a scheduler.",
        "local|tcp://…",
    ),
    "json": Option(Json, False),
}
"""Options of every benchmark; they are not arguments of its ``create``."""

OWN: Mapping[str, Option] = {
    "planners": _names("Local planners; default: all that are installed."),
    "barn_planners": _names(
        "Local planners; default: ss_mpc_dcbf and dwa.", "--planners", "planners"
    ),
    "global_planners": _names(
        "Global planners, or methods of the table; default: all.", "--planners", "planners"
    ),
    "scenes": _names("Scenarios by name or file; default: those of the benchmark."),
    "cards": _names("Cards by name or file; default: all."),
    "vary": _option(list[str], "Ride with each value; the key becomes a column.", "KEY=A,B,C"),
    "riders": _names("Riders; default: all with a destination."),
    "modes": _names("manual, stop_only, assisted, shared, autonomous; default: all."),
    "faults": _names("Kinds, or KIND:MAGNITUDE; default: all.", argument="kinds"),
    "unwatched": _flag("Ride again without the health monitor.", "--unwatched"),
    "families": _names("unseen, old-map, goal, way, hands; default: all."),
    "rotate": _flag("One rider per scene and seed, in turn: a quarter of the rides.", "--rotate"),
    "ride_modes": _names(
        "autonomous, shared, assisted, stop_only, manual; default: by part.", "--modes", "modes"
    ),
    "films": _names("zara01, eth, or files of trajectories; default: both films."),
    "blind": _flag("People do not see the chair.", "--blind"),
    "both": _flag("Ride every scenario unchanged and with --blind.", "--both"),
    "seeing": _flag(
        "People see the chair as the scenario specifies.", "--seeing", "blind", off=True
    ),
    "true_people": _flag("Give the chair the true positions of people.", "--true-people"),
    "tuned": _flag("Use the parameters of one search for all planners.", "--tuned"),
    "settings": _settings("Any scenario key, dotted"),
    "plan_settings": _settings("robot, clearance, cost_weight, inflation.… or preference.…"),
    "part_settings": _settings("Parameter of a perception part: tracker.gate=4"),
    "solver_settings": _settings("Parameter of the planner: local_planner.iterations=5"),
    "floors": _names(
        "Floors of cohelm or of ros_maps in COHELM_DATA; default: hospital, and utexas_gdc_3ne "
        "where there is COHELM_DATA."
    ),
    "robots": _names("Robots by name or file; default: quantum_q6_edge and rear_drive."),
    "places": _names("lift, dead end, niche, toilet, side door; default: all."),
    "goals": _names("uniform, habits, elsewhere (a point without a name); default: all."),
    "destination_settings": _settings(
        "Parameter of the inference: inference.beta=2 or offers.show=0.1"
    ),
    "worlds": _option(
        str, "A number of worlds, spread evenly, or indices; default: all 300.", "N|A,B"
    ),
    "replay": _option(Path, "Recorded people; default: those in COHELM_DATA.", "FILE.npz"),
    "kinematics": _option(str, "unicycle or holonomic; default: both.", "MODEL"),
    "planner": _option(str, "Local planner, or a reference: best_arc, straight, orca.", "NAME"),
    "layout": _option(str, "Own cases, circle or square, instead of the recorded ones.", "NAME"),
    "people": _option(int, "Number of people in own cases; default: 5.", bounds=(1, 20)),
    "caution": _option(list[float], "Added to every person's radius for the planner, m.", "M"),
    "driver_settings": _settings("Parameter of the driver: planner.clearance.now=0.3"),
    "map_file": _option(Path, "Map to scale; default: random floors.", "FILE.yaml", flag="--map"),
    "size": _option(
        list[int],
        "Side of the map, cells; default: 384, 1000 and 4000.",
        "CELLS",
        argument="sizes",
        into=tuple,
        bounds=(64, 20_000),
    ),
    "part": _parts("speed, optima, commands or failures; default: all."),
    "perception_parts": _parts(
        "held_out (leave one recording out), walking_aids, crowd, …; default: all."
    ),
    "ride_parts": _parts("hospital, blind, floors or narrow; default: all.", "part"),
    "ride_share": _option(
        float,
        "Share of the usual number of rides; default: 1.",
        flag="--share",
        argument="share",
        bounds=(0.001, 1.0),
    ),
    "share": _option(
        float, "Share of the usual number of states; default: 1.", bounds=(0.001, 100.0)
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
            option = OWN[name]
            out[option.argument or name] = option.into(value)
    return MappingProxyType(out)
