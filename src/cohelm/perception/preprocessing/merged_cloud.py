"""Clouds of several sensors merged into one, above the floor on which the robot stands."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import stable_order
from cohelm.arrays import Floats, Floats32, Integers
from cohelm.geometry import compose, inverse
from cohelm.kernels import CACHED
from cohelm.messages import PointCloud

MIN_RANGE = 0.05
"""Nearer returns are ignored: drivers fill gaps with zeros, m."""
_FINE, _COARSE = 7200, 90
"""Bins of a turn, 0.05° and 4° wide, for counting the sensor's directions."""
_CELL, _SPREAD = 0.5, 0.3
"""Side of the cells for the search of an unknown floor, and its unevenness, m."""
_LOWEST_SENSOR, _HIGHEST_SENSOR = 0.15, 3.5
"""Possible mounting heights of a sensor, m."""


class MergedCloud(NamedTuple):
    """Usable returns of several clouds in one frame S; p returns.

    S lies on the floor below the first sensor; its axes are the robot's at the first cloud's time.
    """

    points: Floats
    """(p, 3), x and y from the first sensor, z from the floor under the robot, m."""
    X_MS: Floats
    """(3,), pose of S in the map frame, m and rad."""
    azimuth_step: float
    """Angle between neighbouring azimuths of the coarsest sensor, rad."""
    elevation_step: float
    """Angle between neighbouring elevations of the coarsest sensor, rad."""
    view: Floats
    """(s, 3), of each usable sensor: the lowest and the highest slope dz/dr of its returns, and its
    range, m; 0 without returns."""
    sensors: Floats
    """(s, 3), positions of the sensors in the same frame, m."""
    parts: Integers
    """(s + 1,), first return of each sensor, and the end of the last."""

    def in_view(self, places: Floats) -> Floats:
        """(2, n) lower and upper bound of the heights visible at places (n, 2), m.

        A place beyond the range of all sensors is treated as within it: noise moved it there.
        """
        distance = self._distance(places)
        out = distance > self.view[:, 2]
        out &= ~out.all(axis=1, keepdims=True)
        low = self.sensors[:, 2] + self.view[:, 0] * distance
        high = self.sensors[:, 2] + self.view[:, 1] * distance
        return np.array(
            [np.where(out, np.inf, low).min(axis=1), np.where(out, -np.inf, high).max(axis=1)]
        )

    def range_left(self, places: Floats) -> Floats:
        """(n,) largest range of a sensor beyond places (n, 2), m."""
        left: Floats = (self.view[:, 2] - self._distance(places)).max(axis=1)
        return left

    def _distance(self, places: Floats) -> Floats:
        """(n, s) distance from each sensor to places (n, 2), m."""
        apart = places[:, None] - self.sensors[:, :2]
        return np.hypot(apart[..., 0], apart[..., 1])


def merge_clouds(clouds: tuple[PointCloud, ...], X_MR: Floats, reach: float) -> MergedCloud:
    """Merge the returns of c clouds within ``reach``, m, of the first sensor.

    A row that is not finite, within 5 cm of its sensor or beyond the sensor's range is no return; a
    cloud whose pose is not finite has none. If a sensor's height is unknown, the floor is found
    from the lowest returns (see ``_floor``). X_MR: (c, 3), robot pose at each cloud.
    """
    usable = [k for k, cloud in enumerate(clouds) if has_pose(cloud, X_MR[k])]
    if not usable:
        none = np.empty((0, 3))
        return MergedCloud(
            points=none,
            X_MS=np.zeros(3),
            azimuth_step=0.0,
            elevation_step=0.0,
            view=none,
            sensors=none,
            parts=np.zeros(1, dtype=np.int64),
        )
    first = usable[0]
    X_MS = compose(X_MR[first], [*clouds[first].mount[:2], 0.0])
    X_SM = inverse(X_MS)
    parts, sensors = [], []
    steps, view = np.zeros(2), np.zeros((len(usable), 3))
    for i, k in enumerate(usable):
        rotation, position = placed(compose(X_SM, X_MR[k]), clouds[k].mount)
        range_max = clouds[k].range_max if clouds[k].range_max > 0.0 else 0.0
        points, slopes = _transformed(
            clouds[k].points, rotation, position, float(reach), float(range_max)
        )
        if not math.isfinite(clouds[k].mount[2]):
            down = -_floor(points, reach)
            points[:, 2] += down
            position[2] = down
        if len(points):
            steps = np.maximum(steps, _angle_steps(clouds[k].points))
        if np.isfinite(slopes).all():
            view[i] = [*slopes, min(reach, range_max)]
        parts.append(points)
        sensors.append(position)
    together = parts[0] if len(parts) == 1 else np.concatenate(parts)
    first_of = np.cumsum([0, *(len(part) for part in parts)])
    return MergedCloud(
        points=together,
        X_MS=X_MS,
        azimuth_step=steps[0],
        elevation_step=steps[1],
        view=view,
        sensors=np.array(sensors),
        parts=first_of,
    )


def has_pose(cloud: PointCloud, X_MR: Floats) -> bool:
    """Check that the pose is known, except perhaps the height."""
    mount = np.delete(cloud.mount, 2)
    return bool(np.isfinite(mount).all() and np.isfinite(X_MR).all())


