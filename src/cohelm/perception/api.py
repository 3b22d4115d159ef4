"""Interfaces of perception: the detections of one reading, and the protocols of the parts."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.maps import DistanceField
from cohelm.messages import Groups, Observation, People, PointCloud, Predictions, Scan


@value
class ColumnHeights:
    """Heights of a cloud's p columns above the ground, and f floor points seen by s sensors.

    A column is one of ``Detections.points``: all returns above one cell of 5 cm.
    """

    sensor: Annotated[Floats, Shape("s 3")]
    """(x, y, height above the floor on which the robot stands) in the map frame, m."""
    low: Annotated[Floats, Shape("p")]
    """Lower end of each column, m."""
    high: Annotated[Floats, Shape("p")]
    """Upper end, m, below the clearance."""
    first_sensor_layers: Annotated[Integers, Shape("p")]
    """Bit k: the first sensor has a return from 0.1 k m to 0.1 (k + 1) m."""
    floor: Annotated[Floats32, Shape("f 2")]
    """Observed floor, map frame, m."""
    floor_sensor: Annotated[Bytes, Shape("f")]
    """Index of the sensor that observed it."""


@value
class Detections:
    """Result of one scan, or of all clouds of an observation, in the map frame M.

    It has p returns, q free beams, c clusters of returns, and d detections: possible people. Every
    valid return is here; ``mapped``, ``cluster_of_return`` and ``detection_of_return`` only label
    it. Of clouds, ``points`` are columns that stand in the way.
    """

    time: float
    """Time of the scan, s."""
    origin: Annotated[Floats, Shape("2")]
    """Position of the sensor, m."""
    points: Annotated[Floats, Shape("p 2")]
    """All valid returns, of a scan counter-clockwise as the beams, m."""
    detection_of_return: Annotated[Integers, Shape("p")]
    """Index of each return's detection, −1: none."""
    mapped: Annotated[Booleans, Shape("p")]
    """True for returns that the static map explains; they have no cluster and no detection."""
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
    cluster_of_return: Annotated[Integers, Shape("p")]
    """Index of each return's cluster, −1: none. Clusters of furniture count, too."""
    ellipse: Annotated[Floats, Shape("c 5")]
    """Smallest ellipse about each of c clusters: centre x, y, semi-axes a ≥ b, m, direction of a,
    rad. Change detection uses its length 2 a; it is also the obstacle of barriers about ellipses,
    as in MPC-DCBF."""
    arrival_log_odds: Annotated[Floats, Shape("d")] | None = None
    """ln(p / (1 − p)) that each has arrived at its position, instead of always having been there,
    from change detection; 0: unknown. None without change detection."""
    same_view: bool = True
    """False for a scanner that has just moved, without a map to explain what comes into view."""
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
            detection_of_return=np.empty(0, dtype=np.int64),
            mapped=np.empty(0, dtype=np.bool_),
            free_ends=none.reshape(0, 2),
            position=none.reshape(0, 2),
            radius=none,
            deviation=none,
            confidence=none,
            cluster_of_return=np.empty(0, dtype=np.int64),
            ellipse=none.reshape(0, 5),
        )


class Detector(Protocol):
    """Entry point of ``cohelm.detectors``: people in a planar scan."""

    def detect(self, scan: Scan, X_MR: Floats, walls: DistanceField) -> Detections:
        """Detect people in a scan.

        Args:
            scan: ranges in the sensor's frame; its ``mount`` is the sensor on the robot.
            X_MR: (3,) x, y, heading of the robot in the map frame at the scan's time, m and rad.
            walls: distance to the nearest wall of the static map at points of the map frame, m.
        """
        ...


class CloudDetector(Protocol):
    """Entry point of ``cohelm.cloud_detectors``: people in the clouds of 3-D sensors."""

    def detect(
        self, clouds: tuple[PointCloud, ...], X_MR: Floats, walls: DistanceField
    ) -> Detections:
        """Detect people in clouds of one observation, fused point by point.

        Args:
            clouds: c of them, of different sensors, each in its sensor's frame.
            X_MR: (c, 3) x, y, heading of the robot in the map frame at each cloud's time, m and
                rad.
            walls: distance to the nearest wall of the static map at points of the map frame, m.

        Returns:
            ``points`` are the columns that stand in the way, ``free_ends`` the ends of the free
            directions; ``origin`` and ``time`` are those of the first cloud.
        """
        ...


class Tracker(Protocol):
    """Entry point of ``cohelm.trackers``."""

    @property
    def uses_change_detection(self) -> bool:
        """True if the tracker uses ``Detections.arrival_log_odds`` of planar scans.

        Otherwise scans are not compared with earlier ones, which saves time.
        """
        ...

    def track(
        self, observation: Observation, detections: tuple[Detections, ...], memory: Any | None
    ) -> tuple[People, Any]:
        """Track people to ``observation.time``; also return the memory for the next call.

        A tracker that works from detections coasts where there are none.

        If ``observation.time`` lies more than ``CLOCK_RESET`` (1 s) before what ``memory`` has
        seen, the clock has restarted: all tracks end, and only the counter of ids goes on. The
        pipeline also resets a tracker this way, by a call with an early time and no readings.

        Args:
            observation: the present; its ``people`` are those that an external source reports.
            detections: one per scan, and one for all clouds together, in any order of time.
            memory: the one of the last call, None at first.
        """
        ...


class GroupDetector(Protocol):
    """Entry point of ``cohelm.group_detectors``: groups of people."""

    def group(self, people: People, memory: Any | None) -> tuple[Groups, Any]:
        """Detect groups from the present and the past; also return the memory for the next call.

        A group keeps its id as long as it exists; ids are never used again. If ``people.time`` lies
        more than ``CLOCK_RESET`` (1 s) before what ``memory`` has seen, all evidence is dropped,
        and only the counter of ids goes on.

        Args:
            people: tracked people; their ids must differ.
            memory: the one of the last call, None at first.
        """
        ...


class Predictor(Protocol):
    """Entry point of ``cohelm.predictors``."""

    def predict(
        self, people: People, steps: int, step: float, memory: Any | None
    ) -> tuple[Predictions, Any]:
        """Predict positions at 0, step, …, steps·step after ``people.time``; return a new memory.

        Args:
            people: tracked people.
            steps: number of steps.
            step: length of a step, s.
            memory: the one of the last call, None at first.
        """
        ...
