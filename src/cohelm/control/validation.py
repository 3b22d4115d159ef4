"""Validation of problems before they reach a planner.

Compiled loops do not check: an index made of NaN reads or writes anywhere in memory.
"""

from __future__ import annotations

import functools
import math

from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.api import LocalProblem
from cohelm.errors import Infeasible
from cohelm.kernels import CACHED
from cohelm.maps import DistanceField

_FARTHEST = 1e9
"""Largest distance, m, and speed, m/s: beyond it, squares lose their meaning."""
_THINNEST = 1e-6
"""Smallest extent of a social space in any direction, m: it is a divisor."""


def check_problem(problem: LocalProblem, steps: int | None = None) -> None:
    """Check all values and lengths of a problem.

    Args:
        problem: the problem.
        steps: of the reference and the predictions, for a planner that needs this many; None: any.

    Raises:
        Infeasible: a value is not finite or out of bounds, lengths do not agree, or there are too
            few steps.
    """
    fault = _mismatch(problem, steps) or _invalid_value(problem)
    if fault:
        raise Infeasible(fault, evidence=problem)


def _mismatch(problem: LocalProblem, steps: int | None) -> str:
    """Description of lengths that do not agree; empty if all do."""
    given, futures = len(problem.reference.poses) - 1, problem.predictions.mean.shape
    if given < (steps or 1):
        return f"the reference has {given} steps, at least {steps or 1} are needed"
    if futures[0] != len(problem.people) or problem.spaces.axis.shape[0] != futures[0]:
        return f"predictions or spaces do not match the {len(problem.people)} people"
    if futures[2] <= given or problem.spaces.axis.shape[2] <= given:
        return f"predictions or spaces are shorter than the reference of {given} steps"
    if futures[0] and not futures[1]:
        return "people have no predicted future"
    return "the distance field has no cell" if not problem.walls.distance.size else ""


def _invalid_value(problem: LocalProblem) -> str:
    """Description of the first value that is not finite or out of bounds; empty if all are good."""
    r, people, p, s = problem.reference, problem.people, problem.predictions, problem.spaces
    scalars = {"time": problem.time, "lateness": problem.late}
    for name, value in scalars.items():
        if not abs(value) <= _FARTHEST:  # NaN fails as well
            return _beyond(name)
    arrays = {
        "pose": problem.pose,
        "twist": problem.twist,
        "reference": r.poses,
        "reference's speeds": r.speeds,
        "people": people.mean,
        "people's radii": people.radius,
        "predicted positions": p.mean,
        "predicted velocities": p.velocity,
        "predicted deviations": p.deviation,
        "weights of the predictions": p.weight,
        "axes of the spaces": s.axis,
    }
    if s.groups is not None:
        arrays["groups"] = s.groups.support
    for name, array in arrays.items():
        if not _is_small(array):
            return _beyond(name)
    for extent in (s.front, s.side, s.rear, s.robot):
        if not _is_between(extent, _THINNEST, _FARTHEST):
            return _outside("extent of a space")
    for step in (r.step, p.step):
        if not _THINNEST <= step <= _FARTHEST:
            return _outside("step")
    return _invalid_walls(problem.walls) or (
        "speed limit: not a number" if math.isnan(problem.speed_limit) else ""
    )


@functools.lru_cache(maxsize=4)
def _invalid_walls(walls: DistanceField) -> str:
    """Description of an invalid distance field, once for all plans in it; empty if it is good."""
    if not _is_small(walls.distance):
        return _beyond("walls")
    if not _is_small(walls.X_MG):
        return _beyond("walls' origin")
    return "" if _THINNEST <= walls.resolution <= _FARTHEST else _outside("walls' resolution")


def _beyond(name: str) -> str:
    return f"{name}: not a number, or beyond {_FARTHEST:g}"


def _outside(name: str) -> str:
    return f"{name}: not between {_THINNEST:g} and {_FARTHEST:g}"


@njit(**CACHED, fastmath={"reassoc"})  # vectorised sum in any order; NaN stays NaN
def _is_small(array: Floats | Floats32) -> bool:
    """Check that the root of the sum of squares is a number within bounds."""
    total = 0.0
    for each in array.flat:
        total += float(each) * float(each)
    return total <= _FARTHEST * _FARTHEST


@njit(**CACHED)
def _is_between(array: Floats, lowest: float, highest: float) -> bool:
    """Check that all values are numbers within bounds."""
    fits = True
    for each in array.flat:
        if not lowest <= each <= highest:  # NaN fails as well
            fits = False
    return fits
