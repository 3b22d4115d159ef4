"""A study of sharing: all driving modes where rider and chair know different things."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Annotated, Any

from cohelm.benchmarks.bench import Result, chosen_names, unset
from cohelm.benchmarks.options import Modes, Settings, flag, names
from cohelm.benchmarks.rides.modes import modes_of, riders_of
from cohelm.benchmarks.rides.sharing_families import FAMILIES, REAL_HANDS, SPLIT, beside_start
from cohelm.benchmarks.rides.sharing_report import CROSSED_HYPOTHESES, HYPOTHESES, sharing_report
from cohelm.benchmarks.study import Grid, Study, Variant, common
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.metrics.wanted import as_wanted, entered_avoided_floor, places_missed
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.messages import Mode

TITLE = "Driving modes where rider and chair know different things"
COMPARED = {
    "rider": "the families",
    "mode": "--modes",
    "start": "the seed",
    "rider_plan": "a scene",
}
"""Keys that cannot be set for all rides → what sets them."""


def create(
    families: Annotated[
        str | None,
        names("unseen, old-map, goal, way, hands; default: all."),
    ] = None,
    modes: Modes = None,
    settings: Settings = (),
    rotate: Annotated[
        bool,
        flag("--rotate", "One rider per scene and seed, in turn: a quarter of the rides."),
    ] = False,
    crossed: Annotated[
        bool,
        flag("--crossed", "Unseen, old-map, goal and way with five difficult hands."),
    ] = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    With ``rotate`` one rider drives per scene and seed, in turn: a quarter of the rides in most
    families. With ``crossed`` riders with difficult hands have the knowledge that the chair lacks.

    Raises:
        ConfigError, PluginError, ScenarioError: if a family, a mode or a setting does not exist.
    """
    unset(settings, COMPARED)
    known = SPLIT if crossed else tuple(FAMILIES)
    found = chosen_names(families, "--families", known, kind="family", known=known)
    hands_of = {
        scene: REAL_HANDS if crossed else riders
        for name in found
        for scene, riders in FAMILIES[name].scenes.items()
    }
    scenes = tuple(
        Variant(
            columns=(("family", name), ("scene", scene)),
            scenario=scene,
            drawn=partial(beside_start, scene),
        )
        for name in found
        for scene in FAMILIES[name].scenes
    )
    hands = dict.fromkeys(hand for riders in hands_of.values() for hand in riders)
    plan = Grid(
        (scenes, common(settings), riders_of(hands), tuple(map(_driven, modes_of(modes)))),
        compared=2,
        keep=partial(_rotated if rotate else _rides, hands_of),
    )
    claims = CROSSED_HYPOTHESES if crossed else HYPOTHESES
    report = partial(sharing_report, title=TITLE, hypotheses=claims)
    return Study(TITLE, plan, report, ride_wanted).checked("rider")


def _driven(mode: Variant) -> Variant:
    """Mode; alone, the chair carries a rider without a device."""
    alone = mode.label == Mode.AUTONOMOUS.value
    return replace(mode, settings=(*mode.settings, *(("rider.use=none",) if alone else ())))


_Hands = Mapping[str, Sequence[str]]
"""Scenario → its riders."""


def _rides(hands_of: _Hands, columns: Mapping[str, str], seed: int, seeds: range) -> bool:
    """Check that the rider is one of the scene's."""
    return columns["rider"] in hands_of[columns["scene"]]


def _rotated(hands_of: _Hands, columns: Mapping[str, str], seed: int, seeds: range) -> bool:
    """Check that it is the rider's turn."""
    riders = hands_of[columns["scene"]]
    return columns["rider"] == riders[seed % len(riders)]


def ride_wanted(task: Sequence[RideTask]) -> list[Result]:
    """Ride, with ``wanted_columns``; rides that differ in their columns alone are ridden once."""
    done: dict[Any, Result] = {}
    out = []
    for ride in task:
        set_last = dict(setting.split("=", 1) for setting in ride.settings)
        key = (ride.scenario, frozenset(set_last.items()), ride.seed)
        if key not in done:
            done[key] = ride_row(ride, empty_floor=False, more=wanted_columns)
        found = done[key]
        # A ride that a program error ended did not arrive.
        row = {"as_wanted": 0.0, **found.row, **dict(ride.columns)}
        out.append(Result(row, found.arrays))
    return out


def wanted_columns(ride: Ride) -> Mapping[str, Any]:
    """Columns of the outcome that the rider wants; yes or no as 1 or 0."""
    return {
        "as_wanted": float(as_wanted(ride)),
        "places_missed": places_missed(ride),
        "avoided_floor": float(entered_avoided_floor(ride)),
    }
