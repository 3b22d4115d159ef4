"""Building of the twin: an occupancy grid extruded into few boxes, and a floor with its relief."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.simulation import FloorRelief, WorldSetup
from cohelm.simulation.sensors.floor_relief import FloorSurface
from cohelm.simulation.split_knowledge import grid_views

SEEN, PEOPLE, CEILING, GLASS = 0, 1, 3, 4
"""Groups of bodies: sensors see the first three; films leave out the ceiling."""
_DEPTH = 0.5
"""Depth of floors and walls below the lowest floor, m: bodies cannot get under them."""
_WALL = (0.82, 0.80, 0.76, 1.0)
_LOW = (0.62, 0.52, 0.42, 1.0)
_PANE = (0.55, 0.75, 0.85, 0.35)
_GROUND = (0.72, 0.74, 0.76, 1.0)
_EDGE = (0.45, 0.42, 0.38, 1.0)


@value
class Blocks:
    """Obstacles as k boxes, which are rectangles of cells of equal height."""

    low: Annotated[Floats, Shape("k 2")]
    """Lower left corner in the grid's frame, m."""
    high: Annotated[Floats, Shape("k 2")]
    """Upper right corner in the grid's frame, m."""
    height: Annotated[Floats, Shape("k")]
    """Over the floor, m."""
    sensed: Annotated[Integers, Shape("k")]
    """1 where sensors see it, 0 for glass."""


def blocks_of(setup: WorldSetup, grid: OccupancyGrid) -> Blocks:
    """Merge the occupied cells of a grid to rectangles, cell by cell the same area.

    Args:
        setup: heights of the cells, and which of them no sensor detects.
        grid: true obstacles now.
    """
    occupied = grid.occupied()
    heights = np.full(grid.shape, setup.wall_height)
    if setup.heights is not None:
        heights = np.where(np.isnan(setup.heights), setup.wall_height, setup.heights)
    sensed = grid_views(grid, setup.split).sensed.occupied()
    levels, level = np.unique(heights[occupied], return_inverse=True)
    label = np.zeros(grid.shape, dtype=np.int64)
    label[occupied] = 1 + 2 * level + sensed[occupied]
    rows = np.array([*_rectangles(label)], dtype=np.int64).reshape(-1, 5)
    kind = rows[:, 4] - 1
    return Blocks(
        low=np.asarray(rows[:, [1, 0]] * grid.resolution, dtype=np.float64),
        high=np.asarray(rows[:, [3, 2]] * grid.resolution, dtype=np.float64),
        height=levels[kind // 2].reshape(-1).astype(float),
        sensed=kind % 2,
    )


def add_building(spec: Any, mujoco: Any, setup: WorldSetup, grid: OccupancyGrid) -> None:
    """Add floor, obstacles and ceiling to a model.

    Args:
        spec: ``mujoco.MjSpec`` to extend.
        mujoco: the module.
        setup: world.
        grid: true obstacles now.
    """
    relief = setup.relief
    _add_floor(spec, mujoco, relief, grid)
    blocks, X_MG = blocks_of(setup, grid), grid.X_MG
    middle = transform(X_MG, (blocks.low + blocks.high) / 2.0).reshape(-1, 2)
    bottom = _lowest(relief) - _DEPTH
    top = relief.heights(middle) + blocks.height
    half = (blocks.high - blocks.low) / 2.0
    for k in range(len(middle)):
        low = blocks.height[k] < setup.wall_height
        _add_box(
            spec,
            mujoco,
            (middle[k], half[k], float(X_MG[2])),
            (bottom, float(top[k])),
            group=SEEN if blocks.sensed[k] else GLASS,
            rgba=_PANE if not blocks.sensed[k] else _LOW if low else _WALL,
            friction=0.4,
        )
    if math.isfinite(setup.ceiling):
        spec.worldbody.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            pos=[0.0, 0.0, setup.ceiling + max(relief.floor.highest, 0.0)],
            quat=[0.0, 1.0, 0.0, 0.0],
            contype=0,
            conaffinity=0,
            group=CEILING,
        )


def _add_floor(spec: Any, mujoco: Any, relief: FloorRelief, grid: OccupancyGrid) -> None:
    """A plane, or level floor, ramp and level floor as three boxes; and what lies elsewhere.

    With a pit the plane lies at its bottom, and boxes stand on it wherever no piece of floor lies.
    """
    floor, lowest = relief.floor, _lowest(relief)
    if floor.gradient == 0.0:
        spec.worldbody.add_geom(
            name="floor",
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[0.0, 0.0, 1.0],
            pos=[0.0, 0.0, lowest],
            contype=3,
            conaffinity=3,
            friction=[0.1, 0.0, 0.0],
            group=SEEN,
            rgba=_GROUND,
        )
    else:
        for k, (run, heights) in enumerate(_pieces(floor, grid)):
            u = np.array([math.cos(floor.direction), math.sin(floor.direction)])
            size = np.array([run[1] - run[0], 200.0])
            area = (floor.at + u * (run[0] + run[1]) / 2.0, size, floor.direction)
            _add_slab(spec, mujoco, area, heights, f"floor_{k}", _GROUND)
    if lowest < 0.0 and floor.gradient == 0.0:
        _add_level_floor(spec, mujoco, relief, grid, lowest)
    for k, piece in enumerate(relief.pieces):
        height = float(floor.height(piece.at))
        for j, (centre, size, begin, end) in enumerate(piece.slabs):
            name = f"floor_edge_{k}_{j}"
            if begin == end:
                area = (centre, size / 2.0, piece.angle)
                span = (min(height, height + end) - _DEPTH, height + end)
                _add_box(spec, mujoco, area, span, group=SEEN, rgba=_EDGE, friction=0.1, name=name)
            else:
                ends = (height + begin, height + end)
                _add_slab(spec, mujoco, (centre, size, piece.angle), ends, name, _EDGE)


