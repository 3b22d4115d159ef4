"""All sensors of a chair: each sweeps at its own rate, with a generator of its own."""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.arrays import Floats, value
from cohelm.messages import PointCloud, Scan
from cohelm.robots import CloudMount, LaserMount, Robot
from cohelm.simulation.chance import generator
from cohelm.simulation.sensors.cloud import scan_cloud
from cohelm.simulation.sensors.figures import Bodies
from cohelm.simulation.sensors.laser import sweep
from cohelm.simulation.sensors.scenery import Scenery

_ROUNDING = 1e-9


@value
class Sensed:
    """What sensors sent, in the order of their times."""

    scans: tuple[Scan, ...] = ()
    clouds: tuple[PointCloud, ...] = ()

    def __add__(self, later: Sensed) -> Sensed:
        """This, and what was sent after it."""
        return Sensed(scans=self.scans + later.scans, clouds=self.clouds + later.clouds)


class Senses:
    """Which sweep of each sensor comes next; the only thing in it that changes.

    Args:
        robot: whose sensors.
        seed: of their noise, ≥ 0.
    """

    def __init__(self, robot: Robot, seed: int) -> None:
        self._scanners = [_Sensor(m, seed, f"laser {i}") for i, m in enumerate(robot.lasers)]
        self._lidars = [_Sensor(m, seed, f"lidar {i}") for i, m in enumerate(robot.lidars)]
        self._lidars += [
            _Sensor(m, seed, f"depth camera {i}") for i, m in enumerate(robot.depth_cameras)
        ]

    def are_due(self, time: float) -> bool:
        """Whether any of them sweeps at ``time``, s."""
        return any(each.is_due(time) for each in (*self._scanners, *self._lidars))

    def sense(self, time: float, scenery: Scenery, bodies: Bodies, X_MR: Floats) -> Sensed:
        """The sweeps due at ``time``; a planar scanner sees what stands there, however low.

        Args:
            time: s.
            scenery: what truly stands there.
            bodies: the people.
            X_MR: (3,) the chair's true pose.
        """
        discs = np.column_stack([bodies.position, bodies.radius])
        return Sensed(
            scans=tuple(
                sweep(each.mount, scenery.grid, discs, X_MR, time=time, rng=each.next())
                for each in self._scanners
                if each.is_due(time)
            ),
            clouds=tuple(
                scan_cloud(each.mount, scenery, bodies, X_MR, time=time, rng=each.next())
                for each in self._lidars
                if each.is_due(time)
            ),
        )


class _Sensor:
    """One sensor, its chance, and how often it has swept."""

    def __init__(self, mount: LaserMount | CloudMount, seed: int, purpose: str) -> None:
        self.mount: Any = mount
        self._rng = generator(seed, purpose)
        self._sweeps = 0

    def is_due(self, time: float) -> bool:
        return time >= self._sweeps / float(self.mount.rate) - _ROUNDING

    def next(self) -> np.random.Generator:
        """Count a sweep; the generator to draw its noise from."""
        self._sweeps += 1
        return self._rng
