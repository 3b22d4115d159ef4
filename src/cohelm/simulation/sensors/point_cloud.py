"""3-D LiDARs and depth cameras: rays, range noise and dropouts, and the owner of each point."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, read_only, value
from cohelm.geometry import transform
from cohelm.messages import PointCloud
from cohelm.robots import CloudMount
from cohelm.simulation.sensors.column_raycast import cast_columns
from cohelm.simulation.sensors.human_bodies import HumanBodies, parts_of
from cohelm.simulation.sensors.static_scene import StaticScene, tops_of

_UPRIGHT = 1e-9
"""Minimum horizontal component of a unit ray, also of one straight down."""


@value
class LabelledCloud:
    """Point cloud with ground truth; p points, n bodies."""

    cloud: PointCloud
    owner: Annotated[Integers, Shape("p")]
    """Index of the body of each point, −1: none."""
    visible: Annotated[Floats, Shape("n")]
    """Visible share of each body: rays that hit it, divided by those that would hit it on an empty
    floor without blind sectors; 0 without any. Dropouts are not counted."""


def scan_cloud(
    mount: CloudMount,
    scene: StaticScene,
    bodies: HumanBodies,
    X_MR: Floats,
    *,
    time: float,
    rng: np.random.Generator,
) -> PointCloud:
    """Simulate one sweep of a LiDAR or depth camera; see :func:`sweep_cloud`."""
    return sweep_cloud(mount, scene, bodies, X_MR, time=time, rng=rng).cloud


def sweep_cloud(
    mount: CloudMount,
    scene: StaticScene,
    bodies: HumanBodies,
    X_MR: Floats,
    *,
    time: float,
    rng: np.random.Generator,
) -> LabelledCloud:
    """Simulate one sweep with ground truth; the chair itself is not detected.

    All rays are cast at the same instant. The chair is inclined as the floor under its axle. The
    number of random draws is constant.

    Args:
        mount: the sensor on the robot.
        scene: true obstacles.
        bodies: true people.
        X_MR: (3,) the robot's true pose.
        time: of the sweep, s.
        rng: for noise and dropouts.

    Returns:
        A cloud with one row for each ray, column after column, lowest first; a row is NaN without a
        return, after a dropout, and in a blind sector.
    """
    distance, owner, visible = _cast(mount, scene, bodies, X_MR)
    cloud = measured_cloud(mount, distance, time=time, rng=rng)
    gone = np.isnan(cloud.points[:, 0])
    return LabelledCloud(cloud=cloud, owner=np.where(gone, -1, owner), visible=visible)


def measured_cloud(
    mount: CloudMount, distance: Floats, *, time: float, rng: np.random.Generator
) -> PointCloud:
    """Add noise, dropouts and blind sectors to the true distances (p,) of all rays, m."""
    rays, hidden = rays_of(mount)
    noise = rng.standard_normal(len(rays))
    lost = rng.random(len(rays)) < mount.dropout
    gone = lost | hidden | (distance < mount.range_min) | np.isinf(distance)
    distance = np.where(gone, np.nan, distance)
    seen = np.clip(distance + mount.deviation(distance) * noise, mount.range_min, mount.range_max)
    points = (seen[:, None] * rays).astype(np.float32)
    return PointCloud(
        time=time,
        mount=np.asarray(mount.pose, dtype=float),
        points=points,
        range_max=mount.range_max,
    )


def visible_shares(
    mount: CloudMount, scene: StaticScene, bodies: HumanBodies, X_MR: Floats
) -> Floats:
    """Visible share (n,) of each body; see :attr:`LabelledCloud.visible`."""
    return _cast(mount, scene, bodies, X_MR)[2]


def sensor_pose(mount: CloudMount, scene: StaticScene, X_MR: Floats) -> tuple[Floats, Floats]:
    """Origin (3,) and rotation (3, 3) of the sensor in the map frame.

    The robot's z axis is the normal of the floor under its axle.
    """
    x, y, z, roll, pitch, yaw = mount.pose
    slope = scene.floor.slope(X_MR[:2])
    up = np.array([-slope[0], -slope[1], 1.0])
    up /= np.linalg.norm(up)
    ahead = np.array([math.cos(X_MR[2]), math.sin(X_MR[2]), 0.0])
    ahead -= (ahead @ up) * up
    ahead /= np.linalg.norm(ahead)
    R_MR = np.stack([ahead, np.cross(up, ahead), up], axis=-1)
    foot = np.array([*transform(X_MR, np.zeros(2)), float(scene.floor.height(X_MR[:2]))])
    return foot + R_MR @ np.array([x, y, z]), R_MR @ rotation_of(roll, pitch, yaw)


def _cast(
    mount: CloudMount, scene: StaticScene, bodies: HumanBodies, X_MR: Floats
) -> tuple[Floats, Integers, Floats]:
    """Distance (p,), m, owner (p,) and visible share (n,), without noise and dropouts."""
    rays, hidden = rays_of(mount)
    origin, R_MS = sensor_pose(mount, scene, X_MR)
    towards = rays @ R_MS.T
    level = np.maximum(np.hypot(towards[:, 0], towards[:, 1]), _UPRIGHT)
    shape = mount.rays().shape[:2] if _share_planes(R_MS) else (len(rays), 1)
    tops, highest = tops_of(scene)
    far, owner, alone = cast_columns(
        tops,
        scene.grid.resolution,
        scene.grid.X_MG,
        scene.floor.numbers,
        scene.ceiling,
        highest,
        origin,
        np.ascontiguousarray((towards[:, :2] / level[:, None]).reshape(*shape, 2)[:, 0]),
        (towards[:, 2] / level).reshape(shape),
        (mount.range_max * level).reshape(shape),
        np.column_stack([bodies.position, bodies.radius]),
        parts_of(bodies, scene.floor),
    )
    owner = owner.reshape(-1)
    met = np.bincount(owner[(owner >= 0) & ~hidden], minlength=len(alone))
    return far.reshape(-1) / level, owner, met / np.maximum(alone, 1)


@lru_cache(maxsize=8)
def rays_of(mount: CloudMount) -> tuple[Floats, Booleans]:
    """Unit vectors (p, 3) in the sensor's frame, and mask (p,) of the blind ones."""
    return read_only(mount.rays().reshape(-1, 3)), mount.hidden().reshape(-1)


def rotation_of(roll: float, pitch: float, yaw: float) -> Floats:
    """Rotation (3, 3) about the fixed axes x, y, z in this order (REP-103)."""
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(a), math.sin(a)) for a in (roll, pitch, yaw))
    about_x = np.array([[1.0, 0.0, 0.0], [0.0, cr, -sr], [0.0, sr, cr]])
    about_y = np.array([[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]])
    about_z = np.array([[cy, -sy, 0.0], [sy, cy, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(about_z @ about_y @ about_x)


def _share_planes(R_MS: Floats) -> bool:
    """Check that the sensor is upright, so that rays of one column share a vertical plane."""
    return bool(abs(R_MS[2, 2] - 1.0) < 1e-12)
