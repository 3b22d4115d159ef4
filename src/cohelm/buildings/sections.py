"""Cells that solids cover between two heights: exact sections of triangle meshes along scanlines.

The plane y = const cuts a triangle in a segment, and the band of heights clips that segment; its
x-interval is the projection of the clipped triangle. Points deep inside a solid, whose surface lies
above and below the band, are those between the first and second, third and fourth … cut of a line
along x at one height with one connected surface. That needs no orientation of the triangles.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.maps import OccupancyGrid

FINENESS = 0.01
"""Maximum distance of scanlines, m."""
_FACE = 1e-3
"""Solids lose this at their faces, m: a wall beside a cell's border stays out of that cell."""
_Marks = tuple[Integers, Floats, Floats]
"""Rows, and their first and last columns to mark."""
_NO_MARKS: _Marks = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0)


@value
class Mesh:
    """Triangle mesh of one product; model frame, m."""

    vertices: Annotated[Floats, Shape("v 3")]
    faces: Annotated[Integers, Shape("f 3")]

    @property
    def triangles(self) -> Floats:
        """Corners (f, 3, 3), m."""
        corners: Floats = self.vertices[self.faces]
        return corners

    @property
    def bodies(self) -> Integers:
        """Number of the connected surface that each face belongs to (f,)."""
        count = len(self.vertices)
        ends = np.concatenate([self.faces[:, :2], self.faces[:, 1:]])
        edges = coo_array((np.ones(len(ends)), ends.T), shape=(count, count))
        label = connected_components(edges, directed=False)[1]
        return np.asarray(label[self.faces[:, 0]], dtype=np.int64)

    @property
    def bounds(self) -> Floats:
        """Lowest and highest corner (2, 3), m."""
        return np.array([self.vertices.min(axis=0), self.vertices.max(axis=0)])


