"""Evidence that tracks are people: walking, shape, agility, rest and visibility."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED
from cohelm.perception.tracking.association import Visibility, visibility
from cohelm.perception.tracking.person_detections import PersonDetections, ScanTable
from cohelm.perception.tracking.tracks import (
    TrackerParameters,
    Tracks,
)

_RADIUS_RATE = 0.2
"""Weight of the latest observation in the running mean of the radius."""
_NIS_RATE, _MAX_NIS = 0.4, 20.0
"""Weight of the latest innovation in the running mean of the NIS, and its bound: one outlier is no
manoeuvre."""
_MAX_MOTION = 5.0
"""Bound of the log-odds of motion."""
_STATIC_FROM, _STATIC_GAIN = -1.0, 2.0
"""Log-odds of arrival below which a detection is punished for standing still, and the factor of
what is below. A cloud's detection whose place was never seen empty has −0.9 and stays unpunished:
it may be a standing person."""
_TIME_WEIGHTS = {
    Visibility.UNCLEAR: 1.0,
    Visibility.SEEN_THROUGH: 3.0,
    Visibility.OCCLUDED: 0.4,
    Visibility.OCCUPIED: 0.6,
    Visibility.OUT_OF_VIEW: 0.6,
}
_TIME_WEIGHT = np.array([_TIME_WEIGHTS[each] for each in Visibility])
"""Weight of a confirmed track's unseen time, by the visibility of its place."""


class Matches(NamedTuple):
    """Detections of m tracks in one scan."""

    detection: Integers
    """(m,) index of the detection, or ``NO_MATCH``."""
    mahalanobis_sq: Floats
    """(m,) its eᵀ S⁻¹ e."""
    merged: Booleans
    """(m,) True for both of two people who share a cluster."""


@njit(**CACHED)
def update_evidence(
    tracks: Tracks,
    found: PersonDetections,
    matches: Matches,
    scan: ScanTable,
    p: TrackerParameters,
) -> None:
    """Update the evidence of detected tracks, whose states are those after the scan, in place.

    A cluster of two people says nothing about the size, shape or agility of either.

    Args:
        tracks: (m,).
        found: possible people of the scan.
        matches: of tracks and possible people.
        scan: the scan.
        p: the parameters.
    """
    for t in range(len(tracks)):
        track, j = tracks[t], matches.detection[t]
        if j < 0:
            continue
        _update_pace(track, scan.time, p)
        walks = _update_motion(track, found.arrival_log_odds[j], found.shape_weight[j], scan, p)
        if not matches.merged[t]:
            weight = found.shape_weight[j]
            track.radius += _RADIUS_RATE * (found.radius[j] - track.radius)
            track.shape_looks += weight
            rate = weight * max(p.shape_rate, 1.0 / track.shape_looks) if weight > 0.0 else 0.0
            track.shape_log_odds += rate * (found.log_odds[j] - track.shape_log_odds)
            nis = min(matches.mahalanobis_sq[t], _MAX_NIS)
            track.nis += _NIS_RATE * (nis - track.nis)
        penalty = _STATIC_GAIN * min(found.arrival_log_odds[j] - _STATIC_FROM, 0.0)
        track.static_penalty += p.shape_rate * (penalty - track.static_penalty)
        track.last_seen = scan.time
        track.has_walked = track.has_walked or walks
        if _is_faster(track, p.heading_speed, 2.0):
            track.heading = math.atan2(track.mean[3], track.mean[2])


