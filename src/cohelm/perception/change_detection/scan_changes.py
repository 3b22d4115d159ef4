"""Change detection for planar scans: find objects that have arrived at their place.

An object on legs that never moves is furniture; one at a place that the scanner saw through before
has arrived there. Some past scans are stored, ever sparser with age, each with the pose of its
sensor, so that the comparison works for a moving chair as well.
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.perception.api import Detections
from cohelm.perception.change_detection.past_scans import (
    FREE,
    NO_RETURN,
    OCCUPIED,
    UNKNOWN,
    ChangeDetectionParameters,
    PastBeams,
    PastScans,
    beams_of,
    compare_places,
)

_MIN_SURROUNDINGS = 20
"""Returns of the surroundings that are needed to judge the pose."""


class ScanComparison(NamedTuple):
    """A past scan compared with the present detections."""

    new: int
    """Returns of the surroundings (of no person) at places that were free."""
    same: int
    """Returns of the surroundings at places that were occupied."""
    total: int
    """Returns of the surroundings."""
    occupied: Floats
    """(d,) share of each detection's place that was occupied, 0…1."""
    known: Booleans
    """(d,) True where that place was observed."""


def detect_changes(
    found: Detections, past: PastScans, parameters: ChangeDetectionParameters | None = None
) -> Detections:
    """Add ``moved`` to ``found``: log-odds that each has arrived at its place, 0 where unknown.

    From the youngest scan backwards, the time for which the place was occupied is skipped; the
    occupancy before that tells whether the object arrived then.
    """
    p = parameters or ChangeDetectionParameters()
    d = len(found.position)
    if not d or not past:
        return replace(found, moved=np.zeros(d))
    owner = found.owner
    width = np.concatenate([2.0 * found.ellipse[:, 2], [0.0]])[found.cluster]
    margin = np.array([p.margin, p.margin_growth])
    present, occupied, looks = np.zeros(d), np.zeros(d), np.zeros(d)
    here, consistent, inconsistent = None, 0, 0
    for each in past:
        age = found.time - each.scan.time
        if not p.min_age <= age <= p.max_age:
            continue
        beams = beams_of(each)
        before = _compare(found.points, width, owner, d, beams, margin, p.no_return_weight)
        if not _is_consistent(before, age, p):
            inconsistent += age <= p.arrival_time
            continue
        consistent += age <= p.arrival_time
        if here is None:
            here = np.full(d, age <= p.arrival_time)
        here &= ~before.known | (before.occupied > 0.5)
        present[here & before.known] = age
        occupied += before.known * ~here * before.occupied
        looks += before.known & ~here
    if inconsistent > consistent:
        return replace(found, moved=np.full(d, p.mislocalised_log_odds))
    moved = _log_odds(present, occupied, looks, p)
    thin = np.bincount(owner[owner >= 0], minlength=d) < p.min_returns
    return replace(found, moved=np.where(thin, np.minimum(moved, 0.0), moved))


def _log_odds(
    present: Floats, occupied: Floats, looks: Floats, p: ChangeDetectionParameters
) -> Floats:
    """Log-odds (d,) of motion.

    Args:
        present: time for which the place has been occupied, s.
        occupied: sum of its occupancy before that.
        looks: number of observations before that.
        p: the parameters.
    """
    before = occupied / np.maximum(looks, 1.0)
    values = [p.arrived_log_odds, 0.0, 0.0, p.static_log_odds]
    moved = np.interp(before, [0.15, 0.35, 0.5, 0.8], values)
    moved = np.where((present > p.arrival_time) & (moved > 0.0), 0.0, moved)
    rests = p.static_log_odds * np.clip(present / p.rest_time, 0.0, 1.0)
    few_looks = np.where(looks > 0.0, np.minimum(moved, 0.0), rests)
    out: Floats = np.where(looks >= p.min_looks, moved, few_looks)
    return out


def _is_consistent(before: ScanComparison, age: float, p: ChangeDetectionParameters) -> bool:
    """Check that the surroundings are where they were, as far as the past scan shows them."""
    if before.total < _MIN_SURROUNDINGS:
        return True
    least = max(p.min_same - p.same_decay * age, p.same_floor)
    few_new = before.new <= p.max_changed * (before.new + before.same)
    return few_new and before.same >= least * before.total


@njit(cache=True)
def _compare(  # noqa: PLR0917  # a kernel takes arrays and numbers
    points: Floats,
    width: Floats,
    owner: Integers,
    d: int,
    beams: PastBeams,
    margin: Floats,
    no_return_weight: float,
) -> ScanComparison:
    """Compare returns with a past scan; arguments as for :func:`compare_places`."""
    was = compare_places(points, width, beams, margin)
    new, same, total = 0, 0, 0
    known, occupied = np.zeros(d), np.zeros(d)
    for i in range(len(was)):
        if owner[i] < 0:
            total += 1
            new += was[i] == FREE
            same += was[i] == OCCUPIED
        elif was[i] != UNKNOWN:
            known[owner[i]] += no_return_weight if was[i] == NO_RETURN else 1.0
            occupied[owner[i]] += was[i] == OCCUPIED
    return ScanComparison(new, same, total, occupied / np.maximum(known, 1e-9), known > 0.0)
