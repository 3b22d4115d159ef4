"""Sensor suite of a chair: each sensor has its own rate and random stream."""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.messages import PointCloud, Scan
from cohelm.robots import CloudMount, LaserMount, Robot
from cohelm.simulation.random_streams import generator
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.planar_bodies import planar_discs
from cohelm.simulation.sensors.point_cloud import scan_cloud
from cohelm.simulation.sensors.static_scene import StaticScene

_ROUNDING = 1e-9


@value
class SensorReadings:
    """Readings in the order of their times."""

    scans: tuple[Scan, ...] = ()
    clouds: tuple[PointCloud, ...] = ()

    def __add__(self, later: SensorReadings) -> SensorReadings:
        """Append later readings."""
        return SensorReadings(scans=self.scans + later.scans, clouds=self.clouds + later.clouds)


class SensorSuite:
    """All sensors of a robot; only their sweep counters and random streams change.

    Args:
        robot: the robot with its sensor mounts.
        seed: of the noise, ≥ 0.
    """

    def __init__(self, robot: Robot, seed: int) -> None:
        self._lasers = [_Sensor(m, seed, f"laser {i}") for i, m in enumerate(robot.lasers)]
        self._clouds = [_Sensor(m, seed, f"lidar {i}") for i, m in enumerate(robot.lidars)]
        self._clouds += [
            _Sensor(m, seed, f"depth camera {i}") for i, m in enumerate(robot.depth_cameras)
        ]

    def are_due(self, time: float) -> bool:
        """Check for a sensor that sweeps at ``time``, s."""
        return any(each.is_due(time) for each in (*self._lasers, *self._clouds))

    def sense(
        self, time: float, scene: StaticScene, bodies: HumanBodies, X_MR: Floats
    ) -> SensorReadings:
        """Return the sweeps due at ``time``; a planar scanner detects obstacles of any height.

        Args:
            time: s.
            scene: true obstacles.
            bodies: true people.
            X_MR: (3,) the chair's true pose.
        """
        discs = planar_discs(bodies)
        return SensorReadings(
            scans=tuple(
                sweep(each.mount, scene.grid, discs, X_MR, time=time, rng=each.next())
                for each in self._lasers
                if each.is_due(time)
            ),
            clouds=tuple(
                scan_cloud(each.mount, scene, bodies, X_MR, time=time, rng=each.next())
                for each in self._clouds
                if each.is_due(time)
            ),
        )


class _Sensor:
    """Mount, random stream and sweep counter of one sensor."""

    def __init__(self, mount: LaserMount | CloudMount, seed: int, purpose: str) -> None:
        self.mount: Any = mount
        self._rng = generator(seed, purpose)
        self._sweeps = 0

    def is_due(self, time: float) -> bool:
        return time >= self._sweeps / float(self.mount.rate) - _ROUNDING

    def next(self) -> np.random.Generator:
        """Count a sweep, and return the generator of its noise."""
        self._sweeps += 1
        return self._rng
