"""Contract of ``planning.GlobalPlanner``."""

from __future__ import annotations

from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from cohelm.errors import GoalBlocked, NoPath, OutsideMap, StartBlocked
from cohelm.geometry import arc_length
from cohelm.maps import OccupancyGrid, distance_field
from cohelm.messages import Path, Wish
from cohelm.planning.api import GlobalPlanner, RouteProblem
from cohelm.robots import load_robot
from cohelm.testing.conformance import (
    TOLERANCE,
    require,
    require_finite,
    require_raises,
    steady,
)
from cohelm.testing.scenes import RESOLUTION, room

_START = (2.0, 4.0)
_GOAL = (10.0, 4.0)
_PILLAR = (5.5, 3.0, 6.5, 5.0)
_WALL = (5.9, 0.0, 6.1, 8.0)
_KINDS = ("attract", "stroke", "avoid")


_WISHES: dict[str, tuple[Wish, ...]] = {
    "a point": (Wish(points=np.array([[6.0, 1.5]])),),
    "points in order": (Wish(points=np.array([[8.0, 6.5], [4.0, 1.5]])),),
    "points in any order": (
        Wish(points=np.array([[8.0, 6.5]])),
        Wish(points=np.array([[4.0, 6.0]])),
        Wish(points=np.array([[3.0, 3.0]])),
    ),
    "a stroke": (Wish(kind="stroke", points=np.array([[3.0, 4.0], [5.0, 6.5], [8.0, 6.5]])),),
    "a stroke without length": (Wish(kind="stroke", points=np.array([[4.0, 6.0], [4.0, 6.0]])),),
    "a point in an obstacle": (Wish(points=np.array([[6.0, 4.0]])),),
    "a point off the map": (Wish(points=np.array([[60.0, -40.0]])),),
    "a point at the start": (Wish(points=np.array([_START])),),
    "a soft zone": (Wish(kind="avoid", points=np.array([[6.0, 2.0]]), radius=0.8),),
    "a hard zone": (Wish(kind="avoid", points=np.array([[6.0, 2.0]]), radius=0.8, hard=True),),
    "a drawn zone": (
        Wish(kind="avoid", points=np.array([[5.0, 0.5], [7.0, 0.5], [6.0, 2.5]]), hard=True),
    ),
    "no points at all": (Wish(points=np.empty((0, 2))),),
}
"""Wishes in a room with a pillar in its middle."""


def check_global_planner(planner: GlobalPlanner, *, within: float = 5.0) -> None:
    """Check a global planner in a room of 12 × 8 m, with and without a pillar and wishes.

    Args:
        planner: the part.
        within: allowed thread CPU time of a plan, s.

    Raises:
        ConformanceError: naming the violated rule.
    """
    bare, pillar = room(), room(boxes=[_PILLAR])
    for grid in (bare, pillar):
        path = _check_route(planner, route_problem(grid), within)
        extra = abs(path.wishes.extra_cost) + abs(path.wishes.extra_length)
        require(extra <= TOLERANCE, "without wishes, extra length and cost must be 0")
    for wishes in _WISHES.values():
        _check_route(planner, route_problem(pillar, wishes=wishes), within)
    together = tuple(wish for wishes in _WISHES.values() for wish in wishes if wish.kind != "avoid")
    kinds = (*together[:2], *_WISHES["a stroke"], *_WISHES["a soft zone"])
    _check_route(planner, route_problem(pillar, wishes=kinds), within)
    _check_route(planner, route_problem(pillar, goal=_START), within)
    _check_failures(planner, pillar)


def route_problem(
    grid: OccupancyGrid,
    *,
    start: ArrayLike = _START,
    goal: ArrayLike = _GOAL,
    wishes: tuple[Wish, ...] = (),
) -> RouteProblem:
    """Problem from the left of a :func:`~cohelm.testing.scenes.room` to its right."""
    return RouteProblem(
        grid=grid,
        robot=load_robot("quantum_q6_edge"),
        start=np.asarray(start, dtype=float),
        goal=np.asarray(goal, dtype=float),
        wishes=wishes,
    )


