"""Tracker of people: constant-velocity Kalman filters with optimal assignment, in one kernel.

Evidence that tracks are people: walking, shape, rest and visibility.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers, sealed
from cohelm.config import number_record
from cohelm.kernels import CACHED, callee
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.sensor_clocks import CLOCK_RESET
from cohelm.perception.tracking.association import (
    Gates,
    Visibility,
    associate,
    measured_positions,
    merged_partners,
    visibility,
)
from cohelm.perception.tracking.kalman import larger_axis, predict_state, update_state
from cohelm.perception.tracking.person_detections import (
    PersonDetections,
    ScanTable,
    person_detections,
    scan_table,
)
from cohelm.perception.tracking.tracks import (
    TRACK,
    TrackerParameters,
    TrackerState,
    Tracks,
    no_tracks,
    start_track,
)

_RADIUS_RATE = 0.2
"""Weight of the latest observation in the running mean of the radius."""
_MAX_MOTION = 5.0
"""Bound of the log-odds of motion."""
_STATIC_FROM, _STATIC_GAIN = -1.0, 2.0
"""Log-odds of arrival below which a detection is punished for standing still, and the factor of
what is below. A cloud's detection whose place was never seen empty has −0.9 and stays unpunished:
it may be a standing person."""
_WINDOW = 5
"""Scans for the count of ``hits``."""
_PAUSE = 0.5
"""Time between scans from which one detection confirms, s."""
_PARALLAX_DRIVEN = 0.5
"""Motion of the sensor after which it may see other faces of an object, m."""
_TENTATIVE_PATIENCE = 0.35
"""Unseen time after which a tentative track is deleted, s: three scans at 10 Hz."""
_GATE = 13.8
"""Largest squared Mahalanobis distance of a match (χ², 2 degrees of freedom, 99.9 %)."""
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
    merged: Booleans
    """(m,) True for both of two people who share a cluster."""


@callee()
def update_evidence(
    tracks: Tracks,
    found: PersonDetections,
    matches: Matches,
    scan: ScanTable,
    p: TrackerParameters,
) -> None:
    """Update the evidence of detected tracks, whose states are those after the scan, in place.

    A cluster of two people says nothing about the size or shape of either.

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
        walks = _update_motion(track, found.arrival_log_odds[j], found.shape_weight[j], scan, p)
        if not matches.merged[t]:
            weight = found.shape_weight[j]
            track.radius += _RADIUS_RATE * (found.radius[j] - track.radius)
            track.shape_looks += weight
            rate = weight * max(p.shape_rate, 1.0 / track.shape_looks) if weight > 0.0 else 0.0
            track.shape_log_odds += rate * (found.log_odds[j] - track.shape_log_odds)
        penalty = _STATIC_GAIN * min(found.arrival_log_odds[j] - _STATIC_FROM, 0.0)
        track.static_penalty += p.shape_rate * (penalty - track.static_penalty)
        track.last_seen = scan.time
        track.has_walked = track.has_walked or walks
        if math.hypot(track.mean[2], track.mean[3]) > p.walking_speed:
            track.heading = math.atan2(track.mean[3], track.mean[2])


@callee()
def _update_motion(
    track: Any, arrival: float, shape_weight: float, scan: ScanTable, p: TrackerParameters
) -> bool:
    """Update the log-odds of motion, in place; True if the track walks.

    A track walks if it is far enough from its birthplace, and fast, at a place that has changed.

    Args:
        track: the track.
        arrival: log-odds of arrival of its detection.
        shape_weight: of its detection.
        scan: the scan.
        p: the parameters.
    """
    moved_x, moved_y = scan.origin[0] - track.viewpoint[0], scan.origin[1] - track.viewpoint[1]
    driven = min(math.hypot(moved_x, moved_y) / _PARALLAX_DRIVEN, 1.0)
    away_x = track.mean[0] - track.birthplace[0]
    away_y = track.mean[1] - track.birthplace[1]
    far = math.hypot(away_x, away_y) > p.walked_distance * (1.0 + driven)
    # Few returns seen from a moving sensor are little evidence of motion.
    credit = 1.0 - driven * (1.0 - shape_weight)
    old = scan.time - track.birth_time >= p.walking_age
    changed = arrival >= 0.0 and (arrival > 0.0 or old or not scan.has_changes)
    walks = far and changed and math.hypot(track.mean[2], track.mean[3]) > p.walking_speed
    motion = track.motion_log_odds + (p.motion_gain * credit if walks else -p.motion_loss)
    motion = max(motion, arrival * credit)
    # Not max(): a lower bound without a sign, −0 becomes 0.
    track.motion_log_odds = min(motion, _MAX_MOTION) if motion > 0.0 else 0.0
    return bool(walks)


