"""Affordances: what lies ahead that a rider may mean, within the interval of their direction.

A chair that drives straight on from here sweeps a lane of its own width. The free lengths of the
lanes about the rider's direction, in the distance field of map and live obstacles, show free space,
the axes of corridors, and doors: from a distance a door is the one lane that goes on. Where that
lane is narrow, the passage is laid out from wall to wall, and the chair is led onto its axis, so
that it arrives straight.

After the attractors of shared control (Carlson and Demiris, Collaborative control for a robotic
wheelchair, 2012) and the valleys of vector field histograms (Borenstein and Koren, 1991).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, read_only
from cohelm.geometry import wrap_angle
from cohelm.kernels import CACHED, callee
from cohelm.maps import DistanceField
from cohelm.maps.distance import sample
from cohelm.robots import Robot
from cohelm.robots.wall_contact import WallGrid, wall_grid

_SPACING = math.radians(1.0)
"""Angle between two lanes."""
_GAP = 0.02
"""Gap to walls on either side of a lane, m."""
_OFF_CENTRE = 0.25
"""Share of the reach that a lane at the edge of the interval must be longer than the middle one."""
_SAME = 0.1
"""Share of the reach by which another lane must be better than the last one."""
_NEAR = 0.12
"""Angle up to which a lane is the last one, rad."""
_OPEN = 2.5
"""Length of lanes up to which something is near, m."""
_LEADS, _FEW = 0.9, 0.4
"""Share of the longest lane from which a lane leads on, and share of all lanes that is few."""
_FACES = math.radians(20.0)
"""Angle from a lane that about faces it, rad."""
_NARROW = 1.3
"""Width of a passage up to which the chair is led onto its axis, m."""
_TILT = math.radians(40.0)
"""Largest angle between a lane and the axis of the passage that it leads through."""
_LOOKAHEAD, _NEAREST = 0.65, 0.5
"""Distance along an axis to the point that the chair is led to: share of that to the passage, and
at least this, m."""
_PEOPLE_GAP = 0.1
"""Additional gap to people, m."""
_STEP = 0.02
"""Shortest step along a lane, m."""


_NOBODY: Floats = read_only(np.empty((0, 3)))


class NarrowPassage(NamedTuple):
    """Narrowest place of a lane, from wall to wall."""

    x: float
    """Middle, m."""
    y: float
    axis: float
    """Direction of travel through it, rad."""
    width: float
    """m; +inf: there is none."""


class Aim(NamedTuple):
    """Direction to which the chair is led."""

    heading: float
    """rad."""
    passage: NarrowPassage | None = None
    """Narrow passage that lies there."""


def aim(
    pose: Floats,
    walls: DistanceField,
    robot: Robot,
    *,
    centre: float,
    width: float,
    reach: float,
    last: float,
    standing: Floats = _NOBODY,
) -> Aim:
    """Find the heading that leads on within an interval of directions.

    It is the middle of the interval where this is free over the whole reach, or where nothing else
    leads farther.

    Args:
        pose: X_MR, (3,).
        walls: of map and live obstacles.
        robot: with its width.
        centre: middle of the interval, rad.
        width: half of it, rad.
        reach: distance ahead that is looked at, m.
        last: result of the last call, which is preferred, rad; NaN: none.
        standing: people who stand, (n, 3) as x, y and radius, m.

    Returns:
        The heading, and the narrow passage that it leads to.
    """
    count = int(width / _SPACING)
    if count == 0:
        return Aim(centre)
    offsets: Floats = np.arange(-float(count), count + 1.0) * _SPACING
    grid, radius = wall_grid(walls), robot.inscribed_radius + _GAP
    headings: Floats = centre + offsets
    lengths = free_lengths(grid, standing, pose[:2], headings, radius, reach)
    score = lengths / reach - _OFF_CENTRE * np.abs(offsets) / width
    if not math.isnan(last):
        score += _SAME * (np.abs(wrap_angle(centre + offsets - last)) < _NEAR)
    best = int(np.argmax(score))
    if score[best] <= score[count] + _SAME:
        best = count
    heading = centre + float(offsets[best])
    passage = find_passage(grid, pose[:2], heading, float(lengths[best]))
    narrow = passage.width < _NARROW
    if narrow:
        heading = _onto_axis(pose, passage)
    off = float(wrap_angle(heading - centre))
    return Aim(centre + min(max(off, -width), width), passage if narrow else None)


def is_open(pose: Floats, walls: DistanceField, robot: Robot, standing: Floats = _NOBODY) -> bool:
    """Check that nothing is near in the directions ahead; arguments as of :func:`aim`."""
    headings = pose[2] + np.radians(np.arange(-60.0, 61.0, 4.0))
    radius = robot.inscribed_radius + _GAP
    lengths = free_lengths(wall_grid(walls), standing, pose[:2], headings, radius, _OPEN)
    return bool(lengths.min() >= _OPEN)


def faces_passage(
    pose: Floats, walls: DistanceField, robot: Robot, reach: float, standing: Floats = _NOBODY
) -> bool:
    """Check that the chair about faces one of few lanes that lead on; arguments as :func:`aim`."""
    offsets = np.radians(np.arange(-45.0, 46.0, 1.5))
    radius = robot.inscribed_radius + _GAP
    lengths = free_lengths(wall_grid(walls), standing, pose[:2], pose[2] + offsets, radius, reach)
    leads = lengths > _LEADS * lengths.max()
    few = leads.mean() < _FEW
    return bool(few and np.abs(offsets[leads]).min() < _FACES)


@njit(**CACHED)
def free_lengths(
    walls: WallGrid,
    standing: Floats,
    position: Floats,
    headings: Floats,
    radius: float,
    reach: float,
) -> Floats:
    """Lengths (k,) that a disc can move along each heading (k,), m, at most ``reach``.

    A disc that is closer to a wall or person (n, 3) already keeps the gap that it has.
    """
    out = np.empty(headings.shape[0])
    kept = min(radius, _gap(walls, standing, position[0], position[1]) - 1e-6)
    for k in range(headings.shape[0]):
        cos, sin = math.cos(headings[k]), math.sin(headings[k])
        s = 0.0
        while s < reach:
            x, y = position[0] + s * cos, position[1] + s * sin
            gap = _gap(walls, standing, x, y) - kept
            if gap < 0.0:
                break
            s += max(gap, _STEP)
        out[k] = min(s, reach)
    return out


@callee()
def _gap(walls: WallGrid, standing: Floats, x: float, y: float) -> float:
    """Distance from a point to the nearest wall or person, m."""
    gap = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0]
    for i in range(standing.shape[0]):
        away = math.hypot(x - standing[i, 0], y - standing[i, 1]) - standing[i, 2] - _PEOPLE_GAP
        gap = min(gap, away)
    return gap


@njit(**CACHED)
def find_passage(walls: WallGrid, position: Floats, heading: float, length: float) -> NarrowPassage:
    """Narrowest place of a lane, laid out from wall to wall across the direction of least width."""
    cos, sin = math.cos(heading), math.sin(heading)
    count = int(length / _STEP) + 1
    gaps = np.empty(count)
    for k in range(count):
        x, y = position[0] + _STEP * k * cos, position[1] + _STEP * k * sin
        gaps[k] = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0]
    # The middle of what is about as narrow as the narrowest: inside the wall, not before it.
    narrow = np.flatnonzero(gaps < gaps.min() + _STEP)
    at = _STEP * narrow[narrow.size // 2]
    best = NarrowPassage(position[0] + at * cos, position[1] + at * sin, heading, np.inf)
    # A lane that enters obliquely is closest to a corner, before or behind the narrowest place.
    for j in range(-2, 5):
        x = position[0] + (at + 0.05 * j) * cos
        y = position[1] + (at + 0.05 * j) * sin
        for k in range(-8, 9):
            axis = heading + k * _TILT / 8.0
            left = _to_wall(walls, x, y, axis + 0.5 * math.pi)
            right = _to_wall(walls, x, y, axis - 0.5 * math.pi)
            if left + right < best.width - 1e-3:
                side = 0.5 * (left - right)
                best = NarrowPassage(
                    x - side * math.sin(axis), y + side * math.cos(axis), axis, left + right
                )
    return best


@callee()
def _to_wall(walls: WallGrid, x: float, y: float, heading: float) -> float:
    """Distance to the wall in a direction, m; +inf beyond the width of a narrow passage."""
    cos, sin, s = math.cos(heading), math.sin(heading), 0.0
    while s < _NARROW:
        gap = sample(walls.distance, walls.resolution, walls.X_MG, x + s * cos, y + s * sin)[0]
        if gap < 0.01:
            return s
        s += max(gap, 0.01)
    return np.inf


def _onto_axis(pose: Floats, passage: NarrowPassage) -> float:
    """Heading to the point of the passage's axis ahead of the chair, rad."""
    cos, sin = math.cos(passage.axis), math.sin(passage.axis)
    dx, dy = pose[0] - passage.x, pose[1] - passage.y
    before, beside = -(cos * dx + sin * dy), -sin * dx + cos * dy
    ahead = max(_LOOKAHEAD * before, _NEAREST)
    return passage.axis + math.atan2(-beside, ahead)