def _check_route(planner: GlobalPlanner, problem: RouteProblem, within: float) -> Path:
    path: Path = steady(lambda: planner.plan(problem), inputs=problem, what="plan", within=within)
    require_finite(
        {
            "the path's points": path.points,
            "its length": path.length,
            "its cost": path.cost,
            "its extra length": path.wishes.extra_length,
        }
    )
    require(len(path.points) >= 1, "a path must have points")
    ends = np.linalg.norm(path.points[[0, -1]] - np.stack([problem.start, problem.goal]), axis=1)
    require(ends < RESOLUTION, f"a path must lead from start to goal, its ends are {ends} m away")
    along = arc_length(path.points)
    require(
        abs(along[-1] - path.length) < TOLERANCE,
        f"length must be that of the points, {along[-1]:.3f} m, but is {path.length:.3f} m",
    )
    require(path.cost >= 0.0, "a path must not have a negative cost")
    _check_clear(path, problem)
    _check_report(path, problem)
    return path


def _check_report(path: Path, problem: RouteProblem) -> None:
    """Check that every wish is reported, and no path enters a forbidden zone."""
    given = {kind: [w for w in problem.wishes if w.kind == kind] for kind in _KINDS}
    points = sum(len(wish.points) for wish in given["attract"])
    said = (
        (path.wishes.closest, points, "the distance of the path from each of {} attracting points"),
        (
            path.wishes.along,
            len(given["stroke"]),
            "the mean distance of the path from each of {} strokes",
        ),
        (
            path.wishes.avoided,
            len(given["avoid"]),
            "the distance of the path from each of {} zones",
        ),
    )
    for values, count, what in said:
        require(len(values) == count, f"must report {what.format(count)}")
        require_finite({"its distance to the wishes": values})
    for wish, distance in zip(given["avoid"], path.wishes.avoided, strict=True):
        require(
            not wish.hard or distance >= -RESOLUTION,
            f"the path enters a hard zone by {-distance:.2f} m",
        )


def _check_clear(path: Path, problem: RouteProblem) -> None:
    """Check the clearance along the whole path; the rounding of a cell is allowed."""
    along = arc_length(path.points)
    at = np.linspace(0.0, along[-1], max(2, int(along[-1] / (RESOLUTION / 2.0))))
    points = np.stack([np.interp(at, along, path.points[:, i]) for i in (0, 1)], axis=-1)
    clear = float(distance_field(problem.grid).at(points).min())
    needed = problem.robot.inscribed_radius + problem.clearance - RESOLUTION
    require(
        clear >= needed, f"the path comes within {clear:.2f} m of a wall, {needed:.2f} m are needed"
    )


def _check_failures(planner: GlobalPlanner, grid: OccupancyGrid) -> None:
    inside, outside = (6.0, 4.0), (30.0, 4.0)
    across = Wish(kind="avoid", points=np.array([[6.0, 0.0], [6.0, 8.0]]), radius=0.2, hard=True)
    nowhere = Wish(points=np.array([[np.nan, 4.0]]))
    cases = (
        (GoalBlocked, route_problem(grid, goal=inside), "a goal inside an obstacle"),
        (StartBlocked, route_problem(grid, start=inside), "a start inside an obstacle"),
        (OutsideMap, route_problem(grid, goal=outside), "a goal outside the map"),
        (OutsideMap, route_problem(grid, start=outside), "a start outside the map"),
        (OutsideMap, route_problem(grid, wishes=(nowhere,)), "a wish that is not finite"),
        (NoPath, route_problem(room(boxes=[_WALL])), "a wall right across the room"),
        (NoPath, route_problem(grid, wishes=(across,)), "a hard zone right across the room"),
    )
    for error, problem, when in cases:
        require_raises(error, partial(planner.plan, problem), when)