@callee()
def mark_unseen(tracks: Tracks, matches: Matches, scan: ScanTable, step: float) -> None:
    """Update unseen times, weighted by visibility, and the history of detections, in place.

    Args:
        tracks: (m,).
        matches: of tracks and possible people.
        scan: the scan.
        step: time since the last scan, s.
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
        track.seen_through = track.seen_through or seen_as[k] == Visibility.SEEN_THROUGH
        looked[missed[k]] = seen_as[k] != Visibility.OUT_OF_VIEW
    for t in range(len(tracks)):
        track, detected = tracks[t], matches.detection[t] >= 0
        if detected:
            track.unseen_time, track.seen_through = 0.0, False
        # One place on where the scan looked.
        history = (track.detection_history << int(looked[t])) | int(detected)
        track.detection_history = history & ((1 << _WINDOW) - 1)


@callee()
def is_confirmed(
    track: Any, detected: bool, step: float, same_view: bool, p: TrackerParameters
) -> bool:
    """Confirm or reject a track by detections and evidence, with hysteresis.

    Args:
        track: with the evidence of the scan.
        detected: True if the scan shows it.
        step: time since the last scan, s.
        same_view: see ``Detections``.
        p: the parameters.
    """
    # What comes into the view of a driving scanner, and seems to move, must look like a person.
    if not same_view and track.shape_log_odds <= 0.0:
        return False
    odds, hits = log_odds(track), 0
    for k in range(_WINDOW):
        hits += (track.detection_history >> k) & 1
    if track.has_walked:
        is_person = odds >= p.confirm_log_odds
    elif track.motion_log_odds >= p.confirm_log_odds:
        is_person = odds >= p.confirm_log_odds and track.shape_log_odds >= 0.0
    else:
        is_person = track.shape_log_odds >= p.static_shape
    often = hits >= (1 if step >= _PAUSE else p.hits)
    return bool((detected and often and is_person) or (track.confirmed and odds > 0.0))


@callee()
def log_odds(track: Any) -> float:
    """ln(p / (1 − p)) that a track is a person."""
    total: float = track.shape_log_odds + track.motion_log_odds + track.static_penalty
    return total


MAX_STEP = 5.0
"""Longest prediction of the filter at once, s."""
_UNSEEN_COST = 0.15, 0.35
"""Share of the confidence lost when unseen, and lost with time until a track is not reported."""


class KalmanTracker:
    """Constant-velocity tracks in the map frame: the chair's own motion needs no correction.

    A track is confirmed as a person by enough detections and by its shape or its walking; it is
    rejected when its shape contradicts that for long. While unseen, it coasts with growing
    covariance, and is reported as long as its place is known and not seen through. Its id is kept
    longer, and longest while something occludes it. Two people seen as one cluster share its
    detection. The state is kept at the last scan's time and predicted to the observation's.

    A person's confidence is the probability of a person from shape and walking, minus a part for
    unseen time.
    """

    Parameters = TrackerParameters
    uses_change_detection = True

    def __init__(self, parameters: TrackerParameters | None = None) -> None:
        self.parameters = p = parameters or TrackerParameters()
        self._record = number_record(p)

    def track(
        self,
        observation: Observation,
        detections: tuple[Detections, ...],
        memory: TrackerState | None,
    ) -> tuple[People, TrackerState]:
        """See :meth:`Tracker.track`.

        A scan older than the last one used is compared with people's positions at that time; a
        clock reset ends all tracks, and ids are never used again.
        """
        now = observation.time
        scans = sorted(detections, key=lambda d: d.time)
        first = min([now, *(scan.time for scan in scans)])
        state = no_tracks(first) if memory is None else memory
        if now < state.time - CLOCK_RESET:
            state = no_tracks(first, state.next_id)
        for scan in scans:
            tracks, time, next_id = update_tracks(
                state.tracks, state.time, state.next_id, scan_table(scan), self._record
            )
            tracks.flags.writeable = False
            state = TrackerState(time=time, next_id=next_id, tracks=tracks)
        found = report_people(state.tracks, state.time, now, self._record)
        return People(time=now, **sealed(found)._asdict()), state


class PersonTable(NamedTuple):
    """Reported people: the columns of ``People``."""

    id: Integers
    mean: Floats
    covariance: Floats
    heading: Floats
    radius: Floats
    confidence: Floats


@njit(**CACHED)
def update_tracks(
    tracks: Tracks, time: float, next_id: int, scan: ScanTable, p: TrackerParameters
) -> tuple[Tracks, float, int]:
    """Update tracks with one scan; also return the new time and the next unused id.

    Args:
        tracks: (m,) at ``time``.
        time: of the last scan, s.
        next_id: larger than any id used so far.
        scan: the scan.
        p: the parameters.
    """
    found = person_detections(scan)
    step, now = _elapsed(time, scan.time), max(time, scan.time)
    late = min(_elapsed(scan.time, time), CLOCK_RESET)
    mean, covariance = _predicted(tracks, step, p)
    matches = _correct(tracks, mean, covariance, found, (now, late), p)
    # The known tracks after the scan.
    known = tracks.copy()
    for t in range(len(known)):
        known[t].mean[:] = mean[t]
        known[t].covariance[:] = covariance[t]
    update_evidence(known, found, matches, scan, p)
    mark_unseen(known, matches, scan, step)
    alive = np.empty(len(known), dtype=np.bool_)
    for t in range(len(known)):
        detected = matches.detection[t] >= 0
        known[t].confirmed = is_confirmed(known[t], detected, step, scan.same_view, p)
        patience = p.patience if known[t].confirmed else _TENTATIVE_PATIENCE
        alive[t] = known[t].unseen_time <= patience
    # Deaths, then births.
    new, n = _unexplained(found, matches, mean, p.separation), alive.sum()
    out = np.zeros(n + new.sum(), TRACK)
    out[:n] = known[alive]
    for j in range(len(new)):
        if new[j]:
            start_track(out[n], next_id, found, j, scan)
            out[n].confirmed = is_confirmed(out[n], True, step, scan.same_view, p)
            n, next_id = n + 1, next_id + 1
    return out, now, next_id


@njit(**CACHED)
def report_people(tracks: Tracks, time: float, now: float, p: TrackerParameters) -> PersonTable:
    """Confirmed tracks at ``now`` whose place is known.

    Args:
        tracks: (m,) at ``time``.
        time: of the last scan, s.
        now: s.
        p: the parameters.
    """
    ahead = _elapsed(time, now)
    mean, covariance = _predicted(tracks, ahead, p)
    m, n = len(tracks), 0
    out = PersonTable(
        np.empty(m, dtype=np.int64), mean, covariance, np.empty(m), np.empty(m), np.empty(m)
    )
    for t in range(m):
        track, P = tracks[t], covariance[t]
        unseen = track.unseen_time
        if not track.confirmed or track.seen_through or not unseen + ahead <= p.patience:
            continue
        if not larger_axis(P[0, 0], P[0, 1], P[1, 1]) <= p.report_deviation:
            continue
        # Rows move up to the place of those that are not reported.
        out.id[n], out.mean[n], out.covariance[n] = track.id, mean[t], covariance[t]
        out.heading[n], out.radius[n] = track.heading, track.radius
        cost = (_UNSEEN_COST[0] if unseen > 0.0 else 0.0) + _UNSEEN_COST[1] * min(
            unseen / p.patience, 1.0
        )
        out.confidence[n] = 1.0 / (1.0 + math.exp(-log_odds(track))) * (1.0 - cost)
        n += 1
    return PersonTable(
        out.id[:n],
        out.mean[:n],
        out.covariance[:n],
        out.heading[:n],
        out.radius[:n],
        out.confidence[:n],
    )


@callee()
def _elapsed(before: float, now: float) -> float:
    """Elapsed time, s; 0 if the clock stands, runs back or is not a number."""
    return min(now - before, MAX_STEP) if now > before else 0.0


@callee()
def _predicted(tracks: Tracks, step: float, p: TrackerParameters) -> tuple[Floats, Floats]:
    """Mean (m, 4) and covariance (m, 4, 4) ``step`` later."""
    m = len(tracks)
    mean, covariance = np.empty((m, 4)), np.empty((m, 4, 4))
    for t in range(m):
        mean[t], covariance[t] = tracks[t].mean, tracks[t].covariance
        predict_state(mean[t], covariance[t], step, p.process_noise)
    return mean, covariance


@callee()
def _correct(
    tracks: Tracks,
    mean: Floats,
    covariance: Floats,
    found: PersonDetections,
    times: tuple[float, float],
    p: TrackerParameters,
) -> Matches:
    """Match the tracks, and update their predicted states with the detections, in place.

    A late scan is compared with the positions at its time. The covariance stays that of the
    present: a scan is late by fractions of a second.

    Args:
        tracks: (m,) before the scan.
        mean, covariance: predicted, (m, 4) and (m, 4, 4).
        found: possible people of the scan.
        times: (time of the tracks after the scan, lateness of the scan), s.
        p: the parameters.
    """
    (now, late), m = times, len(tracks)
    then = mean.copy()
    confirmed, missing = np.empty(m, dtype=np.bool_), np.empty(m, dtype=np.bool_)
    for t in range(m):
        then[t, 0] -= late * mean[t, 2]
        then[t, 1] -= late * mean[t, 3]
        confirmed[t] = tracks[t].confirmed
    max_cost = -2.0 * math.log(2.0 * math.pi * p.birth_density)
    match, mahalanobis_sq = associate(
        then, covariance, confirmed, found.position, found.deviation,
        Gates(_GATE, max_cost, p.match_distance),
    )  # fmt: skip
    for t in range(m):
        missing[t] = match[t] < 0 and confirmed[t] and now - tracks[t].last_seen < p.patience
    partner = merged_partners(
        then, missing, confirmed, match, found.position, found.radius, p.separation
    )
    measured = measured_positions(then, match, partner, found.position, found.deviation)
    for k in range(len(measured.track)):
        t = measured.track[k]
        # An improbable match inflates the covariance: the track has manoeuvred.
        covariance[t] *= max(mahalanobis_sq[t] / _GATE, 1.0)
        measured.position[k, 0] += late * mean[t, 2]
        measured.position[k, 1] += late * mean[t, 3]
        update_state(mean[t], covariance[t], measured.position[k], measured.deviation[k])
    merged = partner >= 0
    for t in range(m):
        if partner[t] >= 0:
            merged[partner[t]] = True
    return Matches(match, merged)


@callee()
def _unexplained(
    found: PersonDetections, matches: Matches, mean: Floats, separation: float
) -> Booleans:
    """Mask (d,) of detections without a track, and without a detected one (m, 4) near them."""
    new = np.ones(len(found.radius), dtype=np.bool_)
    for t in range(len(mean)):
        if matches.detection[t] < 0:
            continue
        new[matches.detection[t]] = False
        for j in range(len(new)):
            dx, dy = found.position[j, 0] - mean[t, 0], found.position[j, 1] - mean[t, 1]
            new[j] = new[j] and not math.hypot(dx, dy) < separation
    return new
