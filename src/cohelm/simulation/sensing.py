"""Sensor suite of a chair: each sensor has its own rate and random stream."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
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


class Casting(Protocol):
    """Rays of a chair's sensors at one instant."""

    def scan(self, mount: LaserMount, *, time: float, rng: np.random.Generator) -> Scan:
        """Sweep a planar scanner; the number of random draws is constant."""
        ...

    def cloud(self, mount: CloudMount, *, time: float, rng: np.random.Generator) -> PointCloud:
        """Sweep a LiDAR or depth camera; the number of random draws is constant."""
        ...


@value
class PlanarCasting:
    """Rays on a floor's grid; a planar scanner detects obstacles of any height."""

    scene: StaticScene
    """True obstacles."""
    bodies: HumanBodies
    """True people."""
    X_MR: Annotated[Floats, Shape("3")]
    """True pose of the chair."""

    def scan(self, mount: LaserMount, *, time: float, rng: np.random.Generator) -> Scan:
        """See :meth:`Casting.scan`."""
        discs = planar_discs(self.bodies)
        return sweep(mount, self.scene.grid, discs, self.X_MR, time=time, rng=rng)

    def cloud(self, mount: CloudMount, *, time: float, rng: np.random.Generator) -> PointCloud:
        """See :meth:`Casting.cloud`."""
        return scan_cloud(mount, self.scene, self.bodies, self.X_MR, time=time, rng=rng)


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

    def sense(self, time: float, casting: Casting) -> SensorReadings:
        """Return the sweeps due at ``time``, s."""
        return SensorReadings(
            scans=tuple(
                casting.scan(each.mount, time=time, rng=each.next())
                for each in self._lasers
                if each.is_due(time)
            ),
            clouds=tuple(
                casting.cloud(each.mount, time=time, rng=each.next())
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
