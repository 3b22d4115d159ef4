"""3-D LiDARs and depth cameras: rays, range noise and dropouts, and the owner of each point.

Rays are cast on a floor, extruded cells and bodies, one vertical plane after another. All rays of a
plane share one walk through the cells (Amanatides and Woo 1987). From one point a steeper ray never
ends before a less steep one: over a height field the lowest rays end first, so one pointer moves up
through the rays as the walk proceeds.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, read_only, value
from cohelm.kernels import CACHED, callee
from cohelm.messages import PointCloud
from cohelm.robots import CloudMount
from cohelm.simulation.sensors.floor_relief import FloorCells
from cohelm.simulation.sensors.grid_raycast import span, stride
from cohelm.simulation.sensors.human_bodies import HumanBodies, parts_of
from cohelm.simulation.sensors.static_scene import StaticScene, floor_height, to_floor, tops_of


@njit(**CACHED)
def cast_columns(
    tops: Floats32,
    resolution: float,
    X_MG: Floats,
    floor: Floats,
    ceiling: float,
    highest: float,
    origin: Floats,
    directions: Floats,
    slopes: Floats,
    reach: Floats,
    circles: Floats,
    parts: Floats,
) -> tuple[Floats, Integers, Integers]:
    """Cast c vertical planes of r rays each.

    Args:
        tops: (rows, cols) height of the obstacles over the floor, m.
        resolution: side of a cell, m.
        X_MG: (3,) the grid in the map frame.
        floor: its numbers.
        ceiling: its height, m; inf without any.
        highest: maximum height of obstacles over 0, m.
        origin: (3,) of the sensor in the map frame, over the floor.
        directions: (c, 2) horizontal unit vectors, map frame.
        slopes: (c, r) rise over run of the rays, ascending.
        reach: (c, r) horizontal range of the rays, m.
        circles: (n, 3) discs of the bodies as (x, y, radius), m.
        parts: (n, k, 11), see ``human_bodies.parts_of``.

    Returns:
        (c, r) horizontal distance of the hit, m, +inf without a hit; (c, r) index of the body hit,
        −1: none; (n,) number of rays that would hit each body on an empty floor.
    """
    columns, rings = slopes.shape
    out = np.full((columns, rings), np.inf)
    owner = np.full((columns, rings), -1, dtype=np.int64)
    alone = np.zeros(circles.shape[0], dtype=np.int64)
    cos, sin = math.cos(X_MG[2]), math.sin(X_MG[2])
    ox, oy = origin[0] - X_MG[0], origin[1] - X_MG[1]
    x, y = (cos * ox + sin * oy) / resolution, (-sin * ox + cos * oy) / resolution
    near = _within_range(circles, origin, reach.max() if reach.size else 0.0)
    best = np.empty(rings)
    for c in range(columns):
        dx, dy = directions[c, 0], directions[c, 1]
        # Floor and ceiling first: they bound the walk through the cells.
        limit = 0.0
        for r in range(rings):
            slope = slopes[c, r]
            t = to_floor(floor, origin, dx, dy, slope)
            far = reach[c, r]
            if slope > 0.0:
                t = min(t, (ceiling - origin[2]) / slope)
                far = min(far, max((highest - origin[2]) / slope, 0.0))
            out[c, r] = t
            limit = max(limit, min(far, t))
        # Extruded cells, then bodies.
        gx, gy = cos * dx + sin * dy, -sin * dx + cos * dy
        _through_cells(tops, resolution, floor, origin, dx, dy, x, y, gx, gy, limit, slopes, out, c)
        for j in range(near.shape[0]):
            rx, ry, radius = near[j, 0], near[j, 1], near[j, 2]
            if rx * dx + ry * dy < -radius or abs(rx * dy - ry * dx) > radius:
                continue
            _against_body(
                int(near[j, 3]), rx * dx + ry * dy, radius, parts, origin, dx, dy, slopes, reach,
                best, out, owner, alone, c
            )  # fmt: skip
        for r in range(rings):
            if out[c, r] > reach[c, r]:
                out[c, r] = np.inf
    return out, owner, alone


@callee()
def _within_range(circles: Floats, origin: Floats, reach: float) -> Floats:
    """Bodies within range, (m, 4): x, y from the origin, radius, index."""
    out = np.empty((circles.shape[0], 4))
    count = 0
    for k in range(circles.shape[0]):
        rx, ry, radius = circles[k, 0] - origin[0], circles[k, 1] - origin[1], circles[k, 2]
        if math.hypot(rx, ry) - radius <= reach:
            out[count, 0], out[count, 1], out[count, 2], out[count, 3] = rx, ry, radius, k
            count += 1
    return out[:count]


@callee()
def _through_cells(
    tops: Floats32,
    resolution: float,
    floor: Floats,
    origin: Floats,
    dx: float,
    dy: float,
    x: float,
    y: float,
    gx: float,
    gy: float,
    limit: float,
    slopes: Floats,
    out: Floats,
    column: int,
) -> None:
    """Shorten the rays of one plane to the faces and tops of the cells that they hit.

    x, y, gx, gy: origin and direction in cells of the grid; limit: horizontal range, m.
    """
    rows, cols = tops.shape
    t, leave = span(x, gx, cols, 0.0, limit / resolution)
    t, leave = span(y, gy, rows, t, leave)
    if t > leave:
        return
    c = min(max(math.floor(x + t * gx), 0), cols - 1)
    r = min(max(math.floor(y + t * gy), 0), rows - 1)
    step_c, next_c, per_c = stride(x, gx, c)
    step_r, next_r, per_r = stride(y, gy, r)
    low, rings = 0, slopes.shape[1]
    while True:
        if tops[r, c] > 0.0:
            enter, gone = t * resolution, min(next_c, next_r) * resolution
            top = tops[r, c] + floor_height(floor, origin[0] + enter * dx, origin[1] + enter * dy)
            while low < rings:
                # Otherwise the floor is hit first.
                if out[column, low] > enter:
                    slope = slopes[column, low]
                    if origin[2] + slope * enter <= top:
                        out[column, low] = enter
                    elif slope < 0.0 and origin[2] + slope * gone <= top:
                        out[column, low] = min(out[column, low], (top - origin[2]) / slope)
                    else:
                        break
                low += 1
            if low == rings:
                return
        if next_c < next_r:
            t, c, next_c = next_c, c + step_c, next_c + per_c
        else:
            t, r, next_r = next_r, r + step_r, next_r + per_r
        if t > leave or not (0 <= c < cols and 0 <= r < rows):
            return


@callee()
def _against_body(
    index: int,
    along: float,
    radius: float,
    parts: Floats,
    origin: Floats,
    dx: float,
    dy: float,
    slopes: Floats,
    reach: Floats,
    best: Floats,
    out: Floats,
    owner: Integers,
    alone: Integers,
    column: int,
) -> None:
    """Shorten the rays of one plane that hit a body first.

    along, radius: interval of the body's disc in the plane; no part can be hit outside of it.
    """
    best[:] = np.inf
    enter, leave = max(along - radius, 0.0), along + radius
    for k in range(parts.shape[1]):
        part = parts[index, k]
        for r in range(slopes.shape[1]):
            slope = slopes[column, r]
            z, then = origin[2] + slope * enter, origin[2] + slope * leave
            if max(z, then) >= part[4] and min(z, then) <= part[5]:
                best[r] = min(best[r], _to_part(part, origin, dx, dy, slope))
    for r in range(slopes.shape[1]):
        if best[r] > reach[column, r]:
            continue
        alone[index] += 1
        if best[r] < out[column, r]:
            out[column, r], owner[column, r] = best[r], index


@njit(**CACHED, inline="always")
def _to_part(part: Floats, origin: Floats, dx: float, dy: float, slope: float) -> float:
    """Horizontal distance at which a ray hits a part of a body; inf: no hit.

    In the part's own ellipse a ray is q(t) = p + t v and the part's rim |q| = ρ_0 + t ρ', both
    linear in t; the hit is the nearest root between the part's ends, or on an end.
    """
    below = origin[2] - part[4]
    px, py = origin[0] - part[0] - part[2] * below, origin[1] - part[1] - part[3] * below
    vx, vy = dx - part[2] * slope, dy - part[3] * slope
    pa, pb = (px * part[6] + py * part[7]) * part[8], (py * part[6] - px * part[7]) * part[9]
    va, vb = (vx * part[6] + vy * part[7]) * part[8], (vy * part[6] - vx * part[7]) * part[9]
    rim, widens = 1.0 + part[10] * below, part[10] * slope
    a = va * va + vb * vb - widens * widens
    b = pa * va + pb * vb - rim * widens
    c = pa * pa + pb * pb - rim * rim
    inside = b * b - a * c
    best = np.inf
    if inside < 0.0:
        if a > 0.0:
            return best
    elif a != 0.0:
        root = math.sqrt(inside)
        for side in (-1.0, 1.0):
            t = (-b + side * root) / a
            z = origin[2] + t * slope
            if 0.0 <= t < best and part[4] <= z <= part[5] and rim + t * widens >= 0.0:
                best = t
    if slope != 0.0:
        for end in (part[4], part[5]):
            t = (end - origin[2]) / slope
            qa, qb, edge = pa + t * va, pb + t * vb, rim + t * widens
            if 0.0 <= t < best and qa * qa + qb * qb <= edge * edge:
                best = t
    return best


_UPRIGHT = 1e-9
"""Minimum horizontal component of a unit ray, also of one straight down."""
_ROUNDING = 1e-3
"""Bound on the rounding error of the height of a hit, m: cells store 32 bits."""


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
    gone = lost | hidden.reshape(-1) | (distance < mount.range_min) | np.isinf(distance)
    distance = np.where(gone, np.nan, distance)
    seen = np.clip(distance + mount.deviation(distance) * noise, mount.range_min, mount.range_max)
    points = (seen[:, None] * rays).astype(np.float32)
    return PointCloud(
        time=time,
        mount=np.asarray(mount.pose, dtype=float),
        points=points,
        range_max=mount.range_max,
    )


def sensor_pose(mount: CloudMount, scene: StaticScene, X_MR: Floats) -> tuple[Floats, Floats]:
    """Origin (3,) and rotation (3, 3) of the sensor in the map frame.

    The robot's z axis is the normal of the floor under its axle.
    """
    x, y, z, roll, pitch, yaw = mount.pose
    height, slope = scene.stance(X_MR)
    up = np.array([-slope[0], -slope[1], 1.0])
    up /= np.linalg.norm(up)
    ahead = np.array([math.cos(X_MR[2]), math.sin(X_MR[2]), 0.0])
    ahead -= (ahead @ up) * up
    ahead /= np.linalg.norm(ahead)
    R_MR = np.stack([ahead, np.cross(up, ahead), up], axis=-1)
    foot = np.array([X_MR[0], X_MR[1], height])
    return foot + R_MR @ np.array([x, y, z]), R_MR @ rotation_of(roll, pitch, yaw)


def _cast(
    mount: CloudMount, scene: StaticScene, bodies: HumanBodies, X_MR: Floats
) -> tuple[Floats, Integers, Floats]:
    """Distance (p,), m, owner (p,) and visible share (n,), without noise and dropouts."""
    rays, hidden = rays_of(mount)
    origin, R_MS = sensor_pose(mount, scene, X_MR)
    towards = rays @ R_MS.T
    level = np.maximum(np.hypot(towards[:, 0], towards[:, 1]), _UPRIGHT)
    shape = hidden.shape if _share_planes(R_MS) else (len(rays), 1)
    tops, highest = tops_of(scene)
    base = np.array([0.0, 0.0, scene.base])
    far, owner, alone = cast_columns(
        tops,
        scene.grid.resolution,
        scene.grid.X_MG,
        scene.floor.numbers,
        scene.ceiling - scene.base,
        highest,
        origin - base,
        towards.reshape(*shape, 3)[:, 0, :2] / level.reshape(shape)[:, :1],
        (towards[:, 2] / level).reshape(shape),
        (mount.range_max * level).reshape(shape),
        np.column_stack([bodies.position, bodies.radius]),
        parts_of(bodies, scene.floor_height(bodies.position) - scene.base),
    )
    far = far.reshape(-1)
    if scene.cells is not None and scene.cells.dark.any():
        far[_on_dark_floor(scene.cells, origin, towards / level[:, None], far)] = np.inf
    owner = owner.reshape(-1)
    met = np.bincount(owner[(owner >= 0) & ~hidden.reshape(-1)], minlength=len(alone))
    return far / level, owner, met / np.maximum(alone, 1)


def _on_dark_floor(cells: FloorCells, origin: Floats, towards: Floats, far: Floats) -> Booleans:
    """Mask (p,) of rays, (p, 3) per horizontal metre, that end on floor without a return."""
    hit = np.isfinite(far)
    ends = origin + np.where(hit, far, 0.0)[:, None] * towards
    low = ends[:, 2] <= cells.height(ends[:, :2]) + _ROUNDING
    return np.asarray(hit & low & cells.is_dark(ends[:, :2]))


@lru_cache(maxsize=8)
def rays_of(mount: CloudMount) -> tuple[Floats, Booleans]:
    """Unit vectors (p, 3) in the sensor's frame, and mask (columns, rows) of the blind ones."""
    return read_only(mount.rays().reshape(-1, 3)), mount.hidden()


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
