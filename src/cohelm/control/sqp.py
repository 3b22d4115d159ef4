"""Condensed Gauss-Newton SQP: a sum of cost terms under a stack of constraints.

The states are eliminated by the rollout, so that the inputs Δu and one slack s for each constraint
group are all that is left:

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
from cohelm.control.api import Constraint, CostTerm, LocalProblem, Measure, Motion, Rows
from cohelm.control.quadratic import Multipliers, QuadraticProgram, minimise

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Lengths that are tried of each step."""
_FAR = 1e6
"""A bound beyond all that a robot does."""


class Value(NamedTuple):
    """What a motion is worth; a tuple, as ``Measure`` is."""

    merit: float
    """Cost plus the price of all slack."""
    costs: Mapping[str, float]
    """½‖r‖² of each term, and the price of each constraint's slack."""
    slack: float
    """Largest violation of a soft constraint, m."""
    barrier: float
    """Smallest h of any constraint, m."""
    measures: tuple[Measure, ...]
    """What each constraint found there."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Solution:
    """Where the SQP ended."""

    motion: Motion
    value: Value
    iterations: int
    """Quadratic programs solved."""


class OptimalControl:
    """One optimal-control problem: what it weighs, what it obeys.

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
        value: Value | None = None,
    ) -> Solution:
        """At most ``iterations`` quadratic programs from ``seed`` on; stops when Δu < tolerance.

        Each step is halved while it does not lower the merit (‖r‖²/2 plus the price of slack).

        Args:
            problem: what is to be solved.
            seed: where to start.
            iterations: the budget.
            tolerance: on every input, m/s and rad/s.
            value: of the seed, where it is known already.

        Raises:
            SolverFailed: if a quadratic program has no solution.
        """
        motion, worth = seed, value or self.value(problem, seed)
        done, change, multipliers = 0, np.inf, None
        while done < iterations and change >= tolerance:
            step, multipliers = self._step(problem, motion, worth, multipliers)
            done += 1
            motion, worth, taken = self._search(problem, motion, worth, step)
            change = taken * float(np.abs(step).max(initial=0.0))
        return Solution(motion=motion, value=worth, iterations=done)

    def value(
        self,
        problem: LocalProblem,
        motion: Motion,
        measures: tuple[Measure, ...] | None = None,
    ) -> Value:
        """What a motion costs, and how near it comes to its constraints.

        Args:
            problem: what is to be solved.
            motion: where.
            measures: what the constraints found there, if known: with another reference, they find
                the same.
        """
        costs = {}
        for term in self.costs:
            residual = term.residual(problem, motion)
            costs[term.name] = 0.5 * float(residual @ residual)
        slack, barrier = 0.0, np.inf
        if measures is None:
            measures = tuple([c.measure(problem, motion) for c in self.constraints])
        for constraint, found in zip(self.constraints, measures, strict=True):
            barrier = min(barrier, found.smallest)
            if len(found.slack):
                price, most = _price(found.slack, constraint.l1, constraint.l2)
                slack = max(slack, most)
                costs[constraint.name] = price
        return Value(
            merit=sum(costs.values()),
            costs=costs,
            slack=slack,
            barrier=barrier,
            measures=measures,
        )

    def _step(
        self, problem: LocalProblem, motion: Motion, value: Value, start: Multipliers | None
    ) -> tuple[Floats, Multipliers]:
        """(Δu, (N·m,); the multipliers, to start the next step from)."""
        program = self.program(problem, motion, value)
        return minimise(program, start or Multipliers.none(program))

    def program(self, problem: LocalProblem, motion: Motion, value: Value) -> QuadraticProgram:
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
            for c, found in zip(self.constraints, value.measures, strict=True)
        ]
        return _program(hessian, gradient, blocks, self._l1, self._l2)

    def _search(
        self, problem: LocalProblem, motion: Motion, value: Value, step: Floats
    ) -> tuple[Motion, Value, float]:
        """Backtracking: (motion, its value, share of the step taken); 0 where nothing is gained."""
        step = step.reshape(motion.inputs.shape)
        share = 1.0
        for _ in range(_HALVINGS):
            candidate = moved(problem, motion, motion.inputs + share * step)
            reached = self.value(problem, candidate)
            if reached.merit < value.merit:
                return candidate, reached, share
            share *= 0.5
        return motion, value, 0.0


def moved(problem: LocalProblem, motion: Motion, inputs: Floats) -> Motion:
    """The motion with other inputs (N, m)."""
    poses = problem.robot.motion.rollout(problem.pose, inputs, motion.step)
    return Motion(step=motion.step, poses=poses, inputs=inputs, last_input=motion.last_input)


def _program(
    hessian: Floats, gradient: Floats, blocks: Sequence[Rows], l1: Floats, l2: Floats
) -> QuadraticProgram:
    """The program of one step; the groups of all constraints are numbered through.

    l1, l2: of each block's slacks.
    """
    low, high = np.full(len(gradient), -_FAR), np.full(len(gradient), _FAR)
    margin = np.concatenate([rows.margin for rows in blocks])
    group = np.concatenate([rows.group for rows in blocks])
    key = np.concatenate([rows.key for rows in blocks])
    sizes = np.array([(len(rows.margin), rows.groups, rows.keys) for rows in blocks])
    room, l1, l2 = _numbered(group, key, sizes, l1, l2)
    at, names = 0, 0
    for rows in blocks:
        if rows.room is not None:
            room[at : at + len(rows.room)] = rows.room
        if rows.low is not None:
            low = np.maximum(low, rows.low)
        if rows.high is not None:
            high = np.minimum(high, rows.high)
        at += len(rows.margin)
        names += rows.keys
    return QuadraticProgram(
        hessian=hessian,
        gradient=gradient,
        low=low,
        high=high,
        jacobian=np.concatenate([rows.jacobian for rows in blocks]),
        margin=margin,
        room=room,
        group=group,
        key=key,
        keys=names,
        l1=l1,
        l2=l2,
    )


@njit(cache=True)
def _numbered(
    group: Integers, key: Integers, sizes: Integers, l1: Floats, l2: Floats
) -> tuple[Floats, Floats, Floats]:
    """(room without bounds, l1, l2 of each slack); numbers ``group`` and ``key`` through.

    sizes: (b, 3), how many rows, groups and keys each block has.
    """
    room = np.full(len(key), _FAR)
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
    return room, linear, squared


@njit(cache=True)
def _price(slack: Floats, l1: float, l2: float) -> tuple[float, float]:
    """(Σ l1·s + ½ l2·s², the largest s)."""
    price, most = 0.0, 0.0
    for s in slack:
        price += l1 * s + 0.5 * l2 * s * s
        most = max(most, s)
    return price, most
