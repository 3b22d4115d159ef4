"""What every planner refuses: a problem with something in it that is no number.

Compiled loops do not check: an index made of NaN reads, or writes, anywhere in memory.
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
"""No place is farther than this, m, and nothing faster, m/s: beyond, squares lose all meaning."""
_THINNEST = 1e-6
"""The least reach of a social space in any direction, m: it is divided by."""


def usable(problem: LocalProblem, steps: int | None = None) -> LocalProblem:
    """The problem itself, cut to ``steps`` where those are given, if a planner can work on it.

    Args:
        problem: what is asked.
        steps: of the reference and the predictions, for who can do with no fewer; None: any.

    Raises:
        Infeasible: something in it is no number or beyond all bounds, lengths do not agree, or it
            has too few steps.
    """
    found = _mismatch(problem, steps) or _no_number(problem)
    if found:
        raise Infeasible(found, evidence=problem)
    return problem if steps is None else problem.within(steps)


def _mismatch(problem: LocalProblem, steps: int | None) -> str:
    """Which lengths do not agree; empty where all do."""
    given, futures = len(problem.reference.poses) - 1, problem.predictions.mean.shape
    if given < (steps or 1):
        return f"the reference has {given} steps, at least {steps or 1} are wanted"
    if futures[0] != len(problem.people) or problem.spaces.axis.shape[0] != futures[0]:
        return f"predictions or spaces are of other people than the {len(problem.people)} there"
    if futures[2] <= given or problem.spaces.axis.shape[2] <= given:
        return f"predictions or spaces end before the reference's {given} steps do"
    if futures[0] and not futures[1]:
        return "people have no predicted future"
    return "the distance field has no cell" if not problem.walls.distance.size else ""


def _no_number(problem: LocalProblem) -> str:
    """What is no number, or out of all bounds; empty where nothing is."""
    return "" if _fine(problem) else _at_fault(problem)


def _fine(problem: LocalProblem) -> bool:
    """Whether all are numbers and none beyond bounds, looked at together: the usual case, fast."""
    r, p, s = problem.reference, problem.predictions, problem.spaces
    parts = [problem.pose, problem.twist, r.poses, r.speeds, problem.people.mean]
    parts += [problem.people.radius, p.mean, p.velocity, p.deviation, p.weight, s.axis]
    if s.groups is not None:
        parts.append(s.groups.support)
    reaches = (s.front, s.side, s.rear, s.robot)
    return (
        all(map(_small, parts))
        and all(_between(part, _THINNEST, _FARTHEST) for part in reaches)
        and abs(problem.time) <= _FARTHEST
        and abs(problem.late) <= _FARTHEST
        and _THINNEST <= r.step <= _FARTHEST
        and _THINNEST <= p.step <= _FARTHEST
        and not math.isnan(problem.speed_limit)
        and _walls_fine(problem.walls)
    )


@functools.lru_cache(maxsize=4)
def _walls_fine(walls: DistanceField) -> bool:
    """The same of the walls, once for all plans among them."""
    return bool(
        _small(walls.distance) and _small(walls.X_MG) and _THINNEST <= walls.resolution <= _FARTHEST
    )


@njit(cache=True, fastmath={"reassoc"})  # in any order, several at once; NaN stays NaN
def _small(array: Floats | Floats32) -> bool:
    """Whether the root of the sum of squares is a number, and not beyond all bounds."""
    total = 0.0
    for each in array.flat:
        total += float(each) * float(each)
    return total <= _FARTHEST * _FARTHEST


@njit(cache=True)
def _between(array: Floats, least: float, most: float) -> bool:
    fits = True
    for each in array.flat:
        if not least <= each <= most:  # nor is NaN
            fits = False
    return fits


def _at_fault(problem: LocalProblem) -> str:
    """What it is; empty where nothing is."""
    r, people, p, s, walls = (
        problem.reference,
        problem.people,
        problem.predictions,
        problem.spaces,
        problem.walls,
    )
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
    reaches = np.concatenate([s.front.ravel(), s.side.ravel(), s.rear.ravel(), s.robot])
    positive: dict[str, ArrayLike] = {
        "reach of a space": reaches,
        "step": [r.step, p.step],
        "walls' resolution": walls.resolution,
    }
    with np.errstate(over="ignore", invalid="ignore"):
        for name, each in measured.items():
            flat = np.ravel(each)
            if not np.dot(flat, flat) <= _FARTHEST**2:  # the fastest look at all; NaN fails it
                return f"{name}: not a number, or beyond {_FARTHEST:g}"
    for name, each in positive.items():
        if not (np.min(each) >= _THINNEST and np.max(each) <= _FARTHEST):
            return f"{name}: not between {_THINNEST:g} and {_FARTHEST:g}"
    return "speed limit: not a number" if np.isnan(problem.speed_limit) else ""
