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
    ChangeDetectionParameters,
    PastBeams,
    PastScans,
    PastState,
    compare_places,
    past_beams,
)

_MIN_SURROUNDINGS = 20
"""Returns of the surroundings that are needed to judge the pose."""
_ARRIVED_BELOW, _NEUTRAL, _STATIC_ABOVE = 0.15, (0.35, 0.5), 0.8
"""Past occupancy of a place (0…1) below which its object has arrived, for which nothing is known,
and above which its object is static; linear in between. Assumed."""


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
    """Add ``arrival_log_odds`` to ``found``.

    From the youngest scan backwards, the time for which the place is occupied without interruption
    is skipped; the object has arrived then if the place was free before that.
    """
    p = parameters or ChangeDetectionParameters()
    d = len(found.position)
    if not d or not past:
        return replace(found, arrival_log_odds=np.zeros(d))
    detection = found.detection_of_return
    width = np.concatenate([2.0 * found.ellipse[:, 2], [0.0]])[found.cluster_of_return]
    margin = np.array([p.margin, p.margin_growth])
    present, occupied, looks = np.zeros(d), np.zeros(d), np.zeros(d)
    still_occupied, consistent, inconsistent = None, 0, 0
    for each in past:
        age = found.time - each.scan.time
        if not p.min_age <= age <= p.max_age:
            continue
        beams = past_beams(each)
        before = _compare(found.points, width, detection, d, beams, margin, p.no_return_weight)
        if not _is_consistent(before, age, p):
            inconsistent += age <= p.arrival_time
            continue
        consistent += age <= p.arrival_time
        if still_occupied is None:
            # After a pause longer than ``arrival_time``, all scans show the time before an arrival.
            still_occupied = np.full(d, age <= p.arrival_time)
        still_occupied &= ~before.known | (before.occupied > 0.5)
        present[still_occupied & before.known] = age
        occupied += before.known * ~still_occupied * before.occupied
        looks += before.known & ~still_occupied
    if inconsistent > consistent:
        return replace(found, arrival_log_odds=np.full(d, p.mislocalised_log_odds))
    arrival = _arrival_log_odds(present, occupied, looks, p)
    thin = np.bincount(detection[detection >= 0], minlength=d) < p.min_returns
    return replace(found, arrival_log_odds=np.where(thin, np.minimum(arrival, 0.0), arrival))


def _arrival_log_odds(
    present: Floats, occupied: Floats, looks: Floats, p: ChangeDetectionParameters
) -> Floats:
    """Log-odds (d,) of arrival.

    Args:
        present: (d,) time for which each place has been occupied without interruption, s.
        occupied: (d,) sum of its occupancy before that.
        looks: (d,) number of observations before that.
        p: the parameters.
    """
    before = occupied / np.maximum(looks, 1.0)
    values = [p.arrived_log_odds, 0.0, 0.0, p.static_log_odds]
    arrival = np.interp(before, [_ARRIVED_BELOW, *_NEUTRAL, _STATIC_ABOVE], values)
    arrival = np.where((present > p.arrival_time) & (arrival > 0.0), 0.0, arrival)
    at_rest = p.static_log_odds * np.clip(present / p.rest_time, 0.0, 1.0)
    few_looks = np.where(looks > 0.0, np.minimum(arrival, 0.0), at_rest)
    out: Floats = np.where(looks >= p.min_looks, arrival, few_looks)
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
    detection: Integers,
    d: int,
    beams: PastBeams,
    margin: Floats,
    no_return_weight: float,
) -> ScanComparison:
    """Compare returns with a past scan.

    Args:
        points, width, beams, margin: as for :func:`compare_places`.
        detection: (p,) detection of each return, −1: surroundings.
        d: number of detections.
        no_return_weight: weight of a beam without a return as an observation.
    """
    was = compare_places(points, width, beams, margin)
    new, same, total = 0, 0, 0
    known, occupied = np.zeros(d), np.zeros(d)
    for i in range(len(was)):
        k = detection[i]
        if k < 0:
            total += 1
            new += was[i] == PastState.FREE
            same += was[i] == PastState.OCCUPIED
        elif was[i] != PastState.UNKNOWN:
            known[k] += no_return_weight if was[i] == PastState.NO_RETURN else 1.0
            occupied[k] += was[i] == PastState.OCCUPIED
    return ScanComparison(new, same, total, occupied / np.maximum(known, 1e-9), known > 0.0)
