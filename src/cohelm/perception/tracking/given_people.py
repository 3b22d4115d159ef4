"""Pass-through for people that an external source reports, instead of a tracker."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Integers, Shape, replace, value
from cohelm.config import Model
from cohelm.messages import Observation, People
from cohelm.perception.api import Detections
from cohelm.perception.tracking.kalman import predict


@value
class GivenState:
    """Last known heading of each person."""

    id: Annotated[Integers, Shape("n")]
    heading: Annotated[Floats, Shape("n")]
    """rad, NaN where unknown."""


class GivenPeople:
    """Passes on ``Observation.people``, predicted to the observation's time.

    Ids, radii and the source's name stay. A person without a heading gets the direction of motion
    above ``heading_speed``, and keeps the last heading at rest. An observation without people gives
    nobody.
    """

    class Parameters(Model):
        """Parameters of the pass-through; assumed."""

        heading_speed: float = Field(0.2, ge=0.0, le=3.0)
        """Least speed at which the heading follows the motion, m/s."""
        process_noise: float = Field(0.3, gt=0.0, le=10.0)
        """Intensity of the white acceleration in the prediction of old data, m²/s³."""
        max_delay: float = Field(1.0, gt=0.0, le=10.0)
        """Longest prediction of older people, s."""

    uses_change_detection = False

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
            given = People.empty(observation.time, source="given")
        delay = observation.time - given.time
        delay = min(delay, p.max_delay) if delay > 0.0 else 0.0
        n = len(given)
        mean, covariance = predict(
            given.mean, given.covariance, np.full(n, delay), np.full(n, p.process_noise)
        )
        course = np.arctan2(mean[:, 3], mean[:, 2])
        walks = np.hypot(mean[:, 2], mean[:, 3]) > p.heading_speed
        fallback = np.where(walks, course, _last_heading(memory, given.id))
        heading = np.where(np.isnan(given.heading), fallback, given.heading)
        people = replace(
            given, time=observation.time, mean=mean, covariance=covariance, heading=heading
        )
        return people, GivenState(id=given.id, heading=heading)


def _last_heading(memory: GivenState | None, ids: Integers) -> Floats:
    """Last heading of each id (n,), NaN if unknown."""
    if memory is None or not len(memory.id):
        return np.full(len(ids), np.nan)
    order = np.argsort(memory.id)
    at = np.minimum(np.searchsorted(memory.id[order], ids), len(order) - 1)
    known = memory.id[order][at] == ids
    return np.where(known, memory.heading[order][at], np.nan)