def placed(X_SR: Floats, mount: Floats) -> tuple[Floats, Floats]:
    """Rotation (3, 3) and position (3,) of a sensor mounted on a robot at ``X_SR``; z 0 if NaN."""
    roll, pitch, yaw = mount[3], mount[4], mount[5] + X_SR[2]
    cr, sr, cp, sp = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    cy, sy = math.cos(yaw), math.sin(yaw)
    rotation = np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )
    at = compose(X_SR, [mount[0], mount[1], 0.0])
    height = mount[2] if math.isfinite(mount[2]) else 0.0
    return rotation, np.array([at[0], at[1], height])


@njit(**CACHED)
def _transformed(
    points: Floats32, rotation: Floats, position: Floats, reach: float, range_max: float
) -> tuple[Floats, Floats]:
    """Transformed returns within reach and range, and the extreme slopes within range.

    Args:
        points: (p, 3) in the sensor's frame, m.
        rotation, position: (3, 3) and (3,) m, of the sensor in frame S.
        reach: largest horizontal distance from the origin of S, m.
        range_max: of the sensor, m.
    """
    out = np.empty((points.shape[0], 3))
    count = 0
    lowest, highest = np.inf, -np.inf
    nearest_sq, farthest_sq, reach_sq = MIN_RANGE**2, (1.000001 * range_max) ** 2, reach**2
    r = rotation
    for i in range(points.shape[0]):
        px, py, pz = np.float64(points[i, 0]), np.float64(points[i, 1]), np.float64(points[i, 2])
        squared = px * px + py * py + pz * pz
        if not (nearest_sq <= squared <= farthest_sq):  # also false for NaN
            continue
        dx = r[0, 0] * px + r[0, 1] * py + r[0, 2] * pz
        dy = r[1, 0] * px + r[1, 1] * py + r[1, 2] * pz
        dz = r[2, 0] * px + r[2, 1] * py + r[2, 2] * pz
        away = dx * dx + dy * dy
        if away > 0.25:
            slope = dz / math.sqrt(away)
            lowest, highest = min(lowest, slope), max(highest, slope)
        x, y = position[0] + dx, position[1] + dy
        if x * x + y * y <= reach_sq:
            out[count, 0], out[count, 1], out[count, 2] = x, y, position[2] + dz
            count += 1
    return out[:count], np.array([lowest, highest])


@njit(**CACHED)
def _angle_steps(points: Floats32) -> Floats:
    """Angles between neighbouring azimuths and elevations, (2,) rad.

    Width of the hit coarse bins over the number of hit fine ones. Only returns near the sensor's
    horizon, or near the vertical plane through its x axis, count: there all rings have the same
    azimuths, and all azimuths the same elevations.
    """
    fine = np.zeros((2, _FINE), dtype=np.bool_)
    coarse = np.zeros((2, _COARSE), dtype=np.bool_)
    scale, each = _FINE / (2.0 * math.pi), _FINE // _COARSE
    for i in range(points.shape[0]):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        squared = x * x + y * y
        if not (1e-3 < squared < np.inf and z * z < np.inf):
            continue
        if 100.0 * z * z < squared:
            b = int((math.atan2(y, x) + math.pi) * scale) % _FINE
            fine[0, b] = coarse[0, b // each] = True
        if 25.0 * y * y < x * x:
            b = int((math.atan2(z, math.sqrt(squared)) + math.pi) * scale) % _FINE
            fine[1, b] = coarse[1, b // each] = True
    most = 2.0 * math.pi / _COARSE
    out = np.full(2, most)
    for k in range(2):
        if fine[k].any():
            out[k] = most * coarse[k].sum() / fine[k].sum()
    return out


@njit(**CACHED)
def _floor(points: Floats, reach: float) -> float:
    """Height of the floor relative to the sensor, m.

    Mean of the lowest returns of cells of 0.5 m, over the 0.3 m of height that hold most of them.
    Near cells weigh more: a floor may slope farther away. With fewer than five cells, the lowest
    return.
    """
    side = int(2.0 * reach / _CELL) + 2
    lowest = np.full(side * side, np.inf)
    for i in range(points.shape[0]):
        z = points[i, 2]
        if -_HIGHEST_SENSOR <= z <= -_LOWEST_SENSOR:
            row, col = int((points[i, 1] + reach) / _CELL), int((points[i, 0] + reach) / _CELL)
            lowest[row * side + col] = min(lowest[row * side + col], z)
    cells = np.flatnonzero(lowest < np.inf)
    if cells.size < 5:
        return min(points[:, 2].min(), -_LOWEST_SENSOR) if points.shape[0] else -_LOWEST_SENSOR
    cells = cells[stable_order(lowest[cells])]
    found, weight = lowest[cells], np.empty(cells.size)
    for k in range(cells.size):
        x = (cells[k] % side + 0.5) * _CELL - reach
        y = (cells[k] // side + 0.5) * _CELL - reach
        weight[k] = 1.0 / (x * x + y * y)
    best = height = within = 0.0
    last = 0
    for first in range(found.size):
        while last < found.size and found[last] <= found[first] + _SPREAD:
            within += weight[last]
            last += 1
        if within > best:
            best = within
            height = (found[first:last] * weight[first:last]).sum() / weight[first:last].sum()
        within -= weight[first]
    return height