@njit(**CACHED)
def _update_motion(
    track: Any, arrival: float, shape_weight: float, scan: ScanTable, p: TrackerParameters
) -> bool:
    """Update the log-odds of motion, in place; True if the track walks.

    A track walks if it is far enough from its birthplace, and fast, at a place that has changed.

    Args:
        track: with the shape's log-odds from before the scan.
        arrival: log-odds of arrival of its detection.
        shape_weight: of its detection.
        scan: the scan.
        p: the parameters.
    """
    moved_x, moved_y = scan.origin[0] - track.viewpoint[0], scan.origin[1] - track.viewpoint[1]
    moved, age = math.hypot(moved_x, moved_y), scan.time - track.birth_time
    driven = min(moved / p.parallax_driven, 1.0)
    away_x = track.mean[0] - track.birthplace[0]
    away_y = track.mean[1] - track.birthplace[1]
    legs = track.shape_log_odds >= p.leg_shape
    least = p.walked_distance_legs if legs else p.walked_distance
    far = math.hypot(away_x, away_y) > least + p.parallax * driven
    # Few returns seen from a moving sensor are little evidence of motion.
    credit = 1.0 - driven * (1.0 - shape_weight)
    # What comes into the view of a driving scanner without a map must look like a person.
    least_shape = p.walking_shape if scan.same_view else p.walking_shape_driven
    known = track.shape_log_odds > least_shape and (
        age >= (p.walking_age_legs if legs else p.walking_age)
    )
    changed = arrival >= p.static_moved and (arrival > 0.0 or known or not scan.has_changes)
    fast = _is_faster(track, p.walking_speed, 1.0 if legs else 2.0) or (
        # What a driving scanner sees of furniture moves along it, too: at up to twice its speed.
        _keeps_pace(track, max(p.walking_speed, 2.0 * moved / max(age, p.pace_time)), p)
    )
    walks = far and changed and fast
    loss = p.motion_loss if track.has_walked else p.arrival_loss
    motion = track.motion_log_odds + (p.motion_gain * credit if walks else -loss)
    motion = max(motion, arrival * credit)
    # Not max(): a lower bound without a sign, −0 becomes 0.
    track.motion_log_odds = min(motion, _MAX_MOTION) if motion > 0.0 else 0.0
    return bool(walks)


@njit(**CACHED)
def _update_pace(track: Any, time: float, p: TrackerParameters) -> None:
    """Update the running mean of the velocity, in place; call it before ``last_seen``."""
    rate = min((time - track.last_seen) / p.pace_time, 1.0)
    for axis in range(2):
        track.pace[axis] += rate * (track.mean[axis + 2] - track.pace[axis])


@njit(**CACHED)
def _keeps_pace(track: Any, speed: float, p: TrackerParameters) -> bool:
    """Check for a mean speed above ``speed``, m/s, and above twice its standard deviation.

    A displacement over ``pace_time`` has the uncertainty of two positions, not that of the present
    velocity, which counts what a walker may do next.
    """
    squared = track.pace[0] ** 2 + track.pace[1] ** 2
    variance = (track.covariance[0, 0] + track.covariance[1, 1]) / p.pace_time**2
    return bool(squared > speed * speed and squared > 4.0 * variance)


@njit(**CACHED)
def mark_unseen(
    tracks: Tracks, matches: Matches, scan: ScanTable, step: float, window: int
) -> None:
    """Update unseen times, weighted by visibility, and the history of detections, in place.

    Args:
        tracks: (m,).
        matches: of tracks and possible people.
        scan: the scan.
        step: time since the last scan, s.
        window: number of scans of the history.
    """
    missed = np.flatnonzero((matches.detection < 0) & ~matches.merged)
    discs = np.empty((len(missed), 3))
    for k in range(len(missed)):
        track = tracks[missed[k]]
        discs[k, 0], discs[k, 1], discs[k, 2] = track.mean[0], track.mean[1], track.radius
    seen_as = visibility(scan.origin, scan.points, scan.free_ends, discs)
    looked = np.ones(len(tracks), dtype=np.bool_)
    for k in range(len(missed)):
        track = tracks[missed[k]]
        track.unseen_time += step * (_TIME_WEIGHT[seen_as[k]] if track.confirmed else 1.0)
        if seen_as[k] == Visibility.SEEN_THROUGH:
            track.seen_through_time += step
        looked[missed[k]] = seen_as[k] != Visibility.OUT_OF_VIEW
    for t in range(len(tracks)):
        track, detected = tracks[t], matches.detection[t] >= 0
        if detected:
            track.unseen_time = track.seen_through_time = 0.0
        # One place on where the scan looked.
        history = (track.detection_history << int(looked[t])) | int(detected)
        track.detection_history = history & ((1 << window) - 1)


