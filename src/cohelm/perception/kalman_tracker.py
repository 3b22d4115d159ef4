"""Tracking people with a batched Kalman filter and optimal assignment."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.association import associate, measurements, merged
from cohelm.perception.kalman import larger_deviation, predict, update
from cohelm.perception.sight import FILLED, HIDDEN, SEEN_THROUGH, UNCLEAR, UNLOOKED, sight
from cohelm.perception.tracker_parameters import TrackerParameters
from cohelm.perception.tracks import (
    PER_TRACK,
    Sightings,
    TrackerState,
    newborn,
    no_tracks,
    sightings,
)

LONGEST_STEP = 5.0
"""A filter is never predicted farther than this at once, s."""
BACKWARDS = 1.0
"""A clock that ran back by more than this started anew, s."""
_PACE = np.zeros(5)
_PACE[[UNCLEAR, SEEN_THROUGH, HIDDEN, FILLED, UNLOOKED]] = 1.0, 3.0, 0.4, 0.6, 0.6
"""How fast a person's time unseen counts, by what was seen in the place."""

_UNSEEN = 0.15, 0.35
"""Share of the confidence lost by not being seen at all, and by the time until nobody is told."""

_CHANGED = ("radius", "shape", "looks", "surprise", "seen", "absent", "passed", "rest", "walked")
"""What of a track is changed in place while a scan is worked in."""


