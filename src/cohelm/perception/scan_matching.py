"""Where a reading was taken, from what it shows of surroundings that were seen before.

Points of faces are moved onto the line of the nearest face (Censi, An ICP variant using a
point-to-line metric, ICRA 2008), slim things onto slim things, with weights that give up what does
not fit: people who walk are outvoted by what stands. A direction of which the surroundings say
nothing, as along a corridor, is left as it was guessed (Zhang et al., ICRA 2016).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.geometry import wrap_angle
from cohelm.perception.outlines import Outline

CELL = 0.25
"""Side of the cells in which neighbours are looked for, m."""
CAP = 9.0
"""Squared misfit of a point, in standard deviations, beyond which it counts as not matched."""
_ALIKE = 0.8
"""Least cosine between the normals of what may be the same face."""
_PASSES = ((0.5, 0.2, 6), (0.25, 0.08, 8), (0.15, 0.04, 12))
"""From coarse to fine: how far a neighbour may be, the misfit that counts a quarter, m, and how
often."""
_CLOSE = 1e-5
"""Steps shorter than this end a pass, m and rad."""
_TOLD = (4.0, 0.012)
"""Points, and share of the points, that must speak of a direction."""


@value
class Reference:
    """Surroundings to compare with, sorted into cells; k points in c cells."""

    outline: Outline
    """In the order of the cells."""
    origin: Annotated[Floats, Shape("2")]
    """Corner of the first cell, m."""
    columns: int
    first: Annotated[Integers, Shape("c+1")]
    """Where the points of each cell begin."""


@value
class Match:
    """How a reading fits the surroundings."""

    pose: Annotated[Floats, Shape("3")]
    """Of the reading, in the frame of the reference."""
    overlap: float
    """Share of its points that lie on what was seen before, 0…1."""
    misfit: float
    """Mean over its points of their squared distances in standard deviations, at most ``CAP``."""
    told: int
    """Directions of which the surroundings say something: 2, along a smooth corridor 1."""


def reference_of(outline: Outline) -> Reference:
    """Sort an outline into cells."""
    return sorted_reference(outline)[0]


def sorted_reference(outline: Outline) -> tuple[Reference, Integers]:
    """The same, and the order (k,) in which it has the points."""
    points = outline.points
    low = points.min(axis=0) if len(points) else np.zeros(2)
    cell = np.floor((points - low) / CELL).astype(np.int64).reshape(-1, 2)
    columns = int(cell[:, 0].max(initial=0)) + 1
    rows = int(cell[:, 1].max(initial=0)) + 1
    index = cell[:, 1] * columns + cell[:, 0]
    order = np.argsort(index, kind="stable")
    first = np.searchsorted(index[order], np.arange(rows * columns + 1))
    placed = Outline(points=points[order], normals=outline.normals[order])
    return Reference(outline=placed, origin=low, columns=columns, first=first), order


def nearby(reference: Reference, outline: Outline, distance: float) -> Booleans:
    """Which points (k,) of an outline in the reference's frame have one like them that near, m."""
    if not len(reference.outline):
        return np.zeros(len(outline), dtype=np.bool_)
    return _nearby(_cells(reference), _rows(outline), distance)


def match(reference: Reference, outline: Outline, guess: Floats, noise: float) -> Match:
    """The pose near ``guess`` (3,) at which an outline fits a reference best.

    Args:
        reference: what was seen before.
        outline: of the reading, in the robot's frame.
        guess: where it may have been taken.
        noise: standard deviation of the misfit of what is the same, m.
    """
    if not len(outline) or not len(reference.outline):
        return Match(pose=guess, overlap=0.0, misfit=CAP, told=0)
    pose, told = _align(_cells(reference), _rows(outline), guess)
    return _judged(reference, outline, pose, int(told), noise)


def fit_at(reference: Reference, outline: Outline, pose: Floats, noise: float) -> Match:
    """How an outline fits where it is said to have been taken."""
    return _judged(reference, outline, pose, 2, noise)


class Cells(NamedTuple):
    """A reference for compiled code."""

    known: Floats
    """(k, 4): places and normals."""
    origin: Floats
    columns: int
    first: Integers


def _cells(reference: Reference) -> Cells:
    known = _rows(reference.outline)
    return Cells(known, reference.origin, reference.columns, reference.first)


def _rows(outline: Outline) -> Floats:
    return np.hstack([outline.points, outline.normals])


def _judged(reference: Reference, outline: Outline, pose: Floats, told: int, noise: float) -> Match:
    if not len(outline) or not len(reference.outline):
        return Match(pose=pose, overlap=0.0, misfit=CAP, told=0)
    squared = _misfits(_cells(reference), _rows(outline), pose, noise)
    pose = np.array([pose[0], pose[1], float(wrap_angle(pose[2]))])
    return Match(
        pose=pose, overlap=float(np.mean(squared < CAP)), misfit=float(squared.mean()), told=told
    )


