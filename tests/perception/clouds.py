"""A building of the tests' own for 3-D sensors: things of known heights on a known floor."""

from __future__ import annotations

import dataclasses
from functools import lru_cache

import numpy as np

from cohelm.maps import OccupancyGrid, distance_field
from cohelm.messages import PointCloud
from cohelm.perception import CloudClusters
from cohelm.robots import LidarMount
from cohelm.simulation.sensors import LEVEL, HumanBodies, StaticScene, sweep_cloud

CELL = 0.05
SIDE = 20.0
NOBODY = HumanBodies.standing(np.empty((0, 2)))
LIDAR = LidarMount()
SPARSE = LidarMount(rings=16, azimuths=360)
HERE = np.zeros(3)


@lru_cache(maxsize=1)
def hall():
    """The walls of a square hall about the origin, which the map knows; (grid, distances)."""
    data = np.zeros((round(SIDE / CELL),) * 2, dtype=np.int8)
    data[:2] = data[-2:] = data[:, :2] = data[:, -2:] = 100
    grid = OccupancyGrid(data=data, resolution=CELL, X_MG=np.array([-SIDE / 2, -SIDE / 2, 0.0]))
    return grid, distance_field(grid)


def scenery(*things, floor=LEVEL, ceiling=2.7):
    """Things are (x, y, (width, depth) or radius, height); the map does not know them."""
    grid, _ = hall()
    data, heights = grid.data.copy(), np.full(grid.shape, np.nan, dtype=np.float32)
    at = (np.arange(grid.shape[0]) + 0.5) * CELL - SIDE / 2
    for x, y, size, height in things:
        dx, dy = np.meshgrid(at - x, at - y)
        if np.ndim(size):
            inside = (np.abs(dx) <= size[0] / 2) & (np.abs(dy) <= size[1] / 2)
        else:
            inside = np.hypot(dx, dy) <= size
        data[inside], heights[inside] = 100, height
    grid = dataclasses.replace(grid, data=data)
    return StaticScene(grid=grid, heights=heights, wall_height=2.7, ceiling=ceiling, floor=floor)


def cloud_of(scene, bodies=NOBODY, mount=LIDAR, pose=HERE, seed=0):
    rng = np.random.default_rng(seed)
    return sweep_cloud(mount, scene, bodies, np.asarray(pose), time=1.0, rng=rng).cloud


def see(scene, bodies=NOBODY, mount=LIDAR, pose=HERE, **parameters):
    detector = CloudClusters(CloudClusters.Parameters(**parameters))
    return detector.detect((cloud_of(scene, bodies, mount, pose),), np.array([pose]), hall()[1])


def off(seen, bodies):
    """Distance from each body to the nearest detection, m."""
    apart = bodies.position[:, None] - seen.position[None]
    return np.hypot(apart[..., 0], apart[..., 1]).min(axis=1, initial=np.inf)


def bare(points, mount=(0.0, 0.0, 1.3, 0.0, 0.0, 0.0), range_max=20.0):
    return PointCloud(
        time=1.0,
        mount=np.array(mount),
        points=np.asarray(points, dtype=np.float32).reshape(-1, 3),
        range_max=range_max,
    )
