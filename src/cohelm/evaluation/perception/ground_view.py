"""Map the floor of a recording, frame by frame."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.evaluation.perception.ego_pose import EgoPoses
from cohelm.evaluation.perception.level import Leveller, find_level
from cohelm.geometry import inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import PointCloud
from cohelm.perception import GroundMap, GroundParameters
from cohelm.perception.ground.cells import FLOOR, HIGHER, LOWER
from cohelm.perception.ground.ground_map import update_ground
from cohelm.recordings import Frame
from cohelm.robots import Robot

GRID = OccupancyGrid(data=np.full((2, 2), -1, dtype=np.int8), resolution=0.05, X_MG=np.zeros(3))
"""Cells of the ground map, for which its lengths are chosen; a recording has no map."""
_REPEATS = 3
"""Times that the only frame of a recording counts: a single sweep shows no step."""


@dataclass(frozen=True)
class NearestEdge:
    """Edge nearest to the robot's place."""

    kind: str
    """``lower`` or ``higher``."""
    distance: float
    """m."""
    bearing: float
    """From the robot's heading, left > 0, rad."""


class RecordedGround:
    """The floor in a recording, see :mod:`cohelm.perception.ground`.

    A sensor whose height or tilt is not recorded looks at the floor once: they are those over the
    largest plane that it sees in its first cloud. Of several sensors whose places on the
    robot are unknown only the first counts.

    Args:
        robot: whose limits make a step an edge.
        reach: distance up to which returns count, m.
        only: the recording has one frame.
    """

    def __init__(self, robot: Robot, reach: float, *, only: bool = False) -> None:
        self.ground: GroundMap | None = None
        """None: no cloud has shown a floor yet."""
        self.pose = np.zeros(3)
        """(3,) of the robot at the last sweep."""
        self.sweeps = 0
        """Number of clouds of which the floor was found."""
        self.unlevel = 0
        """Number of clouds of which it was not."""
        self._robot, self._repeats = robot, _REPEATS if only else 1
        self._parameters = GroundParameters(side=2.0 * reach + 0.5, reach=reach)
        self._poses, self._parts = EgoPoses(at_rest=only), 0
        self._sensor: str | None = None
        self._levellers: dict[str, Leveller] = {}
        self._mounts: dict[str, Floats] = {}

    def add(self, frame: Frame) -> None:
        """Add the clouds of a frame."""
        if frame.unplaced != self._sensor and self._sensor is not None and frame.unplaced:
            return
        self._sensor = frame.unplaced or self._sensor
        frame = self._poses(frame).frame
        parts = self._poses.parts(frame.unplaced)
        if parts != self._parts:  # the way between them is unknown
            self.ground, self._parts = None, parts
        seen = frame.observation
        clouds = [self._placed(cloud, frame) for cloud in seen.clouds]
        known = tuple(cloud for cloud in clouds if math.isfinite(cloud.mount[2]))
        self.unlevel += len(clouds) - len(known)
        if not known:
            return
        self.sweeps += len(known)
        self.pose = seen.pose
        poses = np.tile(seen.pose, (len(known), 1))
        for _ in range(self._repeats):
            self.ground = update_ground(
                self.ground, known, poses, GRID, self._robot, self._parameters
            )

    def areas(self) -> dict[str, float]:
        """Area of floor, and of what lies lower and higher than it, m²."""
        kind = np.zeros(0) if self.ground is None else self.ground.kind
        cell = GRID.resolution**2
        return {
            name: float(np.count_nonzero(kind == value) * cell)
            for name, value in (("floor", FLOOR), ("lower", LOWER), ("higher", HIGHER))
        }

    def nearest_edge(self) -> NearestEdge | None:
        """The edge nearest to the robot; None: none was found."""
        if self.ground is None:
            return None
        kind = self.ground.kind
        cells = np.argwhere(kind >= LOWER)
        if not len(cells):
            return None
        away = transform(inverse(self.pose), GRID.centres(cells + self.ground.corner))
        i = int(np.argmin(np.hypot(*away.T)))
        higher = kind[tuple(cells[i])] == HIGHER
        x, y = away[i].tolist()
        return NearestEdge("higher" if higher else "lower", math.hypot(x, y), math.atan2(y, x))

    def _placed(self, cloud: PointCloud, frame: Frame) -> PointCloud:
        """Cloud with the mount (6,) over the floor that it shows; NaN height without one."""
        tilted, name = cloud.mount[3:5].any(), f"{frame.unplaced} {cloud.mount}"
        if math.isfinite(cloud.mount[2]) and (frame.posed or tilted):
            return cloud
        if math.isnan(cloud.mount[2]):
            cloud, _ = self._levellers.setdefault(name, Leveller(frame.unplaced))(cloud)
        if name not in self._mounts:
            level = find_level(cloud.points)
            if level is None:
                return cloud
            up = level.up
            roll = math.atan2(up[1], up[2])
            pitch = -math.atan2(up[0], math.hypot(up[1], up[2]))
            x, y, yaw = cloud.mount[[0, 1, 5]].tolist()
            self._mounts[name] = np.array([x, y, level.height, roll, pitch, yaw])
        return replace(cloud, mount=self._mounts[name])
