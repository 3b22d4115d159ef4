"""Condensed Gauss-Newton SQP: a sum of cost terms under a stack of constraints.

The rollout eliminates the states, so that only the inputs Δu and one slack s for each constraint
group are left:

    minimise   ½‖r + J Δu‖² + Σ l1·s + ½ l2·s²
    subject to g + G Δu + s ≥ 0,  s ≥ 0          (hard rows without s)

The assembler knows no term and no constraint by name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.control.api import (
    Constraint,
    ConstraintRows,
    ConstraintValues,
    CostTerm,
    LocalProblem,
    Motion,
)
from cohelm.control.qp import Multipliers, QuadraticProgram, minimise

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Number of step lengths in the line search."""
_FAR = 1e6
"""A bound beyond all inputs of a robot."""


class MotionValue(NamedTuple):
    """Cost of a motion and distance from its constraints; a tuple, as ``ConstraintValues`` is."""

    merit: float
    """Cost plus the penalty of all slack."""
    costs: Mapping[str, float]
    """½‖r‖² of each term, and the penalty of each constraint's slack."""
    slack: float
    """Largest violation of a soft constraint, m."""
    barrier: float
    """Smallest h of any constraint, m."""
    constraints: tuple[ConstraintValues, ...]
    """Values of each constraint."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """Result of the SQP."""

    motion: Motion
    value: MotionValue
    iterations: int
    """Quadratic programs solved."""


class OptimalControl:
    """An optimal-control problem.

    Args:
        costs: the summands of the cost.
        constraints: the stack of constraints.
    """

    def __init__(self, costs: Sequence[CostTerm], constraints: Sequence[Constraint]) -> None:
        self.costs = tuple(costs)
        self.constraints = tuple(constraints)
        self._l1 = np.array([float(c.l1) for c in self.constraints])
        self._l2 = np.array([max(float(c.l2), _DAMPING) for c in self.constraints])

    def solve(
        self,
        problem: LocalProblem,
        seed: Motion,
        *,
        iterations: int,
        tolerance: float = 1e-2,
        value: MotionValue | None = None,
    ) -> Solution:
        """Solve at most ``iterations`` quadratic programs from ``seed``, until Δu < tolerance.

        Each step is halved until it lowers the merit (‖r‖²/2 plus the penalty of the slack).

        Args:
            problem: the problem.
            seed: start of the iteration.
            iterations: the budget.
            tolerance: on every input, m/s and rad/s.
            value: of the seed, if known.

        Raises:
            SolverFailed: if a quadratic program has no solution.
        """
        motion, worth = seed, value or self.value(problem, seed)
        done, change, multipliers = 0, np.inf, None
        while done < iterations and change >= tolerance:
            program = self.program(problem, motion, worth)
            step, multipliers = minimise(program, multipliers or Multipliers.none(program))
            done += 1
            motion, worth, share = self._line_search(problem, motion, worth, step)
            change = share * float(np.abs(step).max(initial=0.0))
        return Solution(motion=motion, value=worth, iterations=done)

    def value(
        self,
        problem: LocalProblem,
        motion: Motion,
        constraints: tuple[ConstraintValues, ...] | None = None,
    ) -> MotionValue:
        """Cost of a motion and distance from its constraints.

        Args:
            problem: the problem.
            motion: the motion.
            constraints: values of the constraints, if known: they do not depend on the reference.
        """
        costs = {}
        for term in self.costs:
            residual = term.residual(problem, motion)
            costs[term.name] = 0.5 * float(residual @ residual)
        slack, barrier = 0.0, np.inf
        if constraints is None:
            constraints = tuple([c.values(problem, motion) for c in self.constraints])
        for constraint, found in zip(self.constraints, constraints, strict=True):
            barrier = min(barrier, found.smallest)
            if len(found.slack):
                penalty, most = _penalty(found.slack, constraint.l1, constraint.l2)
                slack = max(slack, most)
                costs[constraint.name] = penalty
        return MotionValue(sum(costs.values()), costs, slack, barrier, constraints)

    def program(
        self, problem: LocalProblem, motion: Motion, value: MotionValue
    ) -> QuadraticProgram:
        """The quadratic program of the next step, linearised at a motion of known value."""
        sensitivity = problem.robot.motion.sensitivity(motion.poses, motion.inputs, motion.step)
        size = motion.inputs.size
        hessian, gradient = np.zeros((size, size)), np.zeros(size)
        for term in self.costs:
            curvature, slope = term.model(problem, motion, sensitivity)
            hessian += curvature
            gradient += slope
        hessian.ravel()[:: size + 1] += _DAMPING
        blocks = [
            c.rows(problem, motion, sensitivity, found)
            for c, found in zip(self.constraints, value.constraints, strict=True)
        ]
        return _program(hessian, gradient, blocks, self._l1, self._l2)

    def _line_search(
        self, problem: LocalProblem, motion: Motion, value: MotionValue, step: Floats
    ) -> tuple[Motion, MotionValue, float]:
        """Backtracking: (motion, its value, share of the step); 0 if no share lowers the merit."""
        step = step.reshape(motion.inputs.shape)
        share = 1.0
        for _ in range(_HALVINGS):
            candidate = with_inputs(problem, motion, motion.inputs + share * step)
            reached = self.value(problem, candidate)
            if reached.merit < value.merit:
                return candidate, reached, share
            share *= 0.5
        return motion, value, 0.0


def with_inputs(problem: LocalProblem, motion: Motion, inputs: Floats) -> Motion:
    """The motion with other inputs (N, m)."""
    poses = problem.robot.motion.rollout(problem.pose, inputs, motion.step)
    return Motion(step=motion.step, poses=poses, inputs=inputs, last_input=motion.last_input)


def _program(
    hessian: Floats, gradient: Floats, blocks: Sequence[ConstraintRows], l1: Floats, l2: Floats
) -> QuadraticProgram:
    """The program of one step; groups and keys of all constraints are numbered consecutively.

    l1, l2: of each block's slacks.
    """
    low, high = np.full(len(gradient), -_FAR), np.full(len(gradient), _FAR)
    group = np.concatenate([rows.group for rows in blocks])
    key = np.concatenate([rows.key for rows in blocks])
    sizes = np.array([(len(rows.margin), rows.groups, rows.keys) for rows in blocks])
    upper, l1, l2 = _numbered(group, key, sizes, l1, l2)
    at, keys = 0, 0
    for rows in blocks:
        if rows.upper is not None:
            upper[at : at + len(rows.upper)] = rows.upper
        if rows.low is not None:
            low = np.maximum(low, rows.low)
        if rows.high is not None:
            high = np.minimum(high, rows.high)
        at += len(rows.margin)
        keys += rows.keys
    return QuadraticProgram(
        hessian=hessian,
        gradient=gradient,
        low=low,
        high=high,
        jacobian=np.concatenate([rows.jacobian for rows in blocks]),
        margin=np.concatenate([rows.margin for rows in blocks]),
        upper=upper,
        group=group,
        key=key,
        keys=keys,
        l1=l1,
        l2=l2,
    )


@njit(cache=True)
def _numbered(
    group: Integers, key: Integers, sizes: Integers, l1: Floats, l2: Floats
) -> tuple[Floats, Floats, Floats]:
    """(infinite upper bounds, l1, l2 of each slack); renumbers ``group`` and ``key`` in place.

    sizes: (b, 3), numbers of rows, groups and keys of each block.
    """
    upper = np.full(len(key), _FAR)
    slacks = np.sum(sizes[:, 1])
    linear, squared = np.empty(slacks), np.empty(slacks)
    at, first, names = 0, 0, 0
    for b in range(sizes.shape[0]):
        for _ in range(sizes[b, 0]):
            group[at] += first if sizes[b, 1] > 0 else 0
            key[at] += names
            at += 1
        linear[first : first + sizes[b, 1]] = l1[b]
        squared[first : first + sizes[b, 1]] = l2[b]
        first += sizes[b, 1]
        names += sizes[b, 2]
    return upper, linear, squared


@njit(cache=True)
def _penalty(slack: Floats, l1: float, l2: float) -> tuple[float, float]:
    """(Σ l1·s + ½ l2·s², the largest s)."""
    penalty, most = 0.0, 0.0
    for s in slack:
        penalty += l1 * s + 0.5 * l2 * s * s
        most = max(most, s)
    return penalty, most
