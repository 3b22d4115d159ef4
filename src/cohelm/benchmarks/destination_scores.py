"""Scores of destination inference along one ride."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.benchmarks.destination_rides import PERIOD, PlacesFloor, RiddenTrack
from cohelm.navigation import DestinationInference

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