class KalmanTracker:
    """Constant-velocity tracks in the map frame: the chair's own motion needs no correction.

    A track is told as a person when it was seen often enough and when its shape, or its walking,
    makes it one; it is taken back when its shape speaks against it for long. Unseen, it coasts with
    growing covariance and is told as long as its place is known and not seen through; its id is
    kept for longer, and longest where something hides it. Two who are seen as one cluster both go
    on with what they share. The state is kept at the last scan's time
    and predicted to the observation's.

    A person's confidence is the probability of a person that shape and walking give, less what time
    unseen takes from it.
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

        A scan older than the last one used is compared with where people were then; a clock that
        runs back by more than a second ends all tracks, and ids are never used again.
        """
        now = observation.time
        scans = sorted(detections, key=lambda d: d.time)
        first = min([now, *(seen.time for seen in scans)])
        state = no_tracks(first) if memory is None else memory
        if now < state.time - BACKWARDS:
            state = no_tracks(first, state.next_id)
        for seen in scans:
            state = self._see(state, seen)
        return self._people(state, now), state

    def _see(self, state: TrackerState, scan: Detections) -> TrackerState:
        """``state`` after one scan."""
        p = self.parameters
        seen = sightings(scan)
        step, time = _elapsed(state.time, seen.time), max(state.time, seen.time)
        late = min(_elapsed(seen.time, state.time), BACKWARDS)
        mean, covariance = self._predicted(state, step)
        then = mean.copy()
        then[:, :2] -= late * mean[:, 2:]
        since = time - state.seen
        match, squared = associate(
            then,
            covariance,
            state.confirmed,
            seen.position,
            seen.deviation,
            gate=p.gate,
            dearest=-2.0 * math.log(2.0 * math.pi * p.strangers),
            reach=p.farthest + p.straying * since,
        )
        lonely = (match < 0) & state.confirmed & (since < p.patience)
        partner = merged(then, lonely, match, seen.position, seen.radius, p.separation)
        who, place, deviation = measurements(then, match, partner, seen.position, seen.deviation)
        doubt = np.maximum(squared[who] / p.gate, 1.0)[:, None, None]
        mean[who], covariance[who] = update(
            mean[who], doubt * covariance[who], place + late * mean[who, 2:], deviation
        )
        met = partner >= 0
        met[partner[met]] = True
        tracks = self._judged(state, seen, mean, covariance, match=match, squared=squared, met=met)
        self._miss(tracks, scan, match, met, step)
        self._decide(tracks, match, time)
        return self._turnover(state, seen, tracks, match, time)

    def _predicted(self, state: TrackerState, step: float) -> tuple[Floats, Floats]:
        """Mean and covariance ``step`` later; q grows from a surprise of 4 to one of 10."""
        p = self.parameters
        share = np.clip((state.surprise - 4.0) / 6.0, 0.0, 1.0)
        q = p.agility + share * max(p.surprised_agility - p.agility, 0.0)
        q = np.where(state.seen < state.time, min(p.unseen_agility, p.agility), q)
        return predict(state.mean, state.covariance, np.full(len(state), step), q)

    def _judged(
        self,
        state: TrackerState,
        seen: Sightings,
        mean: Floats,
        covariance: Floats,
        *,
        match: Integers,
        squared: Floats,
        met: Booleans,
    ) -> dict[str, Any]:
        """The fields of the tracks with the evidence of those found; ``met``: seen as one of two.

        A cluster of two says nothing of either's size, shape or agility.
        """
        p = self.parameters
        tracks = {name: getattr(state, name) for name in PER_TRACK}
        for name in _CHANGED:
            tracks[name] = tracks[name].copy()
        found = match >= 0
        driven = np.hypot(*(seen.origin - state.viewpoint).T)
        driven = np.minimum(driven / p.parallax_driven, 1.0)
        farther = p.walked_from + p.parallax * driven
        walked = np.hypot(*(mean[:, :2] - state.birthplace).T) > farther
        walks = walked & _walks(mean, covariance, p.walking_speed)
        moved, told = np.zeros(len(state)), np.ones(len(state))
        moved[found] = seen.moved[match[found]]
        told[found] -= driven[found] * (1.0 - seen.weight[match[found]])
        known = (state.shape > p.walking_shape) & (seen.time - state.born >= p.walking_age)
        walks &= (moved >= p.static_moved) & ((moved > 0.0) | known | (not seen.compared))
        loss = np.where(state.walked, -p.motion_loss, -p.coming_loss)
        motion = state.motion + np.where(walks, p.motion_gain * told, loss) * found
        motion[found] = np.maximum(motion, moved * told)[found]
        whole = np.flatnonzero(found & ~met)
        new = match[whole]
        tracks["radius"][whole] += 0.2 * (seen.radius[new] - state.radius[whole])
        looks = state.looks[whole] + seen.weight[new]
        share = seen.weight[new] * np.maximum(p.shape_rate, 1.0 / looks)
        tracks["shape"][whole] += share * (seen.log_odds[new] - state.shape[whole])
        tracks["looks"][whole] = looks
        tracks["surprise"][whole] += 0.4 * (
            np.minimum(squared[whole], 20.0) - state.surprise[whole]
        )
        cost = 2.0 * np.minimum(seen.moved[match[found]] + 1.0, 0.0)
        tracks["rest"][found] += p.shape_rate * (cost - state.rest[found])
        course = np.arctan2(mean[:, 3], mean[:, 2])
        follows = found & _walks(mean, covariance, p.heading_speed)
        tracks.update(
            mean=mean,
            covariance=covariance,
            heading=np.where(follows, course, state.heading),
            motion=np.clip(motion, 0.0, 5.0),
        )
        tracks["seen"][found] = seen.time
        tracks["walked"] |= found & walks
        return tracks

    def _miss(
        self,
        tracks: dict[str, Any],
        scan: Detections,
        match: Integers,
        met: Booleans,
        step: float,
    ) -> None:
        """Book who was not found, and for how long that counts."""
        missed = np.flatnonzero((match < 0) & ~met)
        discs = np.column_stack([tracks["mean"][missed, :2], tracks["radius"][missed]])
        how = sight(scan.origin, scan.points, scan.through, discs)
        confirmed = tracks["confirmed"][missed]
        tracks["absent"][match >= 0] = tracks["passed"][match >= 0] = 0.0
        tracks["passed"][missed] += step * (how == SEEN_THROUGH)
        tracks["absent"][missed] += step * np.where(confirmed, _PACE[how], 1.0)
        looked = np.ones(len(match), dtype=np.bool_)
        looked[missed] = how != UNLOOKED
        history = (tracks["history"] << looked) | (match >= 0)
        tracks["history"] = history & ((1 << self.parameters.window) - 1)

    def _decide(self, tracks: dict[str, Any], match: Integers, time: float) -> None:
        """Say who is a person: by sightings and evidence, with hysteresis."""
        p = self.parameters
        odds = tracks["shape"] + tracks["motion"] + tracks["rest"]
        hits = np.bitwise_count(tracks["history"])
        sure = (odds >= p.sure_from) & (time - tracks["born"] >= p.youngest)
        often = hits >= np.where(sure, p.sure_hits, min(p.hits, p.window))
        came = tracks["walked"] | (tracks["motion"] >= p.came_from)
        shapely = (tracks["shape"] >= p.still_from) & (tracks["looks"] >= p.still_looks)
        rises = (match >= 0) & often & np.where(came, odds >= p.person_from, shapely)
        least = np.where(tracks["walked"], p.static_from, p.unproven_from)
        stays = (odds > least) | (tracks["shape"] > p.still_least)
        tracks["confirmed"] = rises | (tracks["confirmed"] & stays)

    def _turnover(
        self,
        state: TrackerState,
        seen: Sightings,
        tracks: dict[str, Any],
        match: Integers,
        time: float,
    ) -> TrackerState:
        """The tracks that live on, and those born of what is nobody's."""
        p = self.parameters
        found = match >= 0
        new = np.ones(len(seen), dtype=np.bool_)
        new[match[found]] = False
        new[new] = ~_near(seen.position[new], tracks["mean"][found, :2], p.separation)
        patience = np.where(tracks["confirmed"], p.patience, p.tentative_patience)
        alive = tracks["absent"] <= patience
        count = int(new.sum())
        if not alive.all():
            tracks = {name: tracks[name][alive] for name in PER_TRACK}
        if count:
            born = newborn(seen, new, state.next_id, p.speed_deviation)
            if time - state.time >= p.seldom:
                odds = born["shape"] + born["motion"]
                sure = (born["looks"] >= 1.0) & (born["motion"] >= p.sure_from)
                born["confirmed"] = sure & (odds >= p.sure_from)
            tracks = {name: np.concatenate([tracks[name], born[name]]) for name in PER_TRACK}
        return TrackerState(time=time, next_id=state.next_id + count, **tracks)

    def _people(self, state: TrackerState, now: float) -> People:
        """The confirmed tracks at ``now`` whose place is known."""
        p = self.parameters
        ahead = _elapsed(state.time, now)
        mean, covariance = self._predicted(state, ahead)
        told = state.confirmed & (state.absent + ahead <= p.told_absent)
        told &= state.passed <= p.told_passed
        told &= larger_deviation(covariance[:, :2, :2]) <= p.told_deviation
        sure = 1.0 / (1.0 + np.exp(-state.log_odds[told]))
        absent = state.absent[told]
        unseen = _UNSEEN[0] * (absent > 0.0) + _UNSEEN[1] * np.minimum(absent / p.told_absent, 1.0)
        return People(
            time=now,
            id=state.id[told],
            mean=mean[told],
            covariance=covariance[told],
            heading=state.heading[told],
            radius=state.radius[told],
            confidence=sure * (1.0 - unseen),
        )


def _elapsed(before: float, now: float) -> float:
    """s, 0 where the clock stands, runs back or is not a number."""
    return min(now - before, LONGEST_STEP) if now > before else 0.0


def _walks(mean: Floats, covariance: Floats, least: float) -> Booleans:
    """Whose speed is above ``least``, m/s, and above twice its standard deviation; (m,)."""
    squared = mean[:, 2] ** 2 + mean[:, 3] ** 2
    variance = 0.5 * (covariance[:, 2, 2] + covariance[:, 3, 3])
    walks: Booleans = (squared > least * least) & (squared > 4.0 * variance)
    return walks


def _near(a: Floats, b: Floats, distance: float) -> Booleans:
    """Which of ``a`` (d, 2) have one of ``b`` (m, 2) within ``distance``; (d,)."""
    offset = a[:, None, :] - b[None, :, :]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) < distance, axis=1)
    return near