def _add_level_floor(
    spec: Any, mujoco: Any, relief: FloorRelief, grid: OccupancyGrid, lowest: float
) -> None:
    """Boxes from the lowest floor to height 0 under all cells on which no piece of floor lies."""
    rows, cols = np.meshgrid(*map(np.arange, grid.shape), indexing="ij")
    centres = grid.centres(np.stack([rows, cols], axis=-1))
    level = ~np.any([piece.covers(centres) for piece in relief.pieces], axis=0)
    for k, (row, col, end_row, end_col, _) in enumerate(_rectangles(level.astype(np.int64))):
        low = np.array([col, row]) * grid.resolution
        high = np.array([end_col, end_row]) * grid.resolution
        area = (transform(grid.X_MG, (low + high) / 2.0), (high - low) / 2.0, float(grid.X_MG[2]))
        name = f"floor_level_{k}"
        _add_box(
            spec,
            mujoco,
            area,
            (lowest - _DEPTH, 0.0),
            group=SEEN,
            rgba=_GROUND,
            friction=0.1,
            name=name,
        )


def _pieces(
    floor: FloorSurface, grid: OccupancyGrid
) -> Iterator[tuple[tuple[float, float], tuple[float, float]]]:
    """Run from and to, and the heights there, of the parts of a floor with a ramp, m."""
    reach = _reach(floor, grid)
    end = min(floor.length, reach)
    rise = floor.gradient * end
    yield (-reach, 0.0), (0.0, 0.0)
    yield (0.0, end), (0.0, rise)
    if end < reach:
        yield (end, reach), (rise, rise)


def _reach(floor: FloorSurface, grid: OccupancyGrid) -> float:
    """Distance from the ramp's beginning to the farthest corner of the map, m."""
    x0, y0, x1, y1 = grid.bounds
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return float(np.hypot(*(corners - floor.at).T).max()) + 5.0


def _lowest(relief: FloorRelief) -> float:
    floor = relief.floor
    rise = floor.gradient * floor.length if math.isfinite(floor.length) else 0.0
    ends = [height for piece in relief.pieces for slab in piece.slabs for height in slab[2:]]
    return min(rise, 0.0, *ends)


def _add_slab(
    spec: Any,
    mujoco: Any,
    area: tuple[Floats, Floats, float],
    heights: tuple[float, float],
    name: str,
    rgba: tuple[float, ...],
) -> None:
    """Box whose top passes through two heights, at both ends of an area's first side.

    Args:
        spec: to extend.
        mujoco: the module.
        area: centre (2,), size (2,), m, and direction of the first side, rad.
        heights: at its ends, m.
        name: of the box.
        rgba: its colour.
    """
    middle, size, direction = area
    rise, length = heights[1] - heights[0], float(size[0])
    pitch = -math.atan2(rise, length)
    half = [math.hypot(rise, length) / 2.0, size[1] / 2.0, _DEPTH]
    u = np.array([math.cos(direction), math.sin(direction)])
    normal = np.array([*(math.sin(pitch) * u), math.cos(pitch)])
    centre = np.array([*middle, (heights[0] + heights[1]) / 2.0]) - _DEPTH * normal
    yaw = direction / 2.0
    about_z = np.array([math.cos(yaw), 0.0, 0.0, math.sin(yaw)])
    about_y = np.array([math.cos(pitch / 2.0), 0.0, math.sin(pitch / 2.0), 0.0])
    quat = np.zeros(4)
    mujoco.mju_mulQuat(quat, about_z, about_y)
    spec.worldbody.add_geom(
        name=name,
        type=mujoco.mjtGeom.mjGEOM_BOX,
        size=half,
        pos=centre,
        quat=quat,
        contype=3,
        conaffinity=3,
        friction=[0.1, 0.0, 0.0],
        group=SEEN,
        rgba=rgba,
    )


def _add_box(
    spec: Any,
    mujoco: Any,
    area: tuple[Floats, Floats, float],
    z: tuple[float, float],
    *,
    group: int,
    rgba: tuple[float, ...],
    friction: float,
    name: str = "",
) -> None:
    """Box over an area: centre (2,), half sides (2,) and yaw; from and to a height."""
    (x, y), half, yaw = area
    named = {"name": name} if name else {}
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_BOX,
        pos=[x, y, (z[0] + z[1]) / 2.0],
        size=[half[0], half[1], (z[1] - z[0]) / 2.0],
        quat=[math.cos(yaw / 2.0), 0.0, 0.0, math.sin(yaw / 2.0)],
        contype=3,
        conaffinity=3,
        friction=[friction, 0.0, 0.0],
        group=group,
        rgba=rgba,
        **named,
    )


def _rectangles(label: Integers) -> Iterator[tuple[int, int, int, int, int]]:
    """Rectangles (row, column, end row, end column, label) that tile the cells with label > 0.

    Equal runs of cells in consecutive rows become one rectangle.
    """
    rows = label.shape[0]
    open_runs: dict[tuple[int, int, int], int] = {}
    for r in range(rows + 1):
        runs = _runs(label[r]) if r < rows else set()
        for run in [each for each in open_runs if each not in runs]:
            yield open_runs.pop(run), run[0], r, run[1], run[2]
        for run in runs:
            open_runs.setdefault(run, r)


def _runs(row: Integers) -> set[tuple[int, int, int]]:
    """Runs (column, end column, label) of equal labels > 0 in one row."""
    change = np.flatnonzero(np.diff(row)) + 1
    start, end = np.append(0, change), np.append(change, len(row))
    return {(int(a), int(b), int(row[a])) for a, b in zip(start, end, strict=True) if row[a] > 0}
