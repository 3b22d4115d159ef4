"""Where a map is like a scene's own floor: how much room there is along the same lines.

A scene is known by its lines: the chair's route and the people's ways. At every 0.25 m of them its
own floor has so much room to the nearest wall, and that is what a place on another map is compared
by; beyond 1.5 m room is room. So an open scene is laid in the open, and one with a door where a
wall has an opening of about that width.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.maps import DistanceField, OccupancyGrid, distance_field
from cohelm.maps.distance import sample

SPACING = 0.25
"""Between the points at which the room is compared, m."""
OPEN = 1.5
"""Room beyond which more of it makes no difference, m."""
NARROW, LOOSE = 1.0, 0.25
"""Where the scene's own floor has less room than the first, another place has no more than the
second beyond that, m: a narrow place is to be narrow."""
LATTICE, HEADINGS = 0.3, 24
"""Between the places that are looked at first, m, and in how many headings."""
KEPT = 60
"""Of those, so many are looked at closely, each 1 m or a quarter turn away from the others."""
_WITHIN = 0.02
"""Lack of room, or too much of it where it is narrow, that is let pass, root mean square, m."""
_STEPS = ((0.15, 0.12), (0.08, 0.06), (0.04, 0.03), (0.02, 0.015), (0.01, 0.008))
"""By how much a close look moves and turns, m and rad."""
_TIGHT = 30.0
"""How much more that counts than a difference."""


@value
class Lines:
    """The points (m,) of a scene at which room is compared, in a frame about its middle."""

    point: Annotated[Floats, Shape("m 2")]
    need: Annotated[Floats, Shape("m")]
    """Room that there must be, m."""
    room: Annotated[Floats, Shape("m")]
    """Room that the scene's own floor has, at most ``OPEN``, m."""


@value
class Place:
    """Where the scene's middle comes to lie."""

    pose: Annotated[Floats, Shape("3")]
    difference: float
    """Root mean square of the room there less that of the scene's own floor, m."""


def places_like(lines: Lines, grid: OccupancyGrid) -> list[Place]:
    """Where on a map the lines have room, the most alike first; the same for the same arguments."""
    field = distance_field(grid)
    anchors = _anchors(field, grid, lines)
    if not len(anchors):
        return []
    turns = np.linspace(0.0, 2.0 * math.pi, HEADINGS, endpoint=False, dtype=np.float64)
    frame = np.array([field.resolution, *field.X_MG, *grid.bounds])
    marks = np.column_stack([lines.point, lines.need, lines.room])
    rough = _rough(field.distance, frame, anchors, turns, marks)
    found = []
    for first in _distinct(rough, anchors, turns):
        pose = _closely(field.distance, frame, first, marks, np.array(_STEPS))
        away, lack = _unlike(field.distance, frame, pose, marks, np.inf)
        if lack <= _WITHIN**2:
            found.append(Place(pose=pose, difference=math.sqrt(away)))
    return sorted(found, key=lambda place: place.difference)


def _anchors(field: DistanceField, grid: OccupancyGrid, lines: Lines) -> Floats:
    """Points (a, 2) of a lattice over the map where the scene's middle has the room it needs."""
    x0, y0, x1, y1 = grid.bounds
    x, y = np.meshgrid(np.arange(x0, x1, LATTICE), np.arange(y0, y1, LATTICE))
    points = np.column_stack([x.ravel(), y.ravel()])
    middle = int(np.argmin(np.hypot(*lines.point.T)))
    slack = 0.75 * LATTICE  # a point of the lattice lies so near to where it should
    enough = field.at(points) > lines.need[middle] - slack
    inside: Floats = points[enough & grid.contains(points)]
    return inside


def _distinct(rough: Floats, anchors: Floats, turns: Floats) -> list[Floats]:
    """The poses (3,) that are least unlike, none near a better one."""
    kept: list[Floats] = []
    for at in np.argsort(rough, axis=None, kind="stable"):
        i, j = np.unravel_index(at, rough.shape)
        if not np.isfinite(rough[i, j]) or len(kept) == KEPT:
            break
        pose = np.array([*anchors[i], turns[j]])
        if not any(_near(pose, other) for other in kept):
            kept.append(pose)
    return kept


def _near(pose: Floats, other: Floats) -> bool:
    turn = abs(float(wrap_angle(pose[2] - other[2])))
    return math.dist(pose[:2], other[:2]) < 1.0 and turn < 0.25 * math.pi


@njit(cache=True)
def _rough(distance: Floats32, frame: Floats, anchors: Floats, turns: Floats, m: Floats) -> Floats:
    """How unlike every anchor is in every heading, (a, h); +inf where hopelessly so."""
    out = np.empty((anchors.shape[0], turns.shape[0]))
    pose = np.empty(3)
    for i in range(anchors.shape[0]):
        for j in range(turns.shape[0]):
            pose[:2], pose[2] = anchors[i], turns[j]
            away, lack = _unlike(distance, frame, pose, m, 1.0)
            out[i, j] = away + _TIGHT * lack if away < np.inf else np.inf
    return out


@njit(cache=True)
def _closely(distance: Floats32, frame: Floats, pose: Floats, m: Floats, steps: Floats) -> Floats:
    """The pose (3,) to which small moves and turns lead from one, each for the better."""
    best = pose.copy()
    away, lack = _unlike(distance, frame, best, m, np.inf)
    least = away + _TIGHT * lack
    for k in range(steps.shape[0]):
        for _ in range(12):
            better = False
            for axis in range(3):
                for side in (-1.0, 1.0):
                    other = best.copy()
                    other[axis] += side * (steps[k, 1] if axis == 2 else steps[k, 0])
                    away, lack = _unlike(distance, frame, other, m, np.inf)
                    if away + _TIGHT * lack < least - 1e-12:
                        least, best, better = away + _TIGHT * lack, other, True
            if not better:
                break
    return best


@njit(cache=True)
def _unlike(
    distance: Floats32, frame: Floats, pose: Floats, m: Floats, most: float
) -> tuple[float, float]:
    """How a place differs: (mean square difference of room, mean square of a fault of it), m².

    A fault is a lack of room, or too much of it where the scene is narrow. (+inf, +inf) past
    ``most``.

    Args:
        distance: (rows, cols), m.
        frame: (8,): the cells' side, the field's pose, x_min, y_min, x_max, y_max of the map, m;
            outside of it there is no room at all.
        pose: (3,) of the scene's middle.
        m: (k, 4): x, y, room needed, room at home, m.
        most: of the mean square difference, m².
    """
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    count = m.shape[0]
    away, lack = 0.0, 0.0
    for k in range(count):
        x = pose[0] + cos * m[k, 0] - sin * m[k, 1]
        y = pose[1] + sin * m[k, 0] + cos * m[k, 1]
        there = -OPEN
        if frame[4] <= x <= frame[6] and frame[5] <= y <= frame[7]:
            there = sample(distance, frame[0], frame[1:4], x, y)[0]
        there = min(max(there, -OPEN), OPEN)
        away += (there - m[k, 3]) ** 2
        lack += max(m[k, 2] - there, 0.0) ** 2
        if m[k, 3] < NARROW:
            lack += max(there - m[k, 3] - LOOSE, 0.0) ** 2
        if away > most * count:
            return np.inf, np.inf
    return away / count, lack / count
