"""Ground map: the height of the floor in cells about the chair, and the edges in it.

LiDARs and depth cameras see floor ahead that passes below them before the wheels reach it, so the
map remembers it. Each sweep is first fitted to what is known, by a height and two slopes: a chair
that pitches on its springs or drives onto a ramp sees the whole floor turn, and no step appears.

Edges down show in two ways: floor seen lower beside floor seen higher, and rays that pass below the
floor's level where the floor itself is hidden. Where nothing was seen nothing is claimed.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
from pydantic import Field
from scipy.ndimage import maximum_filter

from cohelm.arrays import (
    Annotated,
    Booleans,
    Bytes,
    Floats,
    Floats32,
    Integers,
    Shape,
    replace,
    value,
)
from cohelm.config import Model
from cohelm.geometry import compose, inverse, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, PointCloud
from cohelm.perception.ground.cells import (
    LOWER,
    UNSEEN,
    GroundCells,
    GroundRules,
    add_sweep,
    known_distance,
    stand_on,
)
from cohelm.perception.ground.kinds import update_kinds
from cohelm.perception.obstacles.obstacle_layer import (
    cells_a_side,
    shifted,
    window_corner,
    window_from_map,
)
from cohelm.perception.preprocessing.merged_cloud import has_pose, placed
from cohelm.robots import Robot

_LEAST_STEP = 0.025
"""Smaller steps are not told from noise, m; with the margin, those of a chair that takes 0.04."""
_FARTHEST = 2.5
"""Way ahead of the chair for which floor is looked for, m: more than it stops in."""
_BESIDE_EDGES = 8
"""Distance in cells from an edge within which the obstacle layer shows parts of it."""
_MOST_EDGES = 20_000
"""Maximum number of remembered cells; the oldest are dropped first."""


class GroundParameters(Model):
    """Parameters of the ground map; assumed."""

    side: float = Field(8.0, gt=1.0, le=100.0)
    """Side of the square window, m."""
    reach: float = Field(4.0, gt=0.5, le=50.0)
    """Distance from the chair up to which returns count, m."""
    margin: float = Field(0.015, ge=0.0, le=0.1)
    """A step down this much smaller than the chair may take counts as an edge: noise and cells, m;
    half of it for steps up."""
    tall: float = Field(0.25, gt=0.05, le=1.0)
    """Returns this high over the floor are objects, of which obstacle layer and people know, m."""
    top: float = Field(1.9, gt=0.3, le=5.0)
    """Higher returns count for nothing, m."""
    lasting: int = Field(15, ge=1, le=254)
    """Sweeps of the floor alone after which a high object is forgotten."""


DEFAULTS = GroundParameters()


@value
class FloorEdges:
    """Cells behind edges that a chair cannot take."""

    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) in the map's grid; also cells that left the window, the oldest first."""
    version: int
    """Increases whenever a cell changes."""


@value
class GroundMap:
    """Floor about the chair, in a rolling window on the cells of the map's grid.

    Heights are relative to the floor on which the chair began.
    """

    corner: Annotated[Integers, Shape("2")]
    """(row, column) of the window's first cell in the map's grid; may lie outside it."""
    height: Annotated[Floats32, Shape("rows cols")]
    """Of the floor, m; without meaning where ``seen`` is 0."""
    seen: Annotated[Bytes, Shape("rows cols")]
    """Sweeps with a return of the floor, at most 255."""
    bound: Annotated[Floats32, Shape("rows cols")]
    """Lowest ray that passed, m; without meaning where ``passed`` is 0."""
    passed: Annotated[Bytes, Shape("rows cols")]
    """Sweeps with rays that passed below the chair's floor, at most 255."""
    tall: Annotated[Bytes, Shape("rows cols")]
    """Sweeps of the floor for which a high object still counts."""
    kind: Annotated[Bytes, Shape("rows cols")]
    """``UNSEEN``, ``FLOOR``, ``OBJECT``, ``LOWER`` or ``HIGHER`` of ``ground.cells``."""
    tilt: Annotated[Floats, Shape("3")]
    """Height of the plane on which the chair stands below the map's at the chair, m, and its
    slopes along the axes of the map's grid."""
    place: Annotated[Floats, Shape("2")]
    """Of the chair at the last sweep, in the grid's frame, m."""
    edges: FloorEdges
    """Cells behind edges; the same object as long as nothing changes."""

    @property
    def level(self) -> float:
        """Height of the floor under the chair, m."""
        return -float(self.tilt[0])

    @property
    def cells(self) -> GroundCells:
        """Cells for the kernels."""
        return GroundCells(self.height, self.seen, self.bound, self.passed, self.tall, self.kind)


