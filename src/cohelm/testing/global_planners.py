"""The contract of ``planning.GlobalPlanner``."""

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


def check_global_planner(planner: GlobalPlanner, *, within: float = 5.0) -> None:
    """Check a global planner in a room of 12 × 8 m, with and without a pillar and a wish.

    Raises:
        ConformanceError: saying what it does wrong.
    """
    bare, pillar = room(), room(boxes=[_PILLAR])
    _check_route(planner, route_problem(bare), within)
    _check_route(planner, route_problem(pillar), within)
    wish = Wish(points=np.array([[6.0, 1.5]]))
    _check_route(planner, route_problem(pillar, wishes=(wish,)), within)
    _check_route(planner, route_problem(pillar, goal=_START), within)
    _check_failures(planner, pillar)


def route_problem(
    grid: OccupancyGrid,
    *,
    start: ArrayLike = _START,
    goal: ArrayLike = _GOAL,
    wishes: tuple[Wish, ...] = (),
) -> RouteProblem:
    """From the left of a :func:`~cohelm.testing.scenes.room` to its right."""
    return RouteProblem(
        grid=grid,
        robot=load_robot("quantum_q6_edge"),
        start=np.asarray(start, dtype=float),
        goal=np.asarray(goal, dtype=float),
        wishes=wishes,
    )


def _check_route(planner: GlobalPlanner, problem: RouteProblem, within: float) -> None:
    path: Path = steady(lambda: planner.plan(problem), inputs=problem, what="plan", within=within)
    require_finite(
        {
            "the path's points": path.points,
            "its length": path.length,
            "its cost": path.cost,
            "its distance to the wishes": path.wishes.closest,
            "its extra length": path.wishes.extra_length,
        }
    )
    require(len(path.points) >= 1, "a path must have points")
    ends = np.linalg.norm(path.points[[0, -1]] - np.stack([problem.start, problem.goal]), axis=1)
    require(ends < RESOLUTION, f"a path must lead from start to goal, its ends are {ends} m off")
    along = arc_length(path.points)
    require(
        abs(along[-1] - path.length) < TOLERANCE,
        f"length must be that of the points, {along[-1]:.3f} m, says {path.length:.3f} m",
    )
    require(path.cost >= 0.0, "a path must not have a negative cost")
    _check_clear(path, problem)
    wanted = sum(len(wish.points) for wish in problem.wishes if wish.kind == "attract")
    require(
        len(path.wishes.closest) == wanted,
        f"must say how close the path comes to each of {wanted} wished points",
    )


def _check_clear(path: Path, problem: RouteProblem) -> None:
    """Along the whole path, not at its points only; a cell's rounding is forgiven."""
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
    cases = (
        (GoalBlocked, route_problem(grid, goal=inside), "a goal inside an obstacle"),
        (StartBlocked, route_problem(grid, start=inside), "a start inside an obstacle"),
        (OutsideMap, route_problem(grid, goal=outside), "a goal outside the map"),
        (OutsideMap, route_problem(grid, start=outside), "a start outside the map"),
        (NoPath, route_problem(room(boxes=[_WALL])), "a wall right across the room"),
    )
    for error, problem, when in cases:
        require_raises(error, partial(planner.plan, problem), when)
