"""Film of a ride in three dimensions, drawn off-screen by MuJoCo; of rides on any platform."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Bytes, Floats, replace
from cohelm.errors import ConfigError, PlatformError
from cohelm.platforms.twin.building import GLASS, PEOPLE, SEEN
from cohelm.platforms.twin.chair import CHAIR_GROUP
from cohelm.platforms.twin.platform import load_mujoco
from cohelm.platforms.twin.twin_chair import TwinChair
from cohelm.plotting.animation import INTERVAL, check_animation, write_film
from cohelm.robots import Robot
from cohelm.simulation import WorldSetup
from cohelm.simulation.sensors.human_bodies import HumanBodies

VIEWS = ("follow", "above", "rider")
"""Cameras: behind the chair, over it, and the rider's eyes."""
SIZE = (640, 360)
"""Width and height of a frame, px."""
CUT = 1.1
"""Height at which walls are cut for views from outside, m."""
_DRAWN = [SEEN, PEOPLE, CHAIR_GROUP, GLASS]
_BACKENDS = ("egl", "osmesa")


class FilmedRide(Protocol):
    """Ride of k instants and n people, as far as a film needs it."""

    @property
    def setup(self) -> WorldSetup | None:
        """World; None: not known."""
        ...

    @property
    def robot(self) -> Robot:
        """Chair."""
        ...

    @property
    def step(self) -> float:
        """Time between instants, s."""
        ...

    @property
    def pose(self) -> Floats:
        """(k, 3) X_MR."""
        ...

    @property
    def people(self) -> Floats:
        """(k, n, 4) x, y, v_x, v_y; NaN where absent."""
        ...

    @property
    def people_heading(self) -> Floats:
        """(k, n) rad."""
        ...


def check_film(file: Path, view: str) -> None:
    """Refuse a film that cannot be written, before the ride.

    Raises:
        ConfigError: the view is unknown, or the file cannot be written.
        PlatformError: MuJoCo or off-screen drawing is missing.
    """
    if view not in VIEWS:
        raise ConfigError(f"no view is called {view!r}: {', '.join(VIEWS)}", key="--view")
    check_animation(file)
    _OffScreen.context(load_mujoco(), 16, 16).free()


def film_ride(ride: FilmedRide, file: Path, view: str, *, speed_up: float = 1.0) -> None:
    """Write a film of a ride. Doors that shut on the way are not shown.

    Raises:
        ConfigError: the file cannot be written, or the ride's world is not known.
        PlatformError: see :func:`check_film`.
    """
    every = max(round(INTERVAL / ride.step), 1)
    moments = range(0, len(ride.pose), every)
    sample = next(_frames(ride, view, [moments[len(moments) // 2]]))
    write_film(_frames(ride, view, moments), file, sample=sample, speed_up=speed_up)


def _frames(ride: FilmedRide, view: str, moments: Any) -> Iterator[Bytes]:
    """RGB images (height, width, 3) of some instants."""
    if ride.setup is None:
        raise ConfigError("the world of this ride is not known", key="--view")
    mujoco = load_mujoco()
    setup = replace(ride.setup, ceiling=math.inf, faults=())
    if view != "rider":
        setup = replace(setup, wall_height=min(CUT, setup.wall_height))
    chair = TwinChair(mujoco, setup)
    screen = _OffScreen(mujoco, chair.twin.model)
    walked = np.cumsum(np.nan_to_num(np.hypot(*ride.people[..., 2:].T).T) * ride.step, axis=0)
    try:
        for at in moments:
            chair.show(ride.pose[at], _bodies(ride, setup, at, walked[at]))
            yield screen.draw(chair.twin.data, _camera(mujoco, view, chair))
    finally:
        screen.close()


def _bodies(ride: FilmedRide, setup: WorldSetup, at: int, walked: Floats) -> HumanBodies:
    n = ride.people.shape[1]
    state = np.nan_to_num(ride.people[at], nan=1e6)
    there = np.isfinite(ride.people[at, :, 0])
    return HumanBodies(
        position=state[:, :2],
        heading=np.nan_to_num(ride.people_heading[at]),
        walked=walked,
        speed=np.where(there, np.hypot(state[:, 2], state[:, 3]), 0.0),
        height=np.full(n, 1.7) if setup.statures is None else setup.statures,
        radius=setup.crowd.radius,
        kind=setup.kinds,
    )


def _camera(mujoco: Any, view: str, chair: TwinChair) -> Any:
    camera = mujoco.MjvCamera()
    x, y, yaw = chair.pose
    z = float(chair.twin.data.qpos[2])
    ahead = np.array([math.cos(yaw), math.sin(yaw)])
    camera.azimuth = math.degrees(yaw)
    if view == "rider":
        eyes = np.array([x, y]) - 0.10 * ahead
        camera.distance, camera.elevation = 1.0, -12.0
        drop = math.radians(12.0)
        height = z + chair.eyes - math.sin(drop)
        camera.lookat = [*(eyes + math.cos(drop) * ahead), height]
    elif view == "above":
        camera.lookat = [x, y, z]
        camera.distance, camera.elevation, camera.azimuth = 11.0, -89.0, 90.0
    else:
        camera.lookat = [*(np.array([x, y]) + 0.8 * ahead), z + 0.6]
        camera.distance, camera.elevation = 4.5, -32.0
    return camera


class _OffScreen:
    """Renderer without a display.

    Args:
        mujoco: the module.
        model: to draw.

    Raises:
        PlatformError: neither EGL nor OSMesa works.
    """

    def __init__(self, mujoco: Any, model: Any) -> None:
        self._mujoco, self._model = mujoco, model
        self._gl = self.context(mujoco, *SIZE)
        self._gl.make_current()
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        self._scene = mujoco.MjvScene(model, maxgeom=model.ngeom + 100)
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = [group in _DRAWN for group in range(6)]

    @staticmethod
    def context(mujoco: Any, width: int, height: int) -> Any:
        """Open a context of EGL, else of OSMesa."""
        causes = []
        for backend in _BACKENDS:
            try:
                module = importlib.import_module(f"{mujoco.__name__}.{backend}")
                return module.GLContext(width, height)
            except Exception as cause:  # each library fails in its own way
                causes.append(f"{backend}: {cause}")
        raise PlatformError(
            "pictures from the twin need EGL or OSMesa, as of Debian's libegl1 and libosmesa6 "
            f"({'; '.join(causes)})"
        )

    def draw(self, data: Any, camera: Any) -> Bytes:
        """Image (height, width, 3)."""
        mujoco, (width, height) = self._mujoco, SIZE
        area = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjv_updateScene(
            self._model,
            data,
            self._option,
            None,
            camera,
            mujoco.mjtCatBit.mjCAT_ALL,
            self._scene,
        )
        mujoco.mjr_render(area, self._scene, self._context)
        image = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(image, None, area, self._context)
        return np.ascontiguousarray(image[::-1])

    def close(self) -> None:
        """Release both contexts."""
        self._context.free()
        self._gl.free()
