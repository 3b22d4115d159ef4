"""Semi-open office scenes, as the global experiment of Xu et al. describes them.

A room with something large in its middle, the left of it open and the right of it cluttered; a
rider who wants to pass on the left, and a click that says so, none too exactly. Everything is drawn
from a seed before any planner runs; docs/adr/0013 says how and why.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.interpolate import CubicSpline

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import arc_length, resample
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.maps.drawing import Canvas, polygon_of_disc, polygon_of_rect, turned
from cohelm.robots import Robot
from cohelm.simulation import generator

RESOLUTION, WALL = 0.05, 0.10
"""Of the map, and the thickness of the walls around, m."""
WIDTH, DEPTH = (10.0, 12.0), (12.5, 14.0)
"""Ranges of the room's sides, m."""
ENDS = 1.2
"""Start and goal from the near and the far wall, m."""
BLOCK = ((2.2, 3.2), (2.5, 4.0))
"""Ranges of the central block's width and depth, m."""
BLOCK_OFFSET = (-0.9, -0.1)
"""Of the block's centre from the middle between start and goal, m: both ways are of similar length,
and the right one is never the longer, or nothing would tempt a planner there."""
ITEMS, GAP = (6, 11), 1.0
"""How many pieces of clutter are tried for, and the least gap between any two, or to a wall, m."""
BESIDE = (0.8, 1.6)
"""How far from the block's side the rider likes to pass, m."""
CLICK_DEVIATION = 0.3
"""Of the rider's click from the point that is meant, m, in either direction."""
_TRIES = 400


@value
class OfficeScene:
    """One room, one wish."""

    seed: int
    grid: OccupancyGrid
    start: Annotated[Floats, Shape("2")]
    goal: Annotated[Floats, Shape("2")]
    desired: Annotated[Floats, Shape("k 2")]
    """The way that the rider would go, from start to goal, m."""
    click: Annotated[Floats, Shape("2")]
    """All that a planner learns of it: its middle, as the rider pointed at it, m."""


def office(seed: int, robot: Robot) -> OfficeScene:
    """The scene of a seed; the robot only says how much room the desired way must have.

    A room in which the desired way has no room for the robot in every heading is drawn again.
    """
    rng = generator(seed, "office")
    while True:
        grid, start, goal, block = _room(rng)
        desired = _desired(rng, start, goal, block)
        if _room_along(grid, desired) >= robot.circumscribed_radius:
            break
    along = arc_length(desired)
    middle = np.array([np.interp(0.5 * along[-1], along, axis) for axis in desired.T])
    click = middle + generator(seed, "click").normal(scale=CLICK_DEVIATION, size=2)
    return OfficeScene(seed=seed, grid=grid, start=start, goal=goal, desired=desired, click=click)


def _room(rng: np.random.Generator) -> tuple[OccupancyGrid, Floats, Floats, Floats]:
    """(grid, start, goal, corners (4, 2) of the central block), y from start to goal."""
    width, depth = rng.uniform(*WIDTH), rng.uniform(*DEPTH)
    start = np.array([width / 2.0 + rng.uniform(-0.5, 0.5), ENDS])
    goal = np.array([width / 2.0 + rng.uniform(-0.5, 0.5), depth - ENDS])
    canvas = Canvas(size=(width, depth), resolution=RESOLUTION, outside="occupied")
    canvas.floor(polygon_of_rect([WALL, WALL, width - WALL, depth - WALL]), 0.0)
    centre = (start + goal) / 2.0 + [rng.uniform(*BLOCK_OFFSET), rng.uniform(-0.5, 0.5)]
    block = _box(centre, rng.uniform(*BLOCK[0]), rng.uniform(*BLOCK[1]), 0.0)
    canvas.block(block)
    _clutter(rng, canvas, (float(block[:, 0].max()), width, depth), np.stack([start, goal]))
    return canvas.grid(), start, goal, block


def _clutter(
    rng: np.random.Generator, canvas: Canvas, zone: tuple[float, float, float], keep: Floats
) -> None:
    """Desks and chairs on the right, (x from, width and depth of the room), m; off ``keep``."""
    left, width, depth = zone
    wanted, clearance = int(rng.integers(*ITEMS)), canvas.clearance()
    for _ in range(_TRIES):
        centre = np.array([rng.uniform(left, width), rng.uniform(2.0, depth - 2.0)])
        item = _item(rng, centre)
        outline = resample(np.vstack([item, item[:1]]), RESOLUTION)
        cells = np.floor(outline / RESOLUTION).astype(int)
        inside = ((cells >= 0) & (cells < np.array(clearance.shape)[::-1])).all()
        off = np.hypot(*(outline[:, None] - keep).T).min() >= ENDS
        if inside and off and clearance[cells[:, 1], cells[:, 0]].min() >= GAP:
            canvas.block(item)
            clearance = canvas.clearance()
            wanted -= 1
        if wanted == 0:
            return


def _item(rng: np.random.Generator, centre: Floats) -> Floats:
    """Corners (k, 2) of a desk, more or less along the walls, or of something round."""
    if rng.random() < 0.6:
        angle = 0.5 * math.pi * rng.integers(2) + math.radians(rng.uniform(-15.0, 15.0))
        return _box(centre, rng.uniform(1.0, 1.6), rng.uniform(0.6, 0.8), angle)
    return polygon_of_disc([*centre, rng.uniform(0.2, 0.4)])


def _box(centre: Floats, width: float, depth: float, angle: float) -> Floats:
    half = np.array([width, depth]) / 2.0
    return turned(polygon_of_rect([*(centre - half), *(centre + half)]), angle)


def _desired(rng: np.random.Generator, start: Floats, goal: Floats, block: Floats) -> Floats:
    """The least bent curve (k, 2) from start to goal that passes left of the block.

    It passes abreast of the block's middle, as far from its side as this rider likes. The least
    bent curve through three points is the natural cubic spline.
    """
    abreast = np.array([block[:, 0].min() - rng.uniform(*BESIDE), block[:, 1].mean()])
    knots = np.stack([start, abreast, goal])
    spline = CubicSpline(arc_length(knots), knots, bc_type="natural")
    dense: Floats = spline(np.linspace(0.0, spline.x[-1], 400))
    return resample(dense, RESOLUTION)


def _room_along(grid: OccupancyGrid, line: Floats) -> float:
    """Least distance of a line (k, 2) from what stands there, m; −∞ where it leaves the map."""
    if not grid.contains(line).all():
        return -math.inf
    return float(distance_field(grid).at(line).min())
