"""Validation of problems before they reach a planner.

Compiled loops do not check: an index made of NaN reads or writes anywhere in memory.
"""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from cohelm.arrays import Floats, Floats32
from cohelm.control.api import LocalProblem
from cohelm.errors import Infeasible
from cohelm.maps import DistanceField

_FARTHEST = 1e9
"""Largest distance, m, and speed, m/s: beyond it, squares lose their meaning."""
_THINNEST = 1e-6
"""Smallest extent of a social space in any direction, m: it is a divisor."""


def validated(problem: LocalProblem, steps: int | None = None) -> LocalProblem:
    """The problem itself, cut to ``steps`` if given, after validation.

    Args:
        problem: the problem.
        steps: of the reference and the predictions, for a planner that needs this many; None: any.

    Raises:
        Infeasible: a value is not finite or out of bounds, lengths do not agree, or there are too
            few steps.
    """
    found = _mismatch(problem, steps) or ("" if _is_valid(problem) else _fault(problem))
    if found:
        raise Infeasible(found, evidence=problem)
    return problem if steps is None else problem.within(steps)


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


def _is_valid(problem: LocalProblem) -> bool:
    """Check that all values are finite and within bounds; the fast path, without a message."""
    r, p, s = problem.reference, problem.predictions, problem.spaces
    parts = [problem.pose, problem.twist, r.poses, r.speeds, problem.people.mean]
    parts += [problem.people.radius, p.mean, p.velocity, p.deviation, p.weight, s.axis]
    if s.groups is not None:
        parts.append(s.groups.support)
    extents = (s.front, s.side, s.rear, s.robot)
    return (
        all(map(_small, parts))
        and all(_between(part, _THINNEST, _FARTHEST) for part in extents)
        and abs(problem.time) <= _FARTHEST
        and abs(problem.late) <= _FARTHEST
        and _THINNEST <= r.step <= _FARTHEST
        and _THINNEST <= p.step <= _FARTHEST
        and not math.isnan(problem.speed_limit)
        and _are_valid(problem.walls)
    )


@functools.lru_cache(maxsize=4)
def _are_valid(walls: DistanceField) -> bool:
    """Check the walls, once for all plans among them."""
    return bool(
        _small(walls.distance) and _small(walls.X_MG) and _THINNEST <= walls.resolution <= _FARTHEST
    )


@njit(cache=True, fastmath={"reassoc"})  # vectorised sum in any order; NaN stays NaN
def _small(array: Floats | Floats32) -> bool:
    """Check that the root of the sum of squares is a number within bounds."""
    total = 0.0
    for each in array.flat:
        total += float(each) * float(each)
    return total <= _FARTHEST * _FARTHEST


@njit(cache=True)
def _between(array: Floats, lowest: float, highest: float) -> bool:
    fits = True
    for each in array.flat:
        if not lowest <= each <= highest:  # NaN fails as well
            fits = False
    return fits


def _fault(problem: LocalProblem) -> str:
    """Description of the first invalid value; empty if there is none."""
    r, people, p = problem.reference, problem.people, problem.predictions
    s, walls = problem.spaces, problem.walls
    measured: dict[str, ArrayLike] = {
        "time": problem.time,
        "pose": problem.pose,
        "twist": problem.twist,
        "lateness": problem.late,
        "reference": r.poses,
        "reference's speeds": r.speeds,
        "people": people.mean,
        "people's radii": people.radius,
        "predicted positions": p.mean,
        "predicted velocities": p.velocity,
        "predicted deviations": p.deviation,
        "weights of the predictions": p.weight,
        "axes of the spaces": s.axis,
        "groups": s.groups.support if s.groups is not None else 0.0,
        "walls": walls.distance,
        "walls' origin": walls.X_MG,
    }
    extents = np.concatenate([s.front.ravel(), s.side.ravel(), s.rear.ravel(), s.robot])
    positive: dict[str, ArrayLike] = {
        "extent of a space": extents,
        "step": [r.step, p.step],
        "walls' resolution": walls.resolution,
    }
    with np.errstate(over="ignore", invalid="ignore"):
        for name, each in measured.items():
            flat = np.ravel(each)
            if not np.dot(flat, flat) <= _FARTHEST**2:  # NaN fails as well
                return f"{name}: not a number, or beyond {_FARTHEST:g}"
    for name, each in positive.items():
        if not (np.min(each) >= _THINNEST and np.max(each) <= _FARTHEST):
            return f"{name}: not between {_THINNEST:g} and {_FARTHEST:g}"
    return "speed limit: not a number" if np.isnan(problem.speed_limit) else ""
