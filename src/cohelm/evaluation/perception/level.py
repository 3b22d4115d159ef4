"""Axes of clouds whose sensor's mount is unknown, from the floor that they show.

Sensors have z up (REP-103), cameras x right, y down and z forward, other programs y up; a sensor
may be pitched, or hang upside down. The floor is the largest plane below the sensor with hardly
anything below it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Booleans, Floats, Floats32, replace
from cohelm.messages import PointCloud
from cohelm.recordings import Frame

OPTICAL = np.array([[0.0, 0.0, 1.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]])
"""Rotation from the axes of a camera to x forward, y left, z up."""
NO_FLOOR = (
    "no floor found, so no people either: expected x forward, y left, z up, or a camera's x right, "
    "y down, z forward, a floor 0.15 to 3.5 m below the sensor, and at most 40° of tilt; rotate "
    "the cloud, or record the sensor's mount in tf"
)
AXES = "axes taken from the floor: {}"
_HEIGHTS = 0.15, 3.5
"""Possible heights of a sensor above the floor, m."""
_CELL, _REACH, _MOST = 0.1, 8.0, 4000
"""Side of the cells that are compared, m, their largest distance, m, and their number."""
_FLAT, _TILT, _LEVEL = 0.05, math.cos(math.radians(40.0)), math.cos(math.radians(10.0))
"""Thickness of a floor, m, and cosines of the largest tilt, and of the largest that is ignored."""
_SHARE, _BELOW, _STANDING, _LOW = 0.05, 0.03, 0.05, 1.5
"""Share of the cells that a floor has at least, that may lie below it, and that stands on it up to
a height, m."""
_TRIALS, _POINTS = 300, 50_000
"""Number of planes that are tried, and of the points from which the cells are taken."""
_CAMERA = 0.5, 0.95
"""Cosine of half the view of a camera, and the share of the cells within it."""


class Leveller:
    """Turns the clouds of one sensor level; its axes are those of the first cloud with a floor.

    Args:
        frame: Name of its frame: ``*_optical_frame`` has the axes of a camera (REP-103).
    """

    def __init__(self, frame: str = "") -> None:
        self._optical = frame.endswith("optical_frame")
        self._level: Level | None = None

    def __call__(self, cloud: PointCloud) -> tuple[PointCloud, str]:
        """Cloud with x forward, y left and z up, and a warning where it was not certainly so."""
        points = cloud.points @ OPTICAL.T.astype(np.float32) if self._optical else cloud.points
        if self._level is None:
            self._level = find_level(points)
        warning = NO_FLOOR
        if self._level is not None:
            points = points @ self._level.rotation.T.astype(np.float32)
            warning = AXES.format(self._level.name) if self._level.name else ""
        return replace(cloud, points=points), warning


class Levellers:
    """Turns the clouds of all sensors of unknown mount level."""

    def __init__(self) -> None:
        self._known: dict[str, Leveller] = {}

    def __call__(self, frame: Frame) -> tuple[Frame, str]:
        """Frame with level clouds, and a warning, see ``Leveller``."""
        clouds, said = [], ""
        for cloud in frame.observation.clouds:
            if frame.posed or not is_unknown(cloud.mount):
                clouds.append(cloud)
                continue
            level = self._known.setdefault(frame.unplaced, Leveller(frame.unplaced))
            turned, said = level(cloud)
            clouds.append(turned)
        observation = replace(frame.observation, clouds=tuple(clouds))
        return replace(frame, observation=observation), said


def is_unknown(mount: Floats) -> bool:
    """Check that a mount (6,) says nothing about a sensor's height and axes."""
    return math.isnan(mount[2]) and not mount[3:].any()


class Level(NamedTuple):
    """Axes of a sensor."""

    rotation: Floats
    """(3, 3), to x forward, y left, z up."""
    name: str
    """The direction of up, in words; empty where the axes are as expected."""
    up: Floats
    """(3,) normal of the floor in the sensor's axes."""
    height: float
    """Height of the sensor over the floor, m."""


