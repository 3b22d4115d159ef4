"""Tracking people with a batched Kalman filter and optimal assignment."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.kalman import predict, update
from cohelm.perception.sight import HIDDEN, SEEN_THROUGH, UNCLEAR, sight
from cohelm.perception.tracks import TrackerState, add, associate, no_tracks, select

LONGEST_STEP = 5.0
"""A filter is never predicted farther than this at once, s."""
BACKWARDS = 1.0
"""A clock that ran back by more than this started anew, s."""
_PACE = np.zeros(3)
_PACE[[UNCLEAR, SEEN_THROUGH, HIDDEN]] = 1.0, 3.0, 0.75
"""How fast time unseen counts, by what was seen in the place."""


class KalmanTracker:
    """Constant-velocity tracks in the map frame: the chair's own motion needs no correction.

    A track is told as a person when it was seen often enough and when its shape, or its walking,
    makes it one; it is taken back when its shape speaks against it for long. Unseen, it coasts with
    growing covariance; it is given up sooner where beams pass through its place than where
    something nearer hides it. The state is kept at the last scan's time and predicted to the
    observation's.
    """

    class Parameters(Model):
        """Of the tracker; assumed where no reason is given."""

        agility: float = Field(0.3, gt=0.0, le=10.0)
        """q, intensity of the white acceleration, m²/s³: √0.3 m/s wandering in a second."""
        surprised_agility: float = Field(2.0, gt=0.0, le=50.0)
        """q of a track whose innovations are far larger than expected (it turns), m²/s³."""
        speed_deviation: float = Field(1.0, gt=0.0, le=5.0)
        """Standard deviation of a new track's velocity on each axis, m/s."""
        gate: float = Field(13.8, gt=0.0, le=100.0)
        """Largest squared Mahalanobis distance of a match (χ², 2 degrees of freedom, 99.9 %)."""
        farthest: float = Field(1.0, gt=0.0, le=10.0)
        """Largest distance of a match, m."""
        separation: float = Field(0.35, ge=0.0, le=2.0)
        """No track is born this near one that was just seen, m."""
        hits: int = Field(3, ge=1, le=20)
        """Sightings among the last ``window`` scans that confirm a track."""
        window: int = Field(5, ge=1, le=20)
        """Scans that ``hits`` looks back on."""
        person_from: float = Field(1.0, ge=-5.0, le=5.0)
        """Log-odds of a person that confirm a track (1.0: 73 %)."""
        static_from: float = Field(-1.0, ge=-5.0, le=5.0)
        """Log-odds below which a confirmed track is no person any more."""
        shape_rate: float = Field(0.3, gt=0.0, le=1.0)
        """Share of the latest look in the running mean of the shape's log-odds: looks at one shape
        are not independent, so they do not add up."""
        motion_gain: float = Field(1.0, ge=0.0, le=5.0)
        """Log-odds gained per sighting of something that walks; at most 5."""
        motion_loss: float = Field(0.2, ge=0.0, le=5.0)
        """Log-odds lost again per sighting at rest."""
        walked_from: float = Field(0.4, ge=0.0, le=5.0)
        """Distance from its birthplace at which something has walked, m."""
        walking_speed: float = Field(0.3, ge=0.0, le=3.0)
        """Least speed of something that walks, m/s."""
        heading_speed: float = Field(0.2, ge=0.0, le=3.0)
        """Least speed at which the heading follows the motion, m/s."""
        patience: float = Field(1.2, gt=0.0, le=20.0)
        """A confirmed track is given up after so long unseen, s; hidden time counts three
        quarters, time in which its place was seen through threefold."""
        tentative_patience: float = Field(0.35, gt=0.0, le=20.0)
        """The same for a tentative one, s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def track(
        self,
        observation: Observation,
        detections: tuple[Detections, ...],
        memory: TrackerState | None,
    ) -> tuple[People, TrackerState]:
        """See :meth:`Tracker.track`.

        A scan older than the last one used counts as taken together with it; a clock that runs back
        by more than a second ends all tracks, and ids are never used again.
        """
        now = observation.time
        state = memory or no_tracks(now)
        if now < state.time - BACKWARDS:
            state = no_tracks(now, state.next_id)
        for seen in sorted(detections, key=lambda d: d.time):
            state = self._see(state, seen)
        return self._people(state, now), state

    def _see(self, state: TrackerState, seen: Detections) -> TrackerState:
        p = self.parameters
        dt = _elapsed(state.time, seen.time)
        state = self._advance(state, dt, max(state.time, seen.time))
        tracks, found, squared = associate(
            state, seen.position, seen.deviation, gate=p.gate, farthest=p.farthest
        )
        matched = np.zeros(len(state), dtype=np.bool_)
        matched[tracks] = True
        state = self._correct(state, seen, tracks, found, squared)
        state = self._miss(state, seen, ~matched, dt)
        state = self._decide(state, matched)
        new = np.ones(len(seen.position), dtype=np.bool_)
        new[found] = False
        new &= ~_near(seen.position, state.mean[matched, :2], p.separation)
        alive = state.absent <= np.where(state.confirmed, p.patience, p.tentative_patience)
        return add(
            select(state, alive),
            position=seen.position[new],
            deviation=seen.deviation[new],
            radius=seen.radius[new],
            shape=_log_odds(seen.confidence[new]),
            speed_deviation=p.speed_deviation,
        )

    def _advance(self, state: TrackerState, dt: float, time: float) -> TrackerState:
        mean, covariance = predict(
            state.mean, state.covariance, np.full(len(state), dt), self._agility(state)
        )
        return replace(state, time=time, mean=mean, covariance=covariance)

    def _agility(self, state: TrackerState) -> Floats:
        """The q of each track (m,): grows from a surprise of 4 to one of 10."""
        p = self.parameters
        share = np.clip((state.surprise - 4.0) / 6.0, 0.0, 1.0)
        return p.agility + share * max(p.surprised_agility - p.agility, 0.0)

    def _correct(
        self,
        state: TrackerState,
        seen: Detections,
        tracks: Integers,
        found: Integers,
        squared: Floats,
    ) -> TrackerState:
        """``state`` after the matched measurements."""
        p = self.parameters
        mean, covariance = state.mean.copy(), state.covariance.copy()
        doubt = np.maximum(squared / p.gate, 1.0)[:, None, None]
        mean[tracks], covariance[tracks] = update(
            mean[tracks], doubt * covariance[tracks], seen.position[found], seen.deviation[found]
        )
        radius, surprise = state.radius.copy(), state.surprise.copy()
        radius[tracks] += 0.2 * (seen.radius[found] - radius[tracks])
        surprise[tracks] += 0.4 * (np.minimum(squared, 20.0) - surprise[tracks])
        heading = np.where(_walks(mean, covariance, p.heading_speed), _course(mean), state.heading)
        state = replace(
            state,
            mean=mean,
            covariance=covariance,
            heading=heading,
            radius=radius,
            surprise=surprise,
        )
        return self._judge(state, tracks, _log_odds(seen.confidence[found]))

    def _judge(self, state: TrackerState, tracks: Integers, shape_now: Floats) -> TrackerState:
        """``state`` with the evidence of a sighting of ``tracks`` (k,)."""
        p = self.parameters
        walked = np.hypot(*(state.mean[:, :2] - state.birthplace).T) > p.walked_from
        walks = (walked & _walks(state.mean, state.covariance, p.walking_speed))[tracks]
        shape, motion, absent = state.shape.copy(), state.motion.copy(), state.absent.copy()
        shape[tracks] += p.shape_rate * (shape_now - shape[tracks])
        motion[tracks] += np.where(walks, p.motion_gain, -p.motion_loss)
        absent[tracks] = 0.0
        history = state.history << 1
        history[tracks] |= 1
        return replace(
            state,
            shape=shape,
            motion=np.clip(motion, 0.0, 5.0),
            history=history & ((1 << p.window) - 1),
            absent=absent,
        )

    def _miss(
        self, state: TrackerState, seen: Detections, missed: Booleans, dt: float
    ) -> TrackerState:
        """``state`` with the time added for which the ``missed`` were not seen."""
        discs = np.concatenate([state.mean[missed, :2], state.radius[missed, None]], axis=1)
        how = sight(seen.origin, seen.points, seen.through, discs)
        absent = state.absent.copy()
        absent[missed] += dt * _PACE[how]
        return replace(state, absent=absent)

    def _decide(self, state: TrackerState, matched: Booleans) -> TrackerState:
        """Who is a person: by sightings and evidence, with hysteresis."""
        p = self.parameters
        often = np.bitwise_count(state.history) >= min(p.hits, p.window)
        rises = matched & often & (state.log_odds >= p.person_from)
        stays = state.confirmed & (state.log_odds > p.static_from)
        return replace(state, confirmed=rises | stays)

    def _people(self, state: TrackerState, now: float) -> People:
        """The confirmed tracks at ``now``."""
        p = self.parameters
        ahead = _elapsed(state.time, now)
        told = select(state, state.confirmed & (state.absent + ahead <= p.patience + 0.1))
        told = self._advance(told, ahead, now)
        sure = 1.0 / (1.0 + np.exp(-told.log_odds))
        return People(
            time=now,
            id=told.id,
            mean=told.mean,
            covariance=told.covariance,
            heading=told.heading,
            radius=told.radius,
            confidence=sure * (1.0 - 0.5 * np.minimum(told.absent / p.patience, 1.0)),
        )


def _elapsed(before: float, now: float) -> float:
    """s, 0 where the clock stands, runs back or is not a number."""
    return min(now - before, LONGEST_STEP) if now > before else 0.0


def _log_odds(probability: Floats) -> Floats:
    p = np.clip(probability, 0.01, 0.99)
    odds: Floats = np.log(p / (1.0 - p))
    return odds


def _walks(mean: Floats, covariance: Floats, least: float) -> Booleans:
    """Whose speed is above ``least``, m/s, and above twice its standard deviation; (m,)."""
    speed = np.hypot(mean[:, 2], mean[:, 3])
    deviation = np.sqrt(0.5 * (covariance[:, 2, 2] + covariance[:, 3, 3]))
    walks: Booleans = (speed > least) & (speed > 2.0 * deviation)
    return walks


def _course(mean: Floats) -> Floats:
    course: Floats = np.arctan2(mean[:, 3], mean[:, 2])
    return course


def _near(a: Floats, b: Floats, distance: float) -> Booleans:
    """Which of ``a`` (d, 2) have one of ``b`` (m, 2) within ``distance``; (d,)."""
    offset = a[:, None, :] - b[None, :, :]
    near: Booleans = np.any(np.hypot(offset[..., 0], offset[..., 1]) < distance, axis=1)
    return near
