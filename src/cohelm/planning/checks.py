"""Whether a problem says what it must, before anything is made of it."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import InvalidProblem, OutsideMap
from cohelm.maps import FARTHEST, CostmapFilter
from cohelm.messages import Crowding, Wish
from cohelm.planning.api import RouteProblem


def check_problem(problem: RouteProblem) -> None:
    """Refuse what no path could be planned from; wishes may lie off the map, but somewhere.

    Start and goal are left to those who know the map's bounds.

    Raises:
        PlanningError: OutsideMap if a wished point is not a number or is nowhere on earth;
            InvalidProblem for anything else that is not a number, or negative.
    """
    for wish in problem.wishes:
        _check_wish(wish, problem)
    _require(_is_length(problem.clearance), f"the clearance is {problem.clearance}")
    if problem.wished_from is not None:
        _require(_is_somewhere(problem.wished_from), "the wishes were set nowhere")
    if problem.kept is not None:
        _require(len(problem.kept) > 0, "the path that is kept has no points")
        _require(_is_somewhere(problem.kept), "the path that is kept leads nowhere")
    for outline in problem.groups:
        _require(_is_somewhere(outline), "a group stands nowhere")
    if problem.crowding is not None:
        _check_crowding(problem.crowding)
    for each in problem.filters:
        _check_filter(each)


def _check_wish(wish: Wish, problem: RouteProblem) -> None:
    for point in wish.points:
        if not _is_somewhere(point):
            where = (float(point[0]), float(point[1]))
            raise OutsideMap(what=f"wish ({wish.kind})", point=where, bounds=problem.grid.bounds)
    _require(_is_length(wish.radius), f"the radius of a wish is {wish.radius}")


def _check_crowding(crowding: Crowding) -> None:
    _require(_is_size(crowding.resolution), f"crowding has cells of {crowding.resolution} m")
    _require(_is_somewhere(crowding.X_MG), "crowding lies nowhere")
    _require(bool(np.isfinite(crowding.density).all()), "crowding has a density that is no number")


def _check_filter(each: CostmapFilter) -> None:
    size, numbers = each.mask.resolution, (each.base, each.multiplier)
    _require(_is_size(size), f"a mask has cells of {size} m")
    _require(_is_somewhere(each.mask.X_MG), "a mask lies nowhere")
    _require(all(map(math.isfinite, numbers)), f"a mask counts from {numbers[0]} by {numbers[1]}")


def _require(holds: bool, otherwise: str) -> None:
    if not holds:
        raise InvalidProblem(otherwise)


def _is_somewhere(numbers: Floats) -> bool:
    return bool((np.abs(numbers) <= FARTHEST).all())


def _is_length(number: float) -> bool:
    return 0.0 <= number <= FARTHEST


def _is_size(number: float) -> bool:
    return 0.0 < number <= FARTHEST
