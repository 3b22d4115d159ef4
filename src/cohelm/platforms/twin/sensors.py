"""Sensors of the twin: rays of MuJoCo from the moving body."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.messages import PointCloud, Scan
from cohelm.platforms.twin.building import CEILING, PEOPLE, SEEN
from cohelm.platforms.twin.people import PersonGeoms
from cohelm.robots import CloudMount, LaserMount
from cohelm.simulation.sensors.laser import beam_angles, measured_scan
from cohelm.simulation.sensors.point_cloud import measured_cloud, rays_of, rotation_of

HIDDEN = 5
"""Group of bodies that nothing sees."""
_SEEN = np.array([group in {SEEN, PEOPLE, CEILING} for group in range(6)], dtype=np.uint8)


class BodyCasting:
    """Rays from the chair's body as it stands: with its roll and pitch, at its own height.

    A planar scanner that looks down with the body meets the floor; glass and the chair itself are
    seen by no sensor.

    Args:
        mujoco: the module.
        model: with all bodies.
        data: their state now.
        table: geometries of people.
        visible: (n,) mask of people who can be seen.
        height: of planar scanners over the floor, m.
    """

    def __init__(  # the four values of MuJoCo belong together
        self,
        mujoco: Any,
        model: Any,
        data: Any,
        table: PersonGeoms,
        visible: Booleans,
        height: float,
    ) -> None:
        self._mujoco, self._model, self._data = mujoco, model, data
        self._table, self._visible, self._height = table, visible, height

    def scan(self, mount: LaserMount, *, time: float, rng: np.random.Generator) -> Scan:
        """See :meth:`cohelm.simulation.sensing.Casting.scan`."""
        x, y, yaw = mount.pose
        angles = beam_angles(mount) + yaw
        rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
        ranges = self._cast(np.array([x, y, self._height]), rays, mount.range_max)
        return measured_scan(mount, ranges, time=time, rng=rng)

    def cloud(self, mount: CloudMount, *, time: float, rng: np.random.Generator) -> PointCloud:
        """See :meth:`cohelm.simulation.sensing.Casting.cloud`."""
        x, y, z, roll, pitch, yaw = mount.pose
        rays = rays_of(mount)[0] @ rotation_of(roll, pitch, yaw).T
        distance = self._cast(np.array([x, y, z]), rays, mount.range_max)
        return measured_cloud(mount, distance, time=time, rng=rng)

    def _cast(self, origin: Floats, rays: Floats, reach: float) -> Floats:
        """Distance (b,) along rays (b, 3) from an origin (3,), chair's frame, m; +inf: none."""
        chair = self._data.body("chair")
        R_MR = chair.xmat.reshape(3, 3)
        count = len(rays)
        distance, geoms = np.empty(count), np.empty(count, dtype=np.int32)
        with self._unseen():
            self._mujoco.mj_multiRay(
                self._model,
                self._data,
                chair.xpos + R_MR @ origin,
                (rays @ R_MR.T).ravel(),
                _SEEN,
                True,
                -1,
                geoms,
                distance,
                None,
                count,
                reach,
            )
        return np.where((distance < 0.0) | (distance > reach), math.inf, distance)

    @contextmanager
    def _unseen(self) -> Iterator[None]:
        """Hide people who are not visible."""
        hidden = self._table.hidden(self._visible)
        self._model.geom_group[hidden] = HIDDEN
        try:
            yield
        finally:
            self._model.geom_group[hidden] = PEOPLE
