"""Tracker of people: batched constant-velocity Kalman filter with optimal assignment."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers, unchecked
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
from cohelm.perception.tracking.kalman import larger_deviation, predict, update
from cohelm.perception.tracking.track_evidence import Matches, update_track_evidence
from cohelm.perception.tracking.tracks import (
    PER_TRACK,
    PersonDetections,
    TrackerParameters,
    TrackerState,
    new_tracks,
    no_tracks,
    person_detections,
)

MAX_STEP = 5.0
"""Longest prediction of the filter at once, s."""
_TIME_WEIGHTS = {
    Visibility.UNCLEAR: 1.0,
    Visibility.SEEN_THROUGH: 3.0,
    Visibility.OCCLUDED: 0.4,
    Visibility.OCCUPIED: 0.6,
    Visibility.OUT_OF_VIEW: 0.6,
}
_TIME_WEIGHT = np.array([_TIME_WEIGHTS[each] for each in Visibility])
"""Weight of a confirmed track's unseen time, by the visibility of its place."""
_UNSEEN_COST = 0.15, 0.35
"""Share of the confidence lost when unseen, and lost with time until a track is not reported."""
_STEADY_NIS, _MANOEUVRE_NIS = 4.0, 10.0
"""Mean NIS up to which a track keeps its process noise, and from which it has all of that of a
manoeuvre. Where the model holds, it is 2."""


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
        self.parameters = parameters or TrackerParameters()

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
            state = self._update(state, scan)
        return self._people(state, now), state

    def _update(self, state: TrackerState, scan: Detections) -> TrackerState:
        """State after one scan."""
        p = self.parameters
        found = person_detections(scan)
        step, time = _elapsed(state.time, found.time), max(state.time, found.time)
        late = min(_elapsed(found.time, state.time), CLOCK_RESET)
        mean, covariance = self._predicted(state, step)
        # A late scan is compared with the positions at its time. The covariance stays that of the
        # present: a scan is late by fractions of a second.
        then = mean.copy()
        then[:, :2] -= late * mean[:, 2:]
        since = time - state.last_seen
        max_cost = -2.0 * math.log(2.0 * math.pi * p.birth_density)
        gates = Gates(p.gate, max_cost, p.match_distance + p.match_distance_growth * since)
        match, mahalanobis_sq = associate(
            then, covariance, state.confirmed, found.position, found.deviation, gates
        )
        missing = (match < 0) & state.confirmed & (since < p.patience)
        partner = merged_partners(then, missing, match, found.position, found.radius, p.separation)
        track, place, deviation = measured_positions(
            then, match, partner, found.position, found.deviation
        )
        # An improbable match inflates the covariance: the track has manoeuvred.
        inflation = np.maximum(mahalanobis_sq[track] / p.gate, 1.0)[:, None, None]
        mean[track], covariance[track] = update(
            mean[track], inflation * covariance[track], place + late * mean[track, 2:], deviation
        )
        merged = partner >= 0
        merged[partner[merged]] = True
        matches = Matches(match, mahalanobis_sq, merged)
        tracks = update_track_evidence(state, mean, covariance, found, matches, p)
        tracks = self._mark_unseen(tracks, scan, matches, step)
        tracks = self._confirm(tracks, matches, time)
        return self._births_and_deaths(tracks, found, matches, time)

    def _predicted(self, state: TrackerState, step: float) -> tuple[Floats, Floats]:
        """Mean and covariance ``step`` later; q grows with the mean NIS."""
        p = self.parameters
        share = np.clip((state.nis - _STEADY_NIS) / (_MANOEUVRE_NIS - _STEADY_NIS), 0.0, 1.0)
        q = p.process_noise + share * max(p.manoeuvre_process_noise - p.process_noise, 0.0)
        unseen = min(p.unseen_process_noise, p.process_noise)
        q = np.where(state.last_seen < state.time, unseen, q)
        return predict(state.mean, state.covariance, np.full(len(state), step), q)

    def _mark_unseen(
        self, tracks: TrackerState, scan: Detections, matches: Matches, step: float
    ) -> TrackerState:
        """Add the unseen time of undetected tracks, weighted by visibility."""
        detected = matches.detected
        missed = np.flatnonzero(~detected & ~matches.merged)
        discs = np.column_stack([tracks.mean[missed, :2], tracks.radius[missed]])
        state = visibility(scan.origin, scan.points, scan.free_ends, discs)
        weight = np.where(tracks.confirmed[missed], _TIME_WEIGHT[state], 1.0)
        unseen = np.where(detected, 0.0, tracks.unseen_time)
        seen_through = np.where(detected, 0.0, tracks.seen_through_time)
        unseen[missed] += step * weight
        seen_through[missed] += step * (state == Visibility.SEEN_THROUGH)
        looked = np.ones(len(tracks), dtype=np.bool_)
        looked[missed] = state != Visibility.OUT_OF_VIEW
        return unchecked(
            tracks,
            unseen_time=unseen,
            seen_through_time=seen_through,
            detection_history=self._shifted_history(tracks.detection_history, looked, detected),
        )

    def _shifted_history(self, history: Integers, looked: Booleans, detected: Booleans) -> Integers:
        """Bits (m,) of the last scans, one place on where a scan looked."""
        shifted: Integers = (history << looked) | detected
        return shifted & ((1 << self.parameters.window) - 1)

    def _confirm(self, tracks: TrackerState, matches: Matches, time: float) -> TrackerState:
        """Confirm or reject tracks by detections and evidence, with hysteresis."""
        p = self.parameters
        odds, shape = tracks.log_odds, tracks.shape_log_odds
        hits = np.bitwise_count(tracks.detection_history)
        sure = (odds >= p.sure_log_odds) & (time - tracks.birth_time >= p.sure_age)
        often = hits >= np.where(sure, p.sure_hits, min(p.hits, p.window))
        arrived = tracks.has_walked | (tracks.motion_log_odds >= p.arrived_log_odds)
        static = (shape >= p.static_shape) & (tracks.shape_looks >= p.static_looks)
        is_person = np.where(arrived, odds >= p.confirm_log_odds, static)
        least = np.where(tracks.has_walked, p.reject_log_odds, p.unmoved_reject_log_odds)
        stays = (odds > least) | (shape > p.static_shape_kept)
        confirmed = (matches.detected & often & is_person) | (tracks.confirmed & stays)
        return unchecked(tracks, confirmed=confirmed)

    def _births_and_deaths(
        self, tracks: TrackerState, found: PersonDetections, matches: Matches, time: float
    ) -> TrackerState:
        """Delete tracks that are unseen for too long; start tracks from unmatched detections."""
        p = self.parameters
        detected = matches.detected
        new = np.ones(len(found), dtype=np.bool_)
        new[matches.detection[detected]] = False
        new[new] = ~_is_near(found.position[new], tracks.mean[detected, :2], p.separation)
        patience = np.where(tracks.confirmed, p.patience, p.tentative_patience)
        alive = tracks.unseen_time <= patience
        count = int(new.sum())
        rows = {name: getattr(tracks, name) for name in PER_TRACK}
        if not alive.all():
            rows = {name: row[alive] for name, row in rows.items()}
        if count:
            born = new_tracks(found, new, tracks.next_id, p.speed_deviation)
            if time - tracks.time >= p.single_hit_interval:
                odds = born["shape_log_odds"] + born["motion_log_odds"]
                sure = (born["shape_looks"] >= 1.0) & (born["motion_log_odds"] >= p.sure_log_odds)
                born["confirmed"] = sure & (odds >= p.sure_log_odds)
            rows = {name: np.concatenate([row, born[name]]) for name, row in rows.items()}
        return TrackerState(time=time, next_id=tracks.next_id + count, **rows)

    def _people(self, state: TrackerState, now: float) -> People:
        """Confirmed tracks at ``now`` whose place is known."""
        p = self.parameters
        ahead = _elapsed(state.time, now)
        mean, covariance = self._predicted(state, ahead)
        report = state.confirmed & (state.unseen_time + ahead <= p.report_unseen)
        report &= state.seen_through_time <= p.report_seen_through
        report &= larger_deviation(covariance[:, :2, :2]) <= p.report_deviation
        sure = 1.0 / (1.0 + np.exp(-state.log_odds[report]))
        unseen = state.unseen_time[report]
        cost = _UNSEEN_COST[0] * (unseen > 0.0)
        cost = cost + _UNSEEN_COST[1] * np.minimum(unseen / p.report_unseen, 1.0)
        return People(
            time=now,
            id=state.id[report],
            mean=mean[report],
            covariance=covariance[report],
            heading=state.heading[report],
            radius=state.radius[report],
            confidence=sure * (1.0 - cost),
        )


def _elapsed(before: float, now: float) -> float:
    """Elapsed time, s; 0 if the clock stands, runs back or is not a number."""
    return min(now - before, MAX_STEP) if now > before else 0.0


def _is_near(a: Floats, b: Floats, distance: float) -> Booleans:
    """Mask of ``a`` (d, 2) with one of ``b`` (m, 2) within ``distance``; (d,)."""
    offset = a[:, None, :] - b[None, :, :]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) < distance, axis=1)
    return near