@njit(**CACHED)
def mark_doubles(
    tracks: Tracks, found: PersonDetections, matches: Matches, step: float, p: TrackerParameters
) -> None:
    """Update the time for which each track has been beside an older confirmed one, in place.

    Only the second leg of a walker is a double: two people may walk closer together than their
    discs, or share a cluster.

    Args:
        tracks: (m,) by growing id.
        found: possible people of the scan.
        matches: of tracks and possible people.
        step: time since the last scan, s.
        p: the parameters.
    """
    for u in range(len(tracks)):
        j = matches.detection[u]
        if j < 0 and not matches.merged[u]:
            continue
        beside = False
        if j >= 0 and not matches.merged[u] and found.deviation[j] >= p.double_deviation:
            for t in range(u):
                apart_x = tracks[u].mean[0] - tracks[t].mean[0]
                apart_y = tracks[u].mean[1] - tracks[t].mean[1]
                near = math.hypot(apart_x, apart_y) < p.double_distance
                beside = beside or (near and tracks[t].confirmed)
        tracks[u].double_time = tracks[u].double_time + step if beside else 0.0


@njit(**CACHED)
def is_confirmed(
    track: Any,
    detection: int,
    found: PersonDetections,
    time: float,
    same_view: bool,
    p: TrackerParameters,
) -> bool:
    """Confirm or reject a track by detections and evidence, with hysteresis.

    Args:
        track: with the evidence of the scan.
        detection: its index in the scan, or ``NO_MATCH``.
        found: possible people of the scan.
        time: of the scan, s.
        same_view: see ``Detections``.
        p: the parameters.
    """
    odds, hits = log_odds(track), 0
    for k in range(p.window):
        hits += (track.detection_history >> k) & 1
    sure = odds >= p.sure_log_odds and time - track.birth_time >= p.sure_age
    often = hits >= (p.sure_hits if sure else min(p.hits, p.window))
    if track.has_walked:
        is_person = odds >= p.confirm_log_odds
    elif track.motion_log_odds >= p.arrived_log_odds:
        is_person = odds >= p.confirm_log_odds and track.shape_log_odds >= p.arrived_shape
    else:
        torso = detection >= 0 and not found.on_legs[detection]
        looks = p.static_looks_torso if torso else p.static_looks
        is_person = track.shape_log_odds >= p.static_shape and track.shape_looks >= looks
    least = p.reject_log_odds if track.has_walked else p.unmoved_reject_log_odds
    stays = odds > least or track.shape_log_odds > p.static_shape_kept
    # Furniture comes into the view of a driving scanner, and seems to walk.
    if not same_view and track.shape_log_odds <= p.reject_log_odds:
        return False
    return bool((detection >= 0 and often and is_person) or (track.confirmed and stays))


@njit(**CACHED)
def log_odds(track: Any) -> float:
    """ln(p / (1 − p)) that a track is a person."""
    total: float = track.shape_log_odds + track.motion_log_odds + track.static_penalty
    return total


@njit(**CACHED)
def _is_faster(track: Any, speed: float, deviations: float) -> bool:
    """Check for a speed above ``speed``, m/s, and above so many of its standard deviations."""
    squared = track.mean[2] ** 2 + track.mean[3] ** 2
    variance = 0.5 * (track.covariance[2, 2] + track.covariance[3, 3])
    return bool(squared > speed * speed and squared > deviations * deviations * variance)
