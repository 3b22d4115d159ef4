"""Tracker of people: batched constant-velocity Kalman filter with optimal assignment."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.sensor_clocks import CLOCK_RESET
from cohelm.perception.tracking.association import (
    OCCLUDED,
    OCCUPIED,
    OUT_OF_VIEW,
    SEEN_THROUGH,
    UNCLEAR,
    Gates,
    associate,
    measurements,
    merged_partners,
    visibility,
)
from cohelm.perception.tracking.kalman import larger_deviation, predict, update
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
_TIME_WEIGHT = np.zeros(5)
_TIME_WEIGHT[[UNCLEAR, SEEN_THROUGH, OCCLUDED, OCCUPIED, OUT_OF_VIEW]] = 1.0, 3.0, 0.4, 0.6, 0.6
"""Weight of a confirmed track's unseen time, by the visibility of its place."""
_UNSEEN_COST = 0.15, 0.35
"""Share of the confidence lost when unseen, and lost with time until a track is not reported."""
_MUTABLE = ("radius", "shape", "looks", "nis", "seen", "unseen", "seen_through", "rest", "walked")
"""Fields of tracks that one scan changes in place."""


class _Matches(NamedTuple):
    """Detections of m tracks in one scan."""

    match: Integers
    """(m,) index of the detection, or ``NO_MATCH``."""
    squared: Floats
    """(m,) its eᵀ S⁻¹ e."""
    merged: Booleans
    """(m,) True for both of two people who share a cluster."""


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
        """``state`` after one scan."""
        p = self.parameters
        found = person_detections(scan)
        step, time = _elapsed(state.time, found.time), max(state.time, found.time)
        late = min(_elapsed(found.time, state.time), CLOCK_RESET)
        mean, covariance = self._predicted(state, step)
        then = mean.copy()
        then[:, :2] -= late * mean[:, 2:]
        since = time - state.seen
        max_cost = -2.0 * math.log(2.0 * math.pi * p.birth_density)
        gates = Gates(p.gate, max_cost, p.match_distance + p.match_distance_growth * since)
        match, squared = associate(
            then, covariance, state.confirmed, found.position, found.deviation, gates
        )
        missing = (match < 0) & state.confirmed & (since < p.patience)
        partner = merged_partners(then, missing, match, found.position, found.radius, p.separation)
        track, place, deviation = measurements(
            then, match, partner, found.position, found.deviation
        )
        # An improbable match inflates the covariance: the track has manoeuvred.
        doubt = np.maximum(squared[track] / p.gate, 1.0)[:, None, None]
        mean[track], covariance[track] = update(
            mean[track], doubt * covariance[track], place + late * mean[track, 2:], deviation
        )
        merged = partner >= 0
        merged[partner[merged]] = True
        matches = _Matches(match, squared, merged)
        tracks = self._with_evidence(state, found, mean, covariance, matches)
        self._mark_unseen(tracks, scan, matches, step)
        self._confirm(tracks, match, time)
        return self._births_and_deaths(state, found, tracks, match, time)

    def _predicted(self, state: TrackerState, step: float) -> tuple[Floats, Floats]:
        """Mean and covariance ``step`` later; q grows from a mean NIS of 4 to one of 10."""
        p = self.parameters
        share = np.clip((state.nis - 4.0) / 6.0, 0.0, 1.0)
        q = p.process_noise + share * max(p.manoeuvre_process_noise - p.process_noise, 0.0)
        unseen = min(p.unseen_process_noise, p.process_noise)
        q = np.where(state.seen < state.time, unseen, q)
        return predict(state.mean, state.covariance, np.full(len(state), step), q)

    def _with_evidence(
        self,
        state: TrackerState,
        found: PersonDetections,
        mean: Floats,
        covariance: Floats,
        matches: _Matches,
    ) -> dict[str, Any]:
        """Update the evidence of detected tracks.

        A cluster of two people says nothing about the size, shape or agility of either.
        """
        p = self.parameters
        match, squared = matches.match, matches.squared
        tracks = {name: getattr(state, name) for name in PER_TRACK}
        for name in _MUTABLE:
            tracks[name] = tracks[name].copy()
        detected = match >= 0
        # Walking: far enough from the birthplace, and fast, at a place that has changed.
        driven = np.hypot(*(found.origin - state.viewpoint).T)
        driven = np.minimum(driven / p.parallax_driven, 1.0)
        least = p.walked_distance + p.parallax * driven
        walked = np.hypot(*(mean[:, :2] - state.birthplace).T) > least
        walks = walked & _is_faster(mean, covariance, p.walking_speed)
        moved, credit = np.zeros(len(state)), np.ones(len(state))
        moved[detected] = found.moved[match[detected]]
        credit[detected] -= driven[detected] * (1.0 - found.weight[match[detected]])
        known = (state.shape > p.walking_shape) & (found.time - state.born >= p.walking_age)
        walks &= (moved >= p.static_moved) & ((moved > 0.0) | known | (not found.compared))
        loss = np.where(state.walked, -p.motion_loss, -p.arrival_loss)
        motion = state.motion + np.where(walks, p.motion_gain * credit, loss) * detected
        motion[detected] = np.maximum(motion, moved * credit)[detected]
        # Shape and size, from clusters of one person.
        whole = np.flatnonzero(detected & ~matches.merged)
        new = match[whole]
        tracks["radius"][whole] += 0.2 * (found.radius[new] - state.radius[whole])
        looks = state.looks[whole] + found.weight[new]
        share = found.weight[new] * np.maximum(p.shape_rate, 1.0 / looks)
        tracks["shape"][whole] += share * (found.log_odds[new] - state.shape[whole])
        tracks["looks"][whole] = looks
        tracks["nis"][whole] += 0.4 * (np.minimum(squared[whole], 20.0) - state.nis[whole])
        cost = 2.0 * np.minimum(found.moved[match[detected]] + 1.0, 0.0)
        tracks["rest"][detected] += p.shape_rate * (cost - state.rest[detected])
        course = np.arctan2(mean[:, 3], mean[:, 2])
        follows = detected & _is_faster(mean, covariance, p.heading_speed)
        tracks.update(
            mean=mean,
            covariance=covariance,
            heading=np.where(follows, course, state.heading),
            motion=np.clip(motion, 0.0, 5.0),
        )
        tracks["seen"][detected] = found.time
        tracks["walked"] |= detected & walks
        return tracks

    def _mark_unseen(
        self, tracks: dict[str, Any], scan: Detections, matches: _Matches, step: float
    ) -> None:
        """Add the unseen time of undetected tracks, weighted by visibility."""
        match = matches.match
        missed = np.flatnonzero((match < 0) & ~matches.merged)
        discs = np.column_stack([tracks["mean"][missed, :2], tracks["radius"][missed]])
        state = visibility(scan.origin, scan.points, scan.free_ends, discs)
        confirmed = tracks["confirmed"][missed]
        tracks["unseen"][match >= 0] = tracks["seen_through"][match >= 0] = 0.0
        tracks["seen_through"][missed] += step * (state == SEEN_THROUGH)
        tracks["unseen"][missed] += step * np.where(confirmed, _TIME_WEIGHT[state], 1.0)
        looked = np.ones(len(match), dtype=np.bool_)
        looked[missed] = state != OUT_OF_VIEW
        history = (tracks["history"] << looked) | (match >= 0)
        tracks["history"] = history & ((1 << self.parameters.window) - 1)

    def _confirm(self, tracks: dict[str, Any], match: Integers, time: float) -> None:
        """Confirm or reject tracks by detections and evidence, with hysteresis."""
        p = self.parameters
        odds = tracks["shape"] + tracks["motion"] + tracks["rest"]
        hits = np.bitwise_count(tracks["history"])
        sure = (odds >= p.sure_log_odds) & (time - tracks["born"] >= p.sure_age)
        often = hits >= np.where(sure, p.sure_hits, min(p.hits, p.window))
        arrived = tracks["walked"] | (tracks["motion"] >= p.arrived_log_odds)
        static = (tracks["shape"] >= p.static_shape) & (tracks["looks"] >= p.static_looks)
        rises = (match >= 0) & often & np.where(arrived, odds >= p.confirm_log_odds, static)
        least = np.where(tracks["walked"], p.reject_log_odds, p.unmoved_reject_log_odds)
        stays = (odds > least) | (tracks["shape"] > p.static_shape_kept)
        tracks["confirmed"] = rises | (tracks["confirmed"] & stays)

    def _births_and_deaths(
        self,
        state: TrackerState,
        found: PersonDetections,
        tracks: dict[str, Any],
        match: Integers,
        time: float,
    ) -> TrackerState:
        """Delete tracks that are unseen for too long; start tracks from unmatched detections."""
        p = self.parameters
        detected = match >= 0
        new = np.ones(len(found), dtype=np.bool_)
        new[match[detected]] = False
        new[new] = ~_is_near(found.position[new], tracks["mean"][detected, :2], p.separation)
        patience = np.where(tracks["confirmed"], p.patience, p.tentative_patience)
        alive = tracks["unseen"] <= patience
        count = int(new.sum())
        if not alive.all():
            tracks = {name: tracks[name][alive] for name in PER_TRACK}
        if count:
            born = new_tracks(found, new, state.next_id, p.speed_deviation)
            if time - state.time >= p.single_hit_interval:
                odds = born["shape"] + born["motion"]
                sure = (born["looks"] >= 1.0) & (born["motion"] >= p.sure_log_odds)
                born["confirmed"] = sure & (odds >= p.sure_log_odds)
            tracks = {name: np.concatenate([tracks[name], born[name]]) for name in PER_TRACK}
        return TrackerState(time=time, next_id=state.next_id + count, **tracks)

    def _people(self, state: TrackerState, now: float) -> People:
        """Confirmed tracks at ``now`` whose place is known."""
        p = self.parameters
        ahead = _elapsed(state.time, now)
        mean, covariance = self._predicted(state, ahead)
        report = state.confirmed & (state.unseen + ahead <= p.report_unseen)
        report &= state.seen_through <= p.report_seen_through
        report &= larger_deviation(covariance[:, :2, :2]) <= p.report_deviation
        sure = 1.0 / (1.0 + np.exp(-state.log_odds[report]))
        unseen = state.unseen[report]
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


def _is_faster(mean: Floats, covariance: Floats, speed: float) -> Booleans:
    """Mask (m,) of speeds above ``speed``, m/s, and above twice their standard deviation."""
    squared = mean[:, 2] ** 2 + mean[:, 3] ** 2
    variance = 0.5 * (covariance[:, 2, 2] + covariance[:, 3, 3])
    faster: Booleans = (squared > speed * speed) & (squared > 4.0 * variance)
    return faster


def _is_near(a: Floats, b: Floats, distance: float) -> Booleans:
    """Mask of ``a`` (d, 2) with one of ``b`` (m, 2) within ``distance``; (d,)."""
    offset = a[:, None, :] - b[None, :, :]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) < distance, axis=1)
    return near
