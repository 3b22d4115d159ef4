"""Tracker of people: constant-velocity Kalman filters with optimal assignment, in one kernel.

Evidence that tracks are people: walking, shape, agility, rest and visibility.
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


@callee()
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


@callee()
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


@callee()
def _update_pace(track: Any, time: float, p: TrackerParameters) -> None:
    """Update the running mean of the velocity, in place; call it before ``last_seen``."""
    rate = min((time - track.last_seen) / p.pace_time, 1.0)
    for axis in range(2):
        track.pace[axis] += rate * (track.mean[axis + 2] - track.pace[axis])


@callee()
def _keeps_pace(track: Any, speed: float, p: TrackerParameters) -> bool:
    """Check for a mean speed above ``speed``, m/s, and above twice its standard deviation.

    A displacement over ``pace_time`` has the uncertainty of two positions, not that of the present
    velocity, which counts what a walker may do next.
    """
    squared = track.pace[0] ** 2 + track.pace[1] ** 2
    variance = (track.covariance[0, 0] + track.covariance[1, 1]) / p.pace_time**2
    return bool(squared > speed * speed and squared > 4.0 * variance)


@callee()
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


@callee()
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


@callee()
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


@callee()
def log_odds(track: Any) -> float:
    """ln(p / (1 − p)) that a track is a person."""
    total: float = track.shape_log_odds + track.motion_log_odds + track.static_penalty
    return total


@callee()
def _is_faster(track: Any, speed: float, deviations: float) -> bool:
    """Check for a speed above ``speed``, m/s, and above so many of its standard deviations."""
    squared = track.mean[2] ** 2 + track.mean[3] ** 2
    variance = 0.5 * (track.covariance[2, 2] + track.covariance[3, 3])
    return bool(squared > speed * speed and squared > deviations * deviations * variance)


MAX_STEP = 5.0
"""Longest prediction of the filter at once, s."""
_UNSEEN_COST = 0.15, 0.35
"""Share of the confidence lost when unseen, and lost with time until a track is not reported."""
_STEADY_NIS, _MANOEUVRE_NIS = 4.0, 10.0
"""Mean NIS up to which a track keeps its process noise, and from which it has all of that of a
manoeuvre. Where the model holds, it is 2."""

_ALWAYS_THERE, _AT_REST = -1.5, -0.5
"""Log-odds of arrival up to which an object has always been there, and mean penalty of a track up
to which it is one of these objects itself."""


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
    mean, covariance = _predicted(tracks, time, step, p)
    matches = _correct(tracks, mean, covariance, found, (now, late), p)
    # The known tracks after the scan.
    known = tracks.copy()
    for t in range(len(known)):
        known[t].mean[:] = mean[t]
        known[t].covariance[:] = covariance[t]
    update_evidence(known, found, matches, scan, p)
    mark_unseen(known, matches, scan, step, p.window)
    alive = np.empty(len(known), dtype=np.bool_)
    for t in range(len(known)):
        known[t].confirmed = is_confirmed(
            known[t], matches.detection[t], found, now, scan.same_view, p
        )
        patience = p.patience if known[t].confirmed else p.tentative_patience
        alive[t] = known[t].unseen_time <= patience
    if scan.is_planar:
        mark_doubles(known, found, matches, step, p)
        for t in range(len(known)):
            alive[t] = alive[t] and known[t].double_time <= p.double_time
    # Deaths, then births.
    new, n = _unexplained(found, matches, mean, p.separation), alive.sum()
    out = np.zeros(n + new.sum(), TRACK)
    out[:n] = known[alive]
    for j in range(len(new)):
        if new[j]:
            start_track(out[n], next_id, found, j, scan, p)
            out[n].confirmed = now - time >= p.single_hit_interval and _is_sure(out[n], p)
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
    mean, covariance = _predicted(tracks, time, ahead, p)
    m, n = len(tracks), 0
    out = PersonTable(
        np.empty(m, dtype=np.int64), mean, covariance, np.empty(m), np.empty(m), np.empty(m)
    )
    for t in range(m):
        track, P = tracks[t], covariance[t]
        unseen = track.unseen_time
        if not track.confirmed or not unseen + ahead <= p.report_unseen:
            continue
        if not track.seen_through_time <= p.report_seen_through:
            continue
        if not larger_axis(P[0, 0], P[0, 1], P[1, 1]) <= p.report_deviation:
            continue
        # Rows move up to the place of those that are not reported.
        out.id[n], out.mean[n], out.covariance[n] = track.id, mean[t], covariance[t]
        out.heading[n], out.radius[n] = track.heading, track.radius
        cost = (_UNSEEN_COST[0] if unseen > 0.0 else 0.0) + _UNSEEN_COST[1] * min(
            unseen / p.report_unseen, 1.0
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
def _predicted(
    tracks: Tracks, time: float, step: float, p: TrackerParameters
) -> tuple[Floats, Floats]:
    """Mean (m, 4) and covariance (m, 4, 4) ``step`` later; q grows with the mean NIS."""
    m = len(tracks)
    mean, covariance = np.empty((m, 4)), np.empty((m, 4, 4))
    for t in range(m):
        mean[t], covariance[t] = tracks[t].mean, tracks[t].covariance
        share = (tracks[t].nis - _STEADY_NIS) / (_MANOEUVRE_NIS - _STEADY_NIS)
        share = min(max(share, 0.0), 1.0)
        q = p.process_noise + share * max(p.manoeuvre_process_noise - p.process_noise, 0.0)
        if tracks[t].last_seen < time:
            q = min(p.unseen_process_noise, p.process_noise)
        predict_state(mean[t], covariance[t], step, q)
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
    then, reach = mean.copy(), np.empty(m)
    confirmed, missing = np.empty(m, dtype=np.bool_), np.empty(m, dtype=np.bool_)
    for t in range(m):
        then[t, 0] -= late * mean[t, 2]
        then[t, 1] -= late * mean[t, 3]
        reach[t] = p.match_distance + p.match_distance_growth * (now - tracks[t].last_seen)
        confirmed[t] = tracks[t].confirmed
    gates = Gates(p.gate, -2.0 * math.log(2.0 * math.pi * p.birth_density), reach)
    match, mahalanobis_sq = associate(
        then, covariance, confirmed, found.position, found.deviation, gates,
        _captured_cost(tracks, found, p),
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
        covariance[t] *= max(mahalanobis_sq[t] / p.gate, 1.0)
        measured.position[k, 0] += late * mean[t, 2]
        measured.position[k, 1] += late * mean[t, 3]
        update_state(mean[t], covariance[t], measured.position[k], measured.deviation[k])
    merged = partner >= 0
    for t in range(m):
        if partner[t] >= 0:
            merged[partner[t]] = True
    return Matches(match, mahalanobis_sq, merged)


@callee()
def _captured_cost(tracks: Tracks, found: PersonDetections, p: TrackerParameters) -> Floats:
    """Extra cost (m, d) of matches of walking tracks with objects that were always there."""
    out = np.zeros((len(tracks), len(found.radius)))
    for j in range(len(found.radius)):
        if found.arrival_log_odds[j] > _ALWAYS_THERE:
            continue
        for t in range(len(tracks)):
            if tracks[t].has_walked and tracks[t].static_penalty > _AT_REST:
                out[t, j] = p.captured_cost
    return out


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


@callee()
def _is_sure(track: Any, p: TrackerParameters) -> bool:
    """Check that the first detection of a track leaves little doubt."""
    sure = track.shape_looks >= 1.0 and track.motion_log_odds >= p.sure_log_odds
    return bool(sure and track.shape_log_odds + track.motion_log_odds >= p.sure_log_odds)
