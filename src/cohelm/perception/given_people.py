"""People from outside, instead of a tracker."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.config import Model
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.kalman import predict


@value
class GivenState:
    """The last known heading of everyone who is there."""

    id: Annotated[Integers, Shape("n")]
    heading: Annotated[Floats, Shape("n")]
    """rad, NaN where unknown."""


class GivenPeople:
    """Takes ``Observation.people`` as they are, brought to the observation's time.

    Ids, radii and the source's name stay. Who has no heading gets that of the motion above
    ``heading_speed``, and keeps the last one at rest. None given: nobody.
    """

    class Parameters(Model):
        """Of the pass-through; assumed."""

        heading_speed: float = Field(0.2, ge=0.0, le=3.0)
        """Least speed at which the heading follows the motion, m/s."""
        agility: float = Field(0.3, gt=0.0, le=10.0)
        """Intensity of the white acceleration with which old data grow unsure, m²/s³."""
        longest_delay: float = Field(1.0, gt=0.0, le=10.0)
        """Older people are not brought farther forward than this, s."""

    asks_for_motion = False

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def track(
        self,
        observation: Observation,
        detections: tuple[Detections, ...],
        memory: GivenState | None,
    ) -> tuple[People, GivenState]:
        """See :meth:`Tracker.track`; detections are ignored."""
        p = self.parameters
        given = observation.people
        if given is None:
            given = People.nobody(observation.time, source="given")
        delay = observation.time - given.time
        delay = min(delay, p.longest_delay) if delay > 0.0 else 0.0
        n = len(given)
        mean, covariance = predict(
            given.mean, given.covariance, np.full(n, delay), np.full(n, p.agility)
        )
        course = np.arctan2(mean[:, 3], mean[:, 2])
        walks = np.hypot(mean[:, 2], mean[:, 3]) > p.heading_speed
        fallback = np.where(walks, course, _remembered(memory, given.id))
        heading = np.where(np.isnan(given.heading), fallback, given.heading)
        people = replace(
            given, time=observation.time, mean=mean, covariance=covariance, heading=heading
        )
        return people, GivenState(id=given.id, heading=heading)


def _remembered(memory: GivenState | None, ids: Integers) -> Floats:
    """The remembered heading of each id (n,), NaN where there is none."""
    if memory is None or not len(memory.id):
        return np.full(len(ids), np.nan)
    order = np.argsort(memory.id)
    at = np.minimum(np.searchsorted(memory.id[order], ids), len(order) - 1)
    known = memory.id[order][at] == ids
    return np.where(known, memory.heading[order][at], np.nan)
