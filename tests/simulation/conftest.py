"""Small worlds to build tests from."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid
from cohelm.robots import Robot, load_robot
from cohelm.simulation import Crowd, CrowdScene, Idle, Orca, WorldSetup

RESOLUTION = 0.05


@pytest.fixture
def make_grid() -> Callable[..., OccupancyGrid]:
    """A grid of ``width`` × ``height`` metres with boxes (x0, y0, x1, y1) of one value in it."""

    def make(
        width: float = 12.0,
        height: float = 10.0,
        boxes: tuple[tuple[float, float, float, float], ...] = (),
        value: int = 100,
        X_MG: tuple[float, float, float] = (0.0, 0.0, 0.0),
    ) -> OccupancyGrid:
        data = np.zeros((round(height / RESOLUTION), round(width / RESOLUTION)), dtype=np.int8)
        for box in boxes:
            x0, y0, x1, y1 = (round(b / RESOLUTION) for b in box)
            data[y0:y1, x0:x1] = value
        return OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.array(X_MG))

    return make


@pytest.fixture
def make_crowd() -> Callable[..., Crowd]:
    """People at ``position`` who walk by way-points (n, w, 2)."""

    def make(position: Any, waypoints: Any, **changes: Any) -> Crowd:
        position = np.asarray(position, dtype=float).reshape(-1, 2)
        n = len(position)
        waypoints = np.asarray(waypoints, dtype=float)
        fields = {
            "position": position,
            "velocity": np.zeros((n, 2)),
            "heading": np.zeros(n),
            "radius": np.full(n, 0.25),
            "preferred_speed": np.ones(n),
            "waypoints": waypoints.reshape(n, -1, 2) if n else np.empty((0, 1, 2)),
            "target": np.zeros(n, dtype=np.int64),
            "loop": np.zeros(n, dtype=bool),
            "sees_robot": np.zeros(n, dtype=bool),
        }
        return Crowd(**{**fields, **changes})

    return make


@pytest.fixture
def make_scene(make_grid: Callable[..., OccupancyGrid]) -> Callable[..., CrowdScene]:
    """Surroundings with the robot far away, unless told otherwise."""

    def make(grid: OccupancyGrid | None = None, **changes: Any) -> CrowdScene:
        fields = {
            "grid": make_grid() if grid is None else grid,
            "robot_position": np.full(2, 1000.0),
            "robot_velocity": np.zeros(2),
            "robot_radius": 0.5,
            "time": 0.0,
        }
        return CrowdScene(**{**fields, **changes})

    return make


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("quantum_q6_edge")


@pytest.fixture
def make_setup(
    robot: Robot, make_grid: Callable[..., OccupancyGrid], make_crowd: Callable[..., Crowd]
) -> Callable[..., WorldSetup]:
    """A chair at (2, 5) in an empty room without people, unless told otherwise."""

    def make(**changes: Any) -> WorldSetup:
        fields = {
            "grid": make_grid(),
            "robot": robot,
            "start": np.array([2.0, 5.0, 0.0]),
            "crowd": make_crowd([], []),
            "pedestrian_model": Orca(),
            "rider": Idle(),
            "rider_goal": np.array([10.0, 5.0]),
            "rider_route": np.array([[2.0, 5.0], [10.0, 5.0]]),
        }
        return WorldSetup(**{**fields, **changes})

    return make