def touched_cells(meshes: Iterable[Mesh], grid: OccupancyGrid, low: float, high: float) -> Booleans:
    """Cells (rows, cols) that solids touch between two heights, m.

    A part of at least 2 mm by ``FINENESS`` marks each cell that it reaches into. A surface without
    volume marks the cells below it.
    """
    z = low + 0.3173 * (high - low)  # no height at which models have edges
    lines = math.ceil(grid.resolution / FINENESS)
    thin = _FACE / grid.resolution
    out = np.zeros(grid.shape, dtype=np.bool_)
    # Scanlines along y cut the thin parts that those along x miss.
    views = ([0, 1, 2], out), ([1, 0, 2], out.T)
    marks: tuple[list[_Marks], ...] = ([_NO_MARKS], [_NO_MARKS])
    for mesh in meshes:
        heights = mesh.triangles[:, :, 2]
        near = (heights.max(axis=1) > low) & (heights.min(axis=1) < high)
        triangles, bodies = _in_cells(mesh.triangles[near], grid), mesh.bodies[near]
        surfaces, solid = [], False
        for (axes, target), found in zip(views, marks, strict=True):
            line, ends, which = _cuts(triangles[:, :, axes], lines, target.shape[0])
            surface, inside = _clipped(line, ends, low, high), _inside(line, ends, bodies[which], z)
            for rows, x in (surface, inside):
                first, last = np.floor(x[:, 0] + thin), np.floor(x[:, 1] - thin)
                found.append((rows // lines, first, last))
                solid |= bool(np.any(first <= last))
            surfaces.append(surface)
        if not solid:
            for (rows, x), found in zip(surfaces, marks, strict=True):
                found.append((rows // lines, np.floor(x[:, 0]), np.floor(x[:, 1])))
    for (_, target), found in zip(views, marks, strict=True):
        _mark(target, *(np.concatenate(part) for part in zip(*found, strict=True)))
    return out


def covered_cells(triangles: Floats, grid: OccupancyGrid) -> Booleans:
    """Cells (rows, cols) whose centres lie below triangles (t, 3, 3), m."""
    out = np.zeros(grid.shape, dtype=np.bool_)
    line, ends, _ = _cuts(_in_cells(triangles, grid), 1, grid.shape[0])
    rows, x = _clipped(line, ends, -np.inf, np.inf)
    _mark(out, rows, np.ceil(x[:, 0] - 0.5), np.floor(x[:, 1] - 0.5))
    return out


def upward(triangles: Floats) -> Booleans:
    """True (t,) for triangles (t, 3, 3) that are level, or slope by less than 25 %."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    level: Booleans = np.abs(normal[:, 2]) > 0.97 * np.linalg.norm(normal, axis=1)
    return level


def _in_cells(triangles: Floats, grid: OccupancyGrid) -> Floats:
    """Triangles (t, 3, 3) with x and y in cells from the corner of an upright grid."""
    corner = np.array([*grid.X_MG[:2], 0.0])
    out: Floats = (triangles - corner) / np.array([grid.resolution, grid.resolution, 1.0])
    return out


def _cuts(triangles: Floats, lines: int, rows: int) -> tuple[Integers, Floats, Integers]:
    """Segments in which scanlines cut triangles (t, 3, 3).

    Args:
        triangles: x and y in cells, z in m.
        lines: scanlines of each row of cells.
        rows: number of rows.

    Returns:
        Scanline of each segment (n,), its ends (n, 2, 2) as x in cells and z in m, its triangle
        (n,).
    """
    order = np.argsort(triangles[:, :, 1], axis=1)
    p = np.take_along_axis(triangles, order[:, :, None], axis=1)
    # Scanline y belongs to a triangle if y_min < y ≤ y_max, so that common edges count once.
    level = p[:, :, 1] * lines - 0.5
    first = np.maximum(np.floor(level[:, 0]) + 1, 0).astype(np.int64)
    last = np.minimum(np.floor(level[:, 2]), rows * lines - 1).astype(np.int64)
    count = np.maximum(last - first + 1, 0)
    which = np.repeat(np.arange(len(p)), count)
    start = np.repeat(np.cumsum(count) - count, count)
    line = np.arange(count.sum()) - start + first[which]
    y = (line + 0.5) / lines
    q = p[which]
    lower = (line <= level[which, 1])[:, None]
    a, b = np.where(lower, q[:, 0], q[:, 1]), np.where(lower, q[:, 1], q[:, 2])
    ends = np.stack([_at(q[:, 0], q[:, 2], y), _at(a, b, y)], axis=1)
    return line, ends, which


def _at(a: Floats, b: Floats, y: Floats) -> Floats:
    """Points (n, 2), as x and z, of the lines from a to b (n, 3) at y (n,)."""
    rise = b[:, 1] - a[:, 1]
    t = np.clip((y - a[:, 1]) / np.where(rise > 0.0, rise, 1.0), 0.0, 1.0)
    return (a + t[:, None] * (b - a))[:, ::2]


def _clipped(line: Integers, ends: Floats, low: float, high: float) -> tuple[Integers, Floats]:
    """Scanlines (m,) and x-intervals (m, 2) of the parts of segments (n, 2, 2) between heights."""
    z = ends[:, :, 1]
    part = (z.max(axis=1) > low) & (z.min(axis=1) < high)
    line, ends, z = line[part], ends[part], z[part]
    rise = z[:, 1] - z[:, 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        t = np.sort((np.array([[low, high]]) - z[:, :1]) / rise[:, None], axis=1)
    t = np.where((rise == 0.0)[:, None], [[0.0, 1.0]], np.clip(t, 0.0, 1.0))
    x = ends[:, :1, 0] + t * (ends[:, 1:, 0] - ends[:, :1, 0])
    return line, np.sort(x, axis=1)


def _inside(line: Integers, ends: Floats, body: Integers, z: float) -> tuple[Integers, Floats]:
    """Scanlines (m,) and x-intervals (m, 2) inside connected surfaces at height z."""
    above = ends[:, :, 1] > z
    cross = above[:, 0] != above[:, 1]
    line, ends, body = line[cross], ends[cross], body[cross]
    t = (z - ends[:, 0, 1]) / (ends[:, 1, 1] - ends[:, 0, 1])
    x = ends[:, 0, 0] + t * (ends[:, 1, 0] - ends[:, 0, 0])
    order = np.lexsort((x, line, body))
    line, x, body = line[order], x[order], body[order]
    # A surface with a hole has an odd number of cuts on some scanlines; it encloses nothing there.
    new = np.any(np.diff(np.stack([line, body]), axis=1, prepend=-1) != 0, axis=0)
    run = np.cumsum(new) - 1
    closed = (np.bincount(run, minlength=1) % 2 == 0)[run]
    line, pairs = line[closed][::2], x[closed].reshape(-1, 2)
    return line, pairs


def _mark(out: Booleans, rows: Integers, first: Floats, last: Floats) -> None:
    """Set columns ``first`` to ``last``, both included, of rows."""
    rows_all, cols = out.shape
    a = np.clip(first, 0, cols).astype(np.int64)
    b = np.clip(last + 1, 0, cols).astype(np.int64)
    some = (a < b) & (rows >= 0) & (rows < rows_all)
    delta = np.zeros((rows_all, cols + 1), dtype=np.int32)
    np.add.at(delta, (rows[some], a[some]), 1)
    np.add.at(delta, (rows[some], b[some]), -1)
    out |= np.cumsum(delta, axis=1)[:, :-1] > 0