class _Plane(NamedTuple):
    normal: Floats
    floor: Booleans
    """Mask of the cells in it."""
    standing: float
    """Share of the cells shortly above it."""
    height: float
    """Height of the sensor over it, m."""


def find_level(points: Floats32) -> Level | None:
    """Find the axes of a sensor from one cloud (p, 3); None: it shows no floor."""
    cells = _cells(points)
    if len(cells) < 50:
        return None
    planes = _planes(cells)
    along = cells[:, 2] / np.linalg.norm(cells, axis=1)
    ahead = float(np.sign(np.median(along)) or 1.0)
    camera = bool(np.mean(ahead * along > _CAMERA[0]) > _CAMERA[1])
    z, y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    forward = np.array([0.0, 0.0, ahead]) if camera else z
    x = np.array([1.0, 0.0, 0.0])
    # A camera that faces a wall does not hang upside down.
    known = [("", z, x), ("-y", -y, forward), ("y", y, forward)]
    known += [] if camera else [("-z", -z, x)]
    for name, up, front in known:
        plane = _best(planes, up)
        # A wall beside a sensor is no floor: nothing stands on it.
        if plane is None or (name and plane.standing < _STANDING):
            continue
        cosine = float(plane.normal @ up)
        if cosine >= _LEVEL and not name:
            return Level(np.eye(3), "", plane.normal, plane.height)
        tilt = math.degrees(math.acos(min(cosine, 1.0)))
        words = f"{name or 'z'} up, tilted by {tilt:.0f}°"
        return Level(_axes(plane.normal, front), words, plane.normal, plane.height)
    return None


def _cells(points: Floats32) -> Floats:
    """Finite points within reach, one for each cell: near ones are too many."""
    given = points[np.isfinite(points).all(axis=1)]
    given = given[:: max(len(given) // _POINTS, 1)].astype(np.float64)
    away = np.linalg.norm(given, axis=1)
    given = given[(away > _HEIGHTS[0]) & (away < _REACH)]
    _, first = np.unique(np.floor(given / _CELL).astype(np.int64), axis=0, return_index=True)
    cells: Floats = given[np.sort(first)][:: max(len(first) // _MOST, 1)]
    return cells


def _planes(cells: Floats) -> list[_Plane]:
    """Planes below the sensor that may be floors, through three cells each."""
    rng = np.random.default_rng(0)  # the same planes for the same cloud
    a, b, c = cells[rng.integers(len(cells), size=(3, _TRIALS))]
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    a, normal = a[size > 1e-6], normal[size > 1e-6] / size[size > 1e-6, None]
    height = -(normal * a).sum(axis=1)
    normal *= np.sign(height)[:, None]
    out = []
    for each, below in zip(normal, np.abs(height), strict=True):
        if _HEIGHTS[0] <= below <= _HEIGHTS[1]:
            off = cells @ each + below
            floor = np.abs(off) < _FLAT
            if floor.mean() > _SHARE and np.mean(off < -2.0 * _FLAT) < _BELOW:
                low = (off > 2.0 * _FLAT) & (off < _LOW)
                out.append(_Plane(each, floor, float(low.mean()), float(below)))
    return [_refined(cells, each) for each in out]


def _refined(cells: Floats, plane: _Plane) -> _Plane:
    """The plane of least squares through its cells."""
    floor = cells[plane.floor]
    _, _, axes = np.linalg.svd(floor - floor.mean(axis=0), full_matrices=False)
    normal = axes[2] * np.sign(axes[2] @ plane.normal)
    return plane._replace(normal=normal, height=-float(floor.mean(axis=0) @ normal))


def _best(planes: list[_Plane], up: Floats) -> _Plane | None:
    """The largest plane that may be tilted against a direction up."""
    fitting = [each for each in planes if float(each.normal @ up) >= _TILT]
    return max(fitting, key=lambda each: int(each.floor.sum()), default=None)


def _axes(up: Floats, front: Floats) -> Floats:
    """Rotation (3, 3) whose rows are forward, left and up."""
    forward = front - (front @ up) * up
    forward /= np.linalg.norm(forward)
    return np.array([forward, np.cross(up, forward), up])
