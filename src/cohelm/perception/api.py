"""Interfaces of perception: the detections of one reading, and the protocols of the parts."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.maps import DistanceField
from cohelm.messages import Groups, Observation, People, PointCloud, Predictions, Scan


@value
class ColumnHeights:
    """Heights of a cloud's p columns above the ground, and f floor points seen by s sensors."""

    sensor: Annotated[Floats, Shape("s 3")]
    """(x, y, height above the floor on which the robot stands) in the map frame, m."""
    low: Annotated[Floats, Shape("p")]
    """Lower end of each column, m."""
    high: Annotated[Floats, Shape("p")]
    """Upper end, m, below the clearance."""
    layers: Annotated[Integers, Shape("p")]
    """Bit k: the first sensor has a return from 0.1 k m to 0.1 (k + 1) m."""
    floor: Annotated[Floats32, Shape("f 2")]
    """Observed floor, map frame, m."""
    floor_sensor: Annotated[Bytes, Shape("f")]
    """Index of the sensor that observed it."""


@value
class Detections:
    """Result of one scan or cloud in the map frame; p returns, q free beams, d possible people.

    Every valid return is here; ``owner`` and ``mapped`` only label it.
    """

    time: float
    """Time of the scan, s."""
    origin: Annotated[Floats, Shape("2")]
    """Position of the sensor, m."""
    points: Annotated[Floats, Shape("p 2")]
    """All valid returns, counter-clockwise as the beams, m."""
    owner: Annotated[Integers, Shape("p")]
    """Index of the detected person of each return, −1: none."""
    mapped: Annotated[Booleans, Shape("p")]
    """True for returns that the static map explains; they belong to no person."""
    free_ends: Annotated[Floats, Shape("q 2")]
    """Ends of the beams without a return, at the sensor's range, m."""
    position: Annotated[Floats, Shape("d 2")]
    """Centres of detected people, m."""
    radius: Annotated[Floats, Shape("d")]
    """m."""
    deviation: Annotated[Floats, Shape("d")]
    """Standard deviation of the centre along its worse axis, m."""
    confidence: Annotated[Floats, Shape("d")]
    """Probability of a person from the shape alone, 0…1; a low one needs motion to be confirmed."""
    cluster: Annotated[Integers, Shape("p")]
    """Cluster of each return, −1: none; static clusters have a number, too."""
    ellipse: Annotated[Floats, Shape("c 5")]
    """Smallest ellipse about each of c clusters: centre x, y, semi-axes a ≥ b, m, direction of a,
    rad. Change detection uses its breadth; it is also the obstacle of barriers about ellipses, as
    in MPC-DCBF."""
    moved: Annotated[Floats, Shape("d")] | None = None
    """Log-odds that each has arrived at its position, from change detection; None: unknown."""
    heights: ColumnHeights | None = None
    """Heights of a cloud's columns; None for a planar scan, whose height is unknown."""

    @staticmethod
    def empty(time: float, origin: Floats) -> Detections:
        """Detections of a scan without any return."""
        none = np.empty(0)
        return Detections(
            time=time,
            origin=origin,
            points=none.reshape(0, 2),
            owner=np.empty(0, dtype=np.int64),
            mapped=np.empty(0, dtype=np.bool_),
            free_ends=none.reshape(0, 2),
            position=none.reshape(0, 2),
            radius=none,
            deviation=none,
            confidence=none,
            cluster=np.empty(0, dtype=np.int64),
            ellipse=none.reshape(0, 5),
        )


class Detector(Protocol):
    """Entry point of ``cohelm.detectors``: people in a planar scan."""

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """Detect people in a scan taken at robot pose ``X_MR``; ``walls``: the static map."""
        ...


class CloudDetector(Protocol):
    """Entry point of ``cohelm.cloud_detectors``: people in the clouds of 3-D sensors."""

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """Detect people in clouds of one observation, fused point by point.

        Args:
            clouds: one or more of different sensors.
            X_MR: (c, 3), robot pose at each.
            walls: the static map's distances.

        Returns:
            ``points`` are the columns that stand in the way, ``free_ends`` the ends of the free
            directions; ``origin`` and ``time`` are those of the first cloud.
        """
        ...


class Tracker(Protocol):
    """Entry point of ``cohelm.trackers``.

    A tracker with ``uses_change_detection = False`` gets no ``Detections.moved`` of planar scans:
    scans are then not compared with earlier ones, which saves time.
    """

    def track(
        self, observation: Observation, detections: tuple[Detections, ...], memory: Any | None
    ) -> tuple[People, Any]:
        """Track people to ``observation.time``; also return the memory for the next call.

        ``memory`` is the one of the last call, None at first. A tracker that works from detections
        coasts where there are none.
        """
        ...


class GroupDetector(Protocol):
    """Entry point of ``cohelm.group_detectors``: groups of people."""

    def group(self, people: People, memory: Any | None) -> tuple[Groups, Any]:
        """Detect groups from the present and the past; also return the memory for the next call.

        A group keeps its id as long as it exists; ids are never used again.
        """
        ...


class Predictor(Protocol):
    """Entry point of ``cohelm.predictors``."""

    def predict(
        self, people: People, steps: int, step: float, memory: Any | None
    ) -> tuple[Predictions, Any]:
        """Predict positions at 0, step, …, steps·step after ``people.time``.

        ``memory`` is the one of the last call, None at first; a new one is returned.
        """
        ...
