"""Change detection for planar scans: find objects that have arrived at their place.

An object on legs that never moves is furniture; one at a place that the scanner saw through before
has arrived there. Some past scans are stored, ever sparser with age, each with the pose of its
sensor, so that the comparison works for a moving chair as well.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.config import number_record
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED
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

_DARK_FROM = 0.3
"""Occupied share of the past scans of a place from which missing returns do not show it free."""


class _Evidence(NamedTuple):
    """Evidence about the places of d detections, from the youngest past scan backwards."""

    present: Floats
    """(d,) time for which each place has been occupied without interruption, s."""
    occupied: Floats
    """(d,) sum of its occupancy before that, 0…1 for each scan."""
    looks: Floats
    """(d,) number of observations before that, with a return from there or from behind."""
    lost: Floats
    """(d,) number of observations before that without any return from that direction."""
    same_view: Floats
    """(d,) number of observations before that, from the present view."""
    still_occupied: Booleans
    """(d,) True as long as no free place was found."""


def detect_changes(
    found: Detections,
    past: PastScans,
    parameters: ChangeDetectionParameters | None = None,
    X_MS: Floats | None = None,
) -> Detections:
    """Add ``arrival_log_odds`` to ``found``.

    From the youngest scan backwards, the time for which the place is occupied without interruption
    is skipped; the object has arrived then if the place was free before that, as seen from ``X_MS``
    (3,), the present pose of the scanner; None: from anywhere.
    """
    p = parameters or ChangeDetectionParameters()
    d = len(found.position)
    if not d or not past:
        return replace(found, arrival_log_odds=np.zeros(d))
    detection = found.detection_of_return
    width = np.concatenate([2.0 * found.ellipse[:, 2], [0.0]])[found.cluster_of_return]
    present, occupied, looks, lost, alike = np.zeros((5, d))
    still = np.zeros(d, dtype=np.bool_)
    evidence = _Evidence(present, occupied, looks, lost, alike, still)
    record, consistent, inconsistent, first, same_view = _record(p), 0, 0, True, True
    for each in past:
        age = found.time - each.scan.time
        if not p.min_age <= age <= p.max_age:
            continue
        if first:
            # After a pause longer than ``arrival_time``, all scans show the time before an arrival.
            evidence.still_occupied[:] = age <= p.arrival_time
        same = X_MS is None or _is_same_view(X_MS, each.X_MS, p)
        same_view = same if first else same_view
        beams = past_beams(each)
        if _look_back(found.points, width, detection, beams, same, age, evidence, record):
            consistent += age <= p.arrival_time
            first = False
        else:
            inconsistent += age <= p.arrival_time
    if inconsistent > consistent:
        arrival = np.full(d, p.mislocalised_log_odds)
        return replace(found, arrival_log_odds=arrival, same_view=same_view)
    # Something that was often seen there is dark: without a return, it was there nevertheless.
    looks = evidence.looks + evidence.lost
    looks = np.where(evidence.occupied > _DARK_FROM * looks, evidence.looks, looks)
    arrival = _arrival_log_odds(evidence.present, evidence.occupied, looks, p)
    doubtful = np.bincount(detection[detection >= 0], minlength=d) < p.min_returns
    doubtful |= evidence.same_view < p.min_looks
    arrival = np.where(doubtful, np.minimum(arrival, 0.0), arrival)
    return replace(found, arrival_log_odds=arrival, same_view=same_view)


def _is_same_view(a: Floats, b: Floats, p: ChangeDetectionParameters) -> bool:
    """Check that two scanner poses (3,) see the same."""
    apart = math.hypot(a[0] - b[0], a[1] - b[1])
    return apart <= p.same_view and abs(float(wrap_angle(a[2] - b[2]))) <= p.same_view


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


@njit(**CACHED)
def _look_back(
    points: Floats,
    width: Floats,
    detection: Integers,
    beams: PastBeams,
    same_view: bool,
    age: float,
    evidence: _Evidence,
    p: ChangeDetectionParameters,
) -> bool:
    """Add one past scan to the evidence, in place; False if the surroundings contradict it.

    Args:
        points, width, beams: as for :func:`compare_places`.
        detection: (p,) detection of each return, −1: surroundings.
        same_view: the past scan shows the present view.
        age: of the past scan, s.
        evidence: of the younger scans.
        p: the parameters.
    """
    was = compare_places(points, width, beams, (p.margin, p.margin_growth))
    d, new, same, total = len(evidence.looks), 0, 0, 0
    known, occupied, returned = np.zeros(d), np.zeros(d), np.zeros(d, dtype=np.bool_)
    for i in range(len(was)):
        k = detection[i]
        if k < 0:
            total += 1
            new += was[i] == PastState.FREE
            same += was[i] == PastState.OCCUPIED
        elif was[i] != PastState.UNKNOWN:
            returned[k] = returned[k] or was[i] != PastState.NO_RETURN
            known[k] += p.no_return_weight if was[i] == PastState.NO_RETURN else 1.0
            occupied[k] += was[i] == PastState.OCCUPIED
    # Are the surroundings where they were, as far as the past scan shows them?
    if total >= _MIN_SURROUNDINGS:
        least = max(p.min_same - p.same_decay * age, p.same_floor)
        if new > p.max_changed * (new + same) or same < least * total:
            return False
    for k in range(d):
        if known[k] <= 0.0:
            continue
        share = occupied[k] / max(known[k], 1e-9)
        evidence.still_occupied[k] = evidence.still_occupied[k] and share > 0.5
        if evidence.still_occupied[k]:
            evidence.present[k] = age
        else:
            evidence.occupied[k] += share
            evidence.same_view[k] += same_view
            if returned[k]:
                evidence.looks[k] += 1.0
            else:
                evidence.lost[k] += 1.0
    return True


@lru_cache(maxsize=8)
def _record(parameters: ChangeDetectionParameters) -> Any:
    return number_record(parameters)