def update_ground(
    ground: GroundMap | None,
    clouds: tuple[PointCloud, ...],
    poses: Floats,
    grid: OccupancyGrid,
    robot: Robot,
    parameters: GroundParameters = DEFAULTS,
) -> GroundMap | None:
    """Add sweeps to the ground map.

    Args:
        ground: of the last step, None at first.
        clouds: new ones; one whose mount is not known is ignored.
        poses: (c, 3), of the robot at each of them, X_MR.
        grid: the map, whose cells the window uses.
        robot: limits of its steps and slopes.
        parameters: of the map.
    """
    p = parameters
    usable = [
        (cloud, pose)
        for cloud, pose in zip(clouds, poses, strict=True)
        if has_pose(cloud, pose) and math.isfinite(cloud.mount[2])
    ]
    if not usable:
        return ground
    pose = usable[-1][1]
    corner = window_corner(grid, pose[:2], p.side)
    known = ground or _empty(grid, robot, corner, pose, p)
    cells = _rolled(known, corner)
    rules = rules_of(robot, grid.resolution, p)
    return _with_sweeps(replace(known, corner=corner), cells, usable, grid, robot, rules)


def rules_of(robot: Robot, resolution: float, parameters: GroundParameters) -> GroundRules:
    """Limits of a robot, and sizes, for the kernels."""
    p = parameters
    (x0, y0), (x1, y1) = robot.outline.min(axis=0), robot.outline.max(axis=0)
    return GroundRules(
        down=max(robot.max_step_down - p.margin, _LEAST_STEP),
        # A bump is no fall.
        up=max(robot.max_step_up - 0.5 * p.margin, _LEAST_STEP),
        slope=math.tan(math.radians(robot.max_slope_deg)),
        resolution=resolution,
        reach=p.reach,
        outline=np.array([x0, x1, y0, y1]),
        dip=_LEAST_STEP,
        tall=p.tall,
        top=p.top,
        lasting=p.lasting,
    )


@lru_cache(maxsize=2)
def with_edges(live: LiveObstacles, edges: FloorEdges) -> LiveObstacles:
    """Live obstacles with the edges of the floor; the same object while nothing changes."""
    cells = edges.cells - live.corner
    inside = cells[_within(cells, live.occupied.shape)]
    occupied = live.occupied.copy()
    occupied[inside[:, 0], inside[:, 1]] = 1
    occupied.flags.writeable = False
    return replace(live, occupied=occupied, version=live.version + edges.version)


@lru_cache(maxsize=2)
def without_edges(live: LiveObstacles, edges: FloorEdges) -> LiveObstacles:
    """Live obstacles without those at edges of the floor, whose faces and lower floor they show."""
    cells = edges.cells - live.corner
    inside = cells[_within(cells, live.occupied.shape)]
    mask = np.zeros(live.occupied.shape, dtype=np.uint8)
    mask[inside[:, 0], inside[:, 1]] = 1
    occupied = live.occupied * (1 - maximum_filter(mask, size=2 * _BESIDE_EDGES + 1))
    return replace(live, occupied=occupied, version=live.version + 1)


def open_edges(live: LiveObstacles, ground: GroundMap) -> LiveObstacles:
    """Live obstacles without those at edges of the floor that are no high objects, as legs are."""
    clear = without_edges(live, ground.edges)
    high = np.argwhere(ground.tall > 0) + ground.corner - live.corner
    high = high[_within(high, live.occupied.shape)]
    occupied = clear.occupied.copy()
    occupied[high[:, 0], high[:, 1]] = live.occupied[high[:, 0], high[:, 1]]
    return replace(live, occupied=occupied, version=live.version + ground.edges.version + 1)


def known_floor(
    ground: GroundMap,
    grid: OccupancyGrid,
    wheels: Floats,
    pose: Floats,
    twist: Floats,
    *,
    seen: bool = True,
) -> float:
    """Distance that the outermost wheel of a chair can go before one leaves floor it knows, m.

    Args:
        ground: the map.
        grid: whose cells it uses.
        wheels: (k, 2), their places in the robot frame, m.
        pose: (3,) X_MR.
        twist: (3,) that is kept.
        seen: False: floor on which the chair stood, or began, counts too.
    """
    X_WR = compose(window_from_map(grid, ground.corner), pose)
    sweeps = 2 if seen else 1
    return known_distance(ground.cells, wheels, X_WR, twist, grid.resolution, _FARTHEST, sweeps)


