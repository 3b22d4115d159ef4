"""Destination inference on rides with hidden destinations.

Each ride is scored at a quarter, half and three quarters of the way: is the right place the most
probable one, or among three? A ranking of the places by their distance is the baseline. A wrong
offer is a wrong place whose belief rises above 0.8 or 0.9. With ``elsewhere`` the destination has
no name, and every such offer is wrong.

Scores of destination inference along one ride.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.benchmarks.bench import (
    BenchReport,
    Result,
    Sheet,
    Task,
    known_name,
    split_names,
)
from cohelm.benchmarks.destination_rides import (
    GOALS,
    MAPS,
    PERIOD,
    RIDERS,
    SHORTEST,
    PlacesFloor,
    RiddenTrack,
    draw_goal,
    drive,
    floor_exists,
    places_floor,
)
from cohelm.config import override, validate
from cohelm.navigation import DestinationInference, DestinationParameters
from cohelm.recordings.outside_data import outside_file

SHARES = (0.25, 0.5, 0.75)
"""Shares of the way at which the ranking is scored."""
CERTAIN = 0.8
"""Belief that counts as certainty."""
WRONG = (0.8, 0.9)
"""Beliefs from which a wrong place counts as a wrong offer."""
_RELEASE = 0.15  # a place must fall this much below before it counts again


@value
class Beliefs:
    """Beliefs and costs-to-go along a ride of k steps."""

    belief: Floats
    """(k, n)."""
    cost: Floats
    """(k, n), m."""
    offered: tuple[tuple[int, ...], ...]
    """Indices of the offered places at each step."""


def beliefs_of(floor: PlacesFloor, track: RiddenTrack, inference: DestinationInference) -> Beliefs:
    """Run the inference along a ride."""
    memory, belief, cost, offered = None, [], [], []
    index = {name: k for k, name in enumerate(floor.places.names)}
    turn_rate = floor.robot.max_turn_rate
    for k, (pose, stick) in enumerate(zip(track.poses, track.sticks, strict=True)):
        found, memory = inference.update(k * PERIOD, pose, stick, turn_rate, memory)
        belief.append(found.places)
        cost.append(floor.fields.at(pose[:2]))
        offered.append(tuple(index[offer.name] for offer in found.offers))
    return Beliefs(belief=np.array(belief), cost=np.array(cost), offered=tuple(offered))


def score(along: Beliefs, place: int, near: float) -> dict[str, float]:
    """Scores of a ride; those of the right place are NaN where the destination has no name.

    Args:
        along: beliefs of the ride.
        place: index of the destination; −1: it has no name.
        near: places closer than this are not offered, m.
    """
    row = {"seconds": PERIOD * (len(along.belief) - 1)}
    for bound in WRONG:
        row[f"wrong_{bound:g}"] = float(_wrong(along, place, near, bound))
    new = [set(b) - set(a) for a, b in zip(along.offered, along.offered[1:], strict=False)]
    row["new_offers"] = float(len(along.offered[0]) + sum(map(len, new)))
    return row | _right(along, place, near)


def _wrong(along: Beliefs, place: int, near: float, bound: float) -> int:
    """Number of times that the belief in a wrong place rises above a bound."""
    count, shown = 0, -1
    best = np.argmax(np.where(along.cost >= near, along.belief, 0.0), axis=1)
    for k, i in enumerate(best.tolist()):
        if shown >= 0 and along.belief[k, shown] < bound - _RELEASE:
            shown = -1
        if i != shown and along.belief[k, i] > bound and along.cost[k, i] >= near:
            shown = i
            count += i != place
    return count


def _right(along: Beliefs, place: int, near: float) -> dict[str, float]:
    """Ranks of the right place along the way, and when it became certain."""
    row: dict[str, float] = {}
    for share in SHARES:
        percent = f"{100.0 * share:.0f}"
        k = _at_share(along, place, share)
        other = np.where(along.cost[k] >= near, along.cost[k], np.inf)
        ranks = {"": _rank(-along.belief[k], place), "nearest_": _rank(other, place)}
        for name, rank in ranks.items():
            row[f"{name}top1_{percent}"] = float(rank < 1) if place >= 0 else math.nan
            row[f"{name}top3_{percent}"] = float(rank < 3) if place >= 0 else math.nan
        row[f"offered_{percent}"] = float(place in along.offered[k]) if place >= 0 else math.nan
    certain = np.flatnonzero(along.belief[:, place] > CERTAIN) if place >= 0 else np.empty(0)
    row["certain"] = float(len(certain) > 0) if place >= 0 else math.nan
    first = int(certain[0]) if len(certain) else -1
    row["certain_metres_left"] = float(along.cost[first, place]) if len(certain) else math.nan
    left = PERIOD * (len(along.belief) - 1 - first)
    row["certain_seconds_left"] = left if len(certain) else math.nan
    return row


def _at_share(along: Beliefs, place: int, share: float) -> int:
    """First step at which this share of the way to the place is done."""
    cost = along.cost[:, place]
    return int(np.argmax(cost <= (1.0 - share) * cost[0])) if place >= 0 else 0


def _rank(values: Floats, place: int) -> int:
    """Number of places before this one; places of equal value count half."""
    if place < 0:
        return len(values)
    before = int((values < values[place]).sum())
    return before + int((values == values[place]).sum() - 1) // 2


TITLE = "Destination inference: hidden destinations of simulated riders"
FLOORS = ("hospital", "utexas_gdc_3ne")
"""The floors by default; no parameter was tuned on them."""
_PERCENT = tuple(f"{100.0 * share:.0f}" for share in SHARES)


@dataclass(frozen=True)
class DestinationsBench:
    """The benchmark on some floors."""

    floors: tuple[str, ...]
    goals: tuple[str, ...] = GOALS
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of :class:`DestinationParameters`."""
    TITLE: str = TITLE
    SEEDS: int = 200
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per ride."""
        return [
            (floor, goals, seed) for floor in self.floors for goals in self.goals for seed in seeds
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Drive, infer, score."""
        name, goals, seed = task
        floor, rider = places_floor(name), RIDERS[seed % len(RIDERS)]
        goal = draw_goal(floor, goals, seed)
        if goal is None:
            return []
        parameters = _parameters((*self.settings, f"inference.habits={goal.habits}"))
        inference = DestinationInference(floor.fields, floor.places.names, parameters)
        track = drive(floor, goal, rider, seed)
        along = beliefs_of(floor, track, inference)
        row = {
            "floor": name,
            "goals": goals,
            "seed": seed,
            "rider": rider,
            "places": len(floor.places),
            "arrived": float(track.arrived),
        }
        return [Result(row | score(along, goal.place, parameters.offers.near))]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Tables of each floor."""
        rows = [result.row for result in results]
        sheets = []
        for floor in dict.fromkeys(str(row["floor"]) for row in rows):
            there = [row for row in rows if row["floor"] == floor]
            groups = {goals: [r for r in there if r["goals"] == goals] for goals in self.goals}
            title = f"{floor}, {there[0]['places']} places"
            sheets += [_ranking(title, groups), _offers(title, groups)]
        lost = sum(1 for row in rows if not row["arrived"])
        notes = [
            "Riders pursue a planned path with a disturbed stick, alone on the floor: "
            f"{', '.join(RIDERS)} in turn."
        ]
        notes += [
            f"{floor}: no two places are {SHORTEST:g} m apart"
            for floor in self.floors
            if floor not in {row["floor"] for row in rows}
        ]
        if lost:
            notes.append(f"{lost} of {len(rows)} rides did not arrive; they are scored as well.")
        return BenchReport(tuple(sheets), tuple(notes), {"settings": list(self.settings)})


def create(
    floors: str | None = None, goals: str | None = None, settings: Sequence[str] = ()
) -> DestinationsBench:
    """Create the benchmark from its options.

    Raises:
        ConfigError: if a floor, a kind of destination or a setting does not exist.
    """
    names = split_names(floors, "--floors") or tuple(
        name for name in FLOORS if name == FLOORS[0] or outside_file(MAPS, f"{name}.yaml")
    )
    for name in names:
        floor_exists(name)
    kinds = split_names(goals, "--goals") or GOALS
    for kind in kinds:
        known_name(kind, GOALS, "kind of destination", "--goals")
    _parameters(settings)
    return DestinationsBench(names, kinds, tuple(settings))


def _parameters(settings: Sequence[str]) -> DestinationParameters:
    return validate(DestinationParameters, override({}, settings))


def _ranking(title: str, groups: Mapping[str, Sequence[Mapping[str, Any]]]) -> Sheet:
    """Share of rides in which the right place is the first, or one of the first three."""
    lines = []
    for goals, rows in groups.items():
        if goals == "elsewhere" or not rows:
            continue
        for name, prefix in (("inference", ""), ("nearest place", "nearest_")):
            cells = [
                _share(rows, f"{prefix}{top}_{share}")
                for top in ("top1", "top3")
                for share in _PERCENT
            ]
            lines.append((f"{goals}, {name}", str(len(rows)), *cells))
    columns = tuple(f"{top} at {share} %" for top in ("first", "of three") for share in _PERCENT)
    return Sheet(f"{title}: right place", ("destinations", "rides", *columns), tuple(lines))


def _offers(title: str, groups: Mapping[str, Sequence[Mapping[str, Any]]]) -> Sheet:
    """Certainty, and what the rider is shown."""
    lines = [
        (
            goals,
            _share(rows, f"offered_{_PERCENT[1]}"),
            _share(rows, "certain"),
            _median(rows, "certain_metres_left"),
            _median(rows, "certain_seconds_left"),
            *(_mean(rows, f"wrong_{bound:g}", 2) for bound in WRONG),
            _mean(rows, "new_offers", 1),
            _mean(rows, "seconds", 0),
        )
        for goals, rows in groups.items()
        if rows
    ]
    columns = (
        "destinations",
        "offered at 50 %",
        f"belief > {CERTAIN:g}",
        "then left, m",
        "then left, s",
        *(f"wrong at {bound:g} a ride" for bound in WRONG),
        "new offers a ride",
        "ride, s",
    )
    return Sheet(f"{title}: certainty and offers", columns, tuple(lines))


def _values(rows: Sequence[Mapping[str, Any]], key: str) -> list[float]:
    return [float(row[key]) for row in rows if not math.isnan(row[key])]


def _share(rows: Sequence[Mapping[str, Any]], key: str) -> str:
    values = _values(rows, key)
    return f"{100.0 * float(np.mean(values)):.0f} %" if values else ""


def _mean(rows: Sequence[Mapping[str, Any]], key: str, digits: int) -> str:
    values = _values(rows, key)
    return f"{float(np.mean(values)):.{digits}f}" if values else ""


def _median(rows: Sequence[Mapping[str, Any]], key: str) -> str:
    values = _values(rows, key)
    return f"{float(np.median(values)):.1f}" if values else ""
