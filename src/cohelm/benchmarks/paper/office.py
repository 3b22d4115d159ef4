"""Semi-open office scenes, as the global experiment of Xu et al. describes them.

A room has a large block in its middle, open floor on the left and clutter on the right. The rider
prefers to pass on the left, although the path through the clutter is shorter, and states this by
an inexact click. Everything is drawn from a seed by geometry, independent of any planner;
docs/adr/0013 gives the reasons, and why these scenes replace earlier ones.
"""

from __future__ import annotations

import itertools
import math

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.geometry import arc_length, distance_to_polygon, resample
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.maps.drawing import Canvas, polygon_of_disc, polygon_of_rect, rotate
from cohelm.robots import Robot
from cohelm.simulation import generator

RESOLUTION, WALL = 0.05, 0.10
"""Resolution of the map, and thickness of the outer walls, m."""
WIDTH, DEPTH = (12.0, 14.0), (12.5, 14.0)
"""Ranges of the room's sides, m."""
ENDS = 1.2
"""Distance of start and goal from the near and the far wall, m."""
BLOCK = ((2.6, 3.8), (2.0, 3.5))
"""Ranges of the central block's width and depth, m."""
OFF_CENTRE = 0.5
"""Largest offset of the block from the room's middle, and of start and goal sideways, m."""
MARGIN = (1.0, 2.5)
"""Range of the length saved on the right, m: both are taut lines from start to goal around the
central block alone."""
LANE = (1.4, 2.2)
"""Range of a scene's lane, m: the minimum distance between any two obstacles."""
BESIDE = (0.8, 1.6)
"""Range of the rider's preferred distance from the block's side, m."""
CLICK_DEVIATION = 0.3
"""Standard deviation of the rider's click in either direction, m."""
_TRIES = 1000


@value
class OfficeScene:
    """Room, start and goal, and the path that the rider wants."""

    seed: int
    grid: OccupancyGrid
    start: Annotated[Floats, Shape("2")]
    goal: Annotated[Floats, Shape("2")]
    block: Annotated[Floats, Shape("4 2")]
    """Corners of the central block, m."""
    desired: Annotated[Floats, Shape("k 2")]
    """Path that the rider wants, from start to goal, m."""
    click: Annotated[Floats, Shape("2")]
    """Input of the planners: the middle of the desired path as the rider clicked it, m."""
    margin: float
    """Length saved on the right, as taut lines around the block, m."""
    lane: float
    """Minimum distance between any two obstacles, m."""


def office(seed: int, robot: Robot) -> OfficeScene:
    """Draw the scene of a seed; the robot only sets the clearance of the desired path.

    A room that cannot have the drawn margin, or whose desired path does not clear the robot in
    every heading, is drawn again.
    """
    rng = generator(seed, "office")
    margin, lane = rng.uniform(*MARGIN), rng.uniform(*LANE)
    while True:
        width, depth = rng.uniform(*WIDTH), rng.uniform(*DEPTH)
        block = _block(rng, width, depth)
        ends = _ends(rng, block, depth, margin)
        if ends is None:
            continue
        start, goal = ends
        desired = _desired(rng, start, goal, block)
        if min(distance_to_polygon(block, x, y) for x, y in desired) < robot.circumscribed_radius:
            continue
        grid = _room(rng, (width, depth), block, ends, lane)
        if _clearance_along(grid, desired) >= robot.circumscribed_radius:
            break
    along = arc_length(desired)
    middle = np.array([np.interp(0.5 * along[-1], along, axis) for axis in desired.T])
    click = middle + generator(seed, "click").normal(scale=CLICK_DEVIATION, size=2)
    return OfficeScene(
        seed=seed,
        grid=grid,
        start=start,
        goal=goal,
        block=block,
        desired=desired,
        click=click,
        margin=margin,
        lane=lane,
    )


def on_the_left(line: Floats, block: Floats) -> bool:
    """Check that a line (k, 2) from start to goal passes the block on its left."""
    x, y = block.mean(axis=0)
    abreast = int(np.argmax(line[:, 1] >= y))
    return bool(line[abreast, 0] < x)


def taut(start: Floats, goal: Floats, block: Floats, side: int) -> float:
    """Length of the taut line from start to goal past two corners of the block, m.

    Args:
        start, goal: (2,), below and above the block, neither beside it nor beyond its sides.
        block: (4, 2), an upright rectangle.
        side: −1: on its left, +1: on its right.
    """
    x = block[:, 0].min() if side < 0 else block[:, 0].max()
    low, high = block[:, 1].min(), block[:, 1].max()
    line = [tuple(start), (x, low), (x, high), tuple(goal)]
    return math.fsum(math.dist(a, b) for a, b in itertools.pairwise(line))


