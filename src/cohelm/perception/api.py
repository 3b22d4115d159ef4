"""What the parts of perception are."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.maps import DistanceField
from cohelm.messages import Groups, Observation, People, PointCloud, Predictions, Scan


@value
class Heights:
    """How high a cloud's columns are, and where the floor was seen; p columns, f places, s sensors.

    Heights are above the ground there.
    """

    sensor: Annotated[Floats, Shape("s 3")]
    """(x, y, height above the floor on which the robot stands) in the map frame, m."""
    low: Annotated[Floats, Shape("p")]
    """Where each column begins, m."""
    high: Annotated[Floats, Shape("p")]
    """Where it ends, m, as far as it is in the way."""
    layers: Annotated[Integers, Shape("p")]
    """Bit k: something came back to the first sensor from 0.1 k m to 0.1 (k + 1) m."""
    floor: Annotated[Floats32, Shape("f 2")]
    """Where the floor was seen, map frame, m."""
    seen_by: Annotated[Bytes, Shape("f")]
    """The sensor that saw it."""


@value
class Detections:
    """What one scan shows, in the map frame; p returns, q free beams, d possible people.

    Every valid return is here, whatever it was taken for: ``owner`` and ``mapped`` only label it.
    """

    time: float
    """When the scan was taken, s."""
    origin: Annotated[Floats, Shape("2")]
    """Where the sensor was, m."""
    points: Annotated[Floats, Shape("p 2")]
    """All valid returns, counter-clockwise as the beams, m."""
    owner: Annotated[Integers, Shape("p")]
    """Index of the detected person each return belongs to, −1: none."""
    mapped: Annotated[Booleans, Shape("p")]
    """Which returns the static map explains; they own nobody."""
    through: Annotated[Floats, Shape("q 2")]
    """Ends of the beams that met nothing, at the sensor's reach, m."""
    position: Annotated[Floats, Shape("d 2")]
    """Centres of detected people, m."""
    radius: Annotated[Floats, Shape("d")]
    """m."""
    deviation: Annotated[Floats, Shape("d")]
    """Standard deviation of the centre along its worse axis, m."""
    confidence: Annotated[Floats, Shape("d")]
    """Probability that it is a person, from its shape alone, 0…1; a low one needs motion."""
    cluster: Annotated[Integers, Shape("p")]
    """Which cluster each return belongs to, −1: none; static clusters have a number, too."""
    ellipse: Annotated[Floats, Shape("c 5")]
    """Least ellipse about each of c clusters: centre x, y, semi-axes a ≥ b, m, direction of a,
    rad. What was there before is judged by its breadth, see ``novelty``; it is also the obstacle of
    barriers about ellipses, as in MPC-DCBF."""
    moved: Annotated[Floats, Shape("d")] | None = None
    """Log-odds that each has come to where it is, from what was there before; None: not known."""
    heights: Heights | None = None
    """Of what a 3-D sensor saw; None: all is at one height, which is not known."""

    @staticmethod
    def nothing(time: float, origin: Floats) -> Detections:
        """A scan without any return."""
        none = np.empty(0)
        return Detections(
            time=time,
            origin=origin,
            points=none.reshape(0, 2),
            owner=np.empty(0, dtype=np.int64),
            mapped=np.empty(0, dtype=np.bool_),
            through=none.reshape(0, 2),
            position=none.reshape(0, 2),
            radius=none,
            deviation=none,
            confidence=none,
            cluster=np.empty(0, dtype=np.int64),
            ellipse=none.reshape(0, 5),
        )


class Detector(Protocol):
    """An entry point of ``cohelm.detectors``: people in a planar scan."""

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """People in a scan taken with the robot at ``X_MR``, given the static map's distances."""
        ...


class CloudDetector(Protocol):
    """An entry point of ``cohelm.cloud_detectors``: people in the clouds of 3-D sensors."""

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """People in clouds taken together, fused point by point.

        Args:
            clouds: one or more of different sensors.
            X_MR: (c, 3), where the robot was at each.
            walls: the static map's distances.

        Returns:
            With ``points`` thinned to the columns that stand in the way, ``origin`` and ``time``
            those of the first cloud, and ``through`` the ends of the free directions.
        """
        ...


class Tracker(Protocol):
    """An entry point of ``cohelm.trackers``.

    One that has ``asks_for_motion = False`` is told nothing of who has moved (``Detections.moved``
    of planar scans): scans are then not compared with earlier ones, which takes time.
    """

    def track(
        self, observation: Observation, detections: tuple[Detections, ...], memory: Any | None
    ) -> tuple[People, Any]:
        """People at ``observation.time``, and the tracker's memory for the next call.

        ``memory`` is what the last call returned, None at first. A tracker that works from
        detections coasts where there are none.
        """
        ...


class GroupDetector(Protocol):
    """An entry point of ``cohelm.group_detectors``: who belongs together."""

    def group(self, people: People, memory: Any | None) -> tuple[Groups, Any]:
        """Groups among ``people``, from now and the past alone, and the memory for the next call.

        A group keeps its id as long as it lives; ids are never used again.
        """
        ...


class Predictor(Protocol):
    """An entry point of ``cohelm.predictors``."""

    def predict(
        self, people: People, steps: int, step: float, memory: Any | None
    ) -> tuple[Predictions, Any]:
        """Where people will be at 0, step, …, steps·step from ``people.time``.

        ``memory`` is what the last call returned, None at first; also returned, for the next call.
        """
        ...
