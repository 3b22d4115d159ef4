"""What the parts of perception are."""

from __future__ import annotations

from typing import Any, Protocol

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.maps import DistanceField
from cohelm.messages import Observation, People, Predictions, Scan


@value
class Detections:
    """What one scan shows; p returns, d detected people."""

    time: float
    """When the scan was taken, s."""
    points: Annotated[Floats, Shape("p 2")]
    """All valid returns in the map frame, m."""
    owner: Annotated[Integers, Shape("p")]
    """Index of the detected person each return belongs to, −1: none."""
    position: Annotated[Floats, Shape("d 2")]
    """Centres of detected people, m."""
    radius: Annotated[Floats, Shape("d")]
    """m."""
    confidence: Annotated[Floats, Shape("d")]
    """0…1."""


class Detector(Protocol):
    """An entry point of ``cohelm.detectors``."""

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """People in a scan taken with the robot at ``X_MR``, given the static map's distances."""
        ...


class Tracker(Protocol):
    """An entry point of ``cohelm.trackers``."""

    def track(
        self, observation: Observation, detections: tuple[Detections, ...], memory: Any | None
    ) -> tuple[People, Any]:
        """People at ``observation.time``, and the tracker's memory for the next call.

        ``memory`` is what the last call returned, None at first. A tracker that works from
        detections coasts where there are none.
        """
        ...


class Predictor(Protocol):
    """An entry point of ``cohelm.predictors``."""

    def predict(self, people: People, steps: int, step: float) -> Predictions:
        """Where people will be at 0, step, …, steps·step from ``people.time``."""
        ...