def _block(rng: np.random.Generator, width: float, depth: float) -> Floats:
    """The corners (4, 2) of the block about the middle of the room."""
    centre = np.array([width, depth]) / 2.0 + rng.uniform(-OFF_CENTRE, OFF_CENTRE, size=2)
    return _box(centre, rng.uniform(*BLOCK[0]), rng.uniform(*BLOCK[1]), 0.0)


def _ends(rng: np.random.Generator, block: Floats, depth: float, margin: float) -> Floats | None:
    """Start and goal (2, 2), so far right that the right side is shorter by the margin.

    None where one of them would not lie between the block's middle and its right side.
    """
    middle, right = float(block[:, 0].mean()), float(block[:, 0].max())
    aside = rng.uniform(-OFF_CENTRE, OFF_CENTRE, size=2)

    def ends(x: float) -> Floats:
        return np.column_stack([x + aside, [ENDS, depth - ENDS]])

    def excess(x: float) -> float:
        start, goal = ends(x)
        return taut(start, goal, block, -1) - taut(start, goal, block, 1) - margin

    if excess(middle) > 0.0 or excess(right) < 0.0:
        return None
    found = ends(float(brentq(excess, middle, right)))
    return found if middle <= found[:, 0].min() and found[:, 0].max() <= right else None


def _room(
    rng: np.random.Generator, size: tuple[float, float], block: Floats, keep: Floats, lane: float
) -> OccupancyGrid:
    """The room of a size (width, depth), m, with its block and clutter right of it, off ``keep``.

    Pieces are added as long as the lane is free around them; the distance to the walls may be
    smaller.
    """
    width, depth = size
    canvas = Canvas(size=size, resolution=RESOLUTION, outside="occupied")
    canvas.floor(polygon_of_rect([0.0, 0.0, width, depth]), 0.0)
    canvas.block(block)
    clearance = canvas.clearance()
    for _ in range(_TRIES):
        centre = np.array([rng.uniform(block[:, 0].max(), width), rng.uniform(0.0, depth)])
        item = _item(rng, centre)
        outline = resample(np.vstack([item, item[:1]]), RESOLUTION)
        cells = np.floor(outline / RESOLUTION).astype(int)
        inside = ((cells >= 0) & (cells < np.array(clearance.shape)[::-1])).all()
        off = np.hypot(*(outline[:, None] - keep).T).min() >= ENDS
        if inside and off and clearance[cells[:, 1], cells[:, 0]].min() >= lane:
            canvas.block(item)
            clearance = canvas.clearance()
    canvas.wall(polygon_of_rect([0.0, 0.0, width, depth]), 2.0 * WALL)
    return canvas.grid()


def _item(rng: np.random.Generator, centre: Floats) -> Floats:
    """Corners (k, 2) of a desk, roughly along the walls, or of a round obstacle."""
    if rng.random() < 0.6:
        angle = 0.5 * math.pi * rng.integers(2) + math.radians(rng.uniform(-15.0, 15.0))
        return _box(centre, rng.uniform(1.0, 1.6), rng.uniform(0.6, 0.8), angle)
    return polygon_of_disc([*centre, rng.uniform(0.2, 0.4)])


def _box(centre: Floats, width: float, depth: float, angle: float) -> Floats:
    half = np.array([width, depth]) / 2.0
    return rotate(polygon_of_rect([*(centre - half), *(centre + half)]), angle)


def _desired(rng: np.random.Generator, start: Floats, goal: Floats, block: Floats) -> Floats:
    """Curve (k, 2) of least bending from start to goal on the left of the block.

    It passes beside the block's middle at the rider's preferred distance. The curve of least
    bending through three points is the natural cubic spline.
    """
    abreast = np.array([block[:, 0].min() - rng.uniform(*BESIDE), block[:, 1].mean()])
    knots = np.stack([start, abreast, goal])
    spline = CubicSpline(arc_length(knots), knots, bc_type="natural")
    dense: Floats = spline(np.linspace(0.0, spline.x[-1], 400))
    return resample(dense, RESOLUTION)


def _clearance_along(grid: OccupancyGrid, line: Floats) -> float:
    """Minimum distance of a line (k, 2) from obstacles, m; −∞ where it leaves the map."""
    if not grid.contains(line).all():
        return -math.inf
    return float(distance_field(grid).at(line).min())