def _with_sweeps(
    ground: GroundMap,
    cells: GroundCells,
    sweeps: list[tuple[PointCloud, Floats]],
    grid: OccupancyGrid,
    robot: Robot,
    rules: GroundRules,
) -> GroundMap:
    """Add sweeps with their poses (3,) to cells that may be changed."""
    X_WM, X_GM = window_from_map(grid, ground.corner), inverse(grid.X_MG)
    tilt, place = ground.tilt.copy(), ground.place
    for cloud, pose in sweeps:
        rotation, origin = placed(compose(X_WM, pose), cloud.mount)
        chair, last, place = transform(X_WM, pose[:2]), place, transform(X_GM, pose[:2])
        # The plane that is expected here: the chair has moved along it.
        tilt[0] += tilt[1:] @ (place - last)
        X_WR, span = compose(X_WM, pose), cloud.range_max
        tilt = add_sweep(cells, cloud.points, rotation, origin, X_WR, span, tilt, rules)
    stand_on(cells, robot.wheels, X_WR, 0.0, -float(tilt[0]), grid.resolution)
    changed = update_kinds(cells, chair, -float(tilt[0]), rules)
    for array in cells:
        array.flags.writeable = False
    edges = _edges(ground, cells.kind) if changed else ground.edges
    return replace(ground, **cells._asdict(), tilt=tilt, place=place, edges=edges)


def _copied(cells: GroundCells) -> GroundCells:
    """Cells that a kernel may change."""
    height, seen, bound, passed, tall, kind = cells
    return GroundCells(
        height.copy(), seen.copy(), bound.copy(), passed.copy(), tall.copy(), kind.copy()
    )


def _edges(ground: GroundMap, kind: Bytes) -> FloorEdges:
    """Cells behind edges in the window, after those that were remembered outside of it."""
    known = ground.edges
    beyond = known.cells[~_within(known.cells - ground.corner, kind.shape)]
    cells = np.concatenate([beyond, np.argwhere(kind >= LOWER) + ground.corner])
    return FloorEdges(cells=cells[-_MOST_EDGES:], version=known.version + 1)


def _within(cells: Integers, shape: tuple[int, ...]) -> Booleans:
    """Mask (k,) of (row, column) inside an array."""
    return np.asarray(((cells >= 0) & (cells < shape)).all(axis=1))


def _empty(
    grid: OccupancyGrid, robot: Robot, corner: Integers, pose: Floats, parameters: GroundParameters
) -> GroundMap:
    """Nothing seen, but floor in the circle in which the chair can turn: it has come there."""
    n = cells_a_side(grid, parameters.side)
    heights, counts = np.zeros((n, n), dtype=np.float32), np.zeros((n, n), dtype=np.uint8)
    cells = _copied(GroundCells(heights, counts, heights, counts, counts, counts))
    X_WR = compose(window_from_map(grid, corner), pose)
    turn = robot.circumscribed_radius + 2.0 * grid.resolution
    stand_on(cells, robot.wheels, X_WR, turn, 0.0, grid.resolution)
    return GroundMap(
        corner=corner,
        **cells._asdict(),
        tilt=np.zeros(3),
        place=transform(inverse(grid.X_MG), pose[:2]),
        edges=FloorEdges(cells=np.empty((0, 2), dtype=np.int64), version=0),
    )


def _rolled(ground: GroundMap, corner: Integers) -> GroundCells:
    """New cells in a window from ``corner``; of those that leave it only edges are remembered."""
    shift = corner - ground.corner
    if not shift.any():
        return _copied(ground.cells)
    old = ground.cells
    cells = GroundCells(
        height=shifted(old.height, shift),
        seen=shifted(old.seen, shift),
        bound=shifted(old.bound, shift),
        passed=shifted(old.passed, shift),
        tall=shifted(old.tall, shift),
        kind=shifted(old.kind, shift),
    )
    for array in cells:
        array.flags.writeable = True
    # Edges that come back hold until floor is seen there: no ray has passed so low.
    back = ground.edges.cells - corner
    back = back[_within(back, cells.kind.shape)]
    back = back[cells.kind[back[:, 0], back[:, 1]] == UNSEEN]
    cells.bound[back[:, 0], back[:, 1]], cells.passed[back[:, 0], back[:, 1]] = -np.inf, 255
    return cells