@njit(cache=True)
def _nearest(
    cells: Cells,
    place: Floats,
    radius: float,
) -> int:
    """The nearest point of the same kind within a radius of (x, y, n_x, n_y), or −1."""
    known, origin, columns, first = cells
    x, y, nx, ny = place[0], place[1], place[2], place[3]
    slim = nx == 0.0 and ny == 0.0
    rows = (first.shape[0] - 1) // columns
    best, found = radius * radius, -1
    r0 = max(math.floor((y - radius - origin[1]) / CELL), 0)
    r1 = min(math.floor((y + radius - origin[1]) / CELL), rows - 1)
    c0 = max(math.floor((x - radius - origin[0]) / CELL), 0)
    c1 = min(math.floor((x + radius - origin[0]) / CELL), columns - 1)
    if c1 < c0:
        return -1
    for r in range(r0, r1 + 1):
        for j in range(first[r * columns + c0], first[r * columns + c1 + 1]):
            dx, dy = known[j, 0] - x, known[j, 1] - y
            squared = dx * dx + dy * dy
            if squared >= best:
                continue
            mx, my = known[j, 2], known[j, 3]
            if slim:
                if mx != 0.0 or my != 0.0:
                    continue
            elif nx * mx + ny * my < _ALIKE:
                continue
            best, found = squared, j
    return found


@njit(cache=True)
def _align(  # long, for all of it is one loop over points
    cells: Cells,
    seen: Floats,
    guess: Floats,
) -> tuple[Floats, int]:
    """(pose (3,), directions told) by reweighted least squares, Geman and McClure's weights."""
    known, pose = cells.known, guess.copy()
    k = seen.shape[0]
    place = np.empty(4)
    told = 0
    for radius, scale, most in _PASSES:
        for _ in range(most):
            c, s = math.cos(pose[2]), math.sin(pose[2])
            H, g = np.zeros((3, 3)), np.zeros(3)
            for i in range(k):
                rx, ry = c * seen[i, 0] - s * seen[i, 1], s * seen[i, 0] + c * seen[i, 1]
                place[0], place[1] = pose[0] + rx, pose[1] + ry
                place[2] = c * seen[i, 2] - s * seen[i, 3]
                place[3] = s * seen[i, 2] + c * seen[i, 3]
                j = _nearest(cells, place, radius)
                if j < 0:
                    continue
                dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
                nx, ny = known[j, 2], known[j, 3]
                slim = nx == 0.0 and ny == 0.0
                error = dx * dx + dy * dy if slim else (nx * dx + ny * dy) ** 2
                weight = 1.0 / (1.0 + error / (scale * scale)) ** 2
                for axis in range(2 if slim else 1):
                    if slim:
                        nx, ny = 1.0 - axis, 1.0 * axis
                    across = -nx * ry + ny * rx
                    e = nx * dx + ny * dy
                    H[0, 0] += weight * nx * nx
                    H[0, 1] += weight * nx * ny
                    H[1, 1] += weight * ny * ny
                    H[0, 2] += weight * nx * across
                    H[1, 2] += weight * ny * across
                    H[2, 2] += weight * across * across
                    g[0] += weight * nx * e
                    g[1] += weight * ny * e
                    g[2] += weight * across * e
            told = _hold(H, g, pose, guess, max(_TOLD[0], _TOLD[1] * k))
            H[1, 0], H[2, 0], H[2, 1] = H[0, 1], H[0, 2], H[1, 2]
            if H[2, 2] < 1e-3:
                return pose, 0
            step = -np.linalg.solve(H + 1e-6 * np.eye(3), g)
            pose += step
            if np.abs(step).max() < _CLOSE:
                break
    return pose, told


@njit(cache=True)
def _hold(H: Floats, g: Floats, pose: Floats, guess: Floats, least: float) -> int:
    """Tie directions of which too little is said to the guess; returns how many are free."""
    half = math.hypot(0.5 * (H[0, 0] - H[1, 1]), H[0, 1])
    middle = 0.5 * (H[0, 0] + H[1, 1])
    along = 0.5 * math.atan2(2.0 * H[0, 1], H[0, 0] - H[1, 1])
    told = 2
    for large in range(2):
        eigenvalue = middle + half if large else middle - half
        if eigenvalue >= least:
            continue
        told -= 1
        angle = along if large else along + 0.5 * math.pi
        vx, vy = math.cos(angle), math.sin(angle)
        stiff = 1e4
        off = vx * (pose[0] - guess[0]) + vy * (pose[1] - guess[1])
        H[0, 0] += stiff * vx * vx
        H[0, 1] += stiff * vx * vy
        H[1, 1] += stiff * vy * vy
        g[0] += stiff * vx * off
        g[1] += stiff * vy * off
    return told


@njit(cache=True)
def _misfits(
    cells: Cells,
    seen: Floats,
    pose: Floats,
    noise: float,
) -> Floats:
    """(k,) squared distances to the nearest face or slim thing, in ``noise``, at most ``CAP``."""
    known, out = cells.known, np.full(seen.shape[0], CAP)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    place = np.empty(4)
    for i in range(seen.shape[0]):
        place[0] = pose[0] + c * seen[i, 0] - s * seen[i, 1]
        place[1] = pose[1] + s * seen[i, 0] + c * seen[i, 1]
        place[2] = c * seen[i, 2] - s * seen[i, 3]
        place[3] = s * seen[i, 2] + c * seen[i, 3]
        j = _nearest(cells, place, 0.25)
        if j < 0:
            continue
        dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
        nx, ny = known[j, 2], known[j, 3]
        slim = nx == 0.0 and ny == 0.0
        squared = dx * dx + dy * dy if slim else (nx * dx + ny * dy) ** 2
        out[i] = min(squared / (noise * noise), CAP)
    return out


@njit(cache=True)
def _nearby(
    cells: Cells,
    seen: Floats,
    distance: float,
) -> Booleans:
    out = np.empty(seen.shape[0], dtype=np.bool_)
    place = np.empty(4)
    for i in range(seen.shape[0]):
        place[:] = seen[i]
        out[i] = _nearest(cells, place, distance) >= 0
    return out
