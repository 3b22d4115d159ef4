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

import numpy as np

from cohelm.arrays import Floats
from cohelm.control.api import Constraint, CostTerm, LocalProblem, Measure, Motion, Rows
from cohelm.control.quadratic import Multipliers, QuadraticProgram, minimise

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Lengths that are tried of each step."""
_FAR = 1e6
"""A bound beyond all that a robot does."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Value:
    """What a motion is worth."""

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

    def solve(
        self,
        problem: LocalProblem,
        seed: Motion,
        *,
        iterations: int,
        tolerance: float = 2e-3,
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

    def value(self, problem: LocalProblem, motion: Motion) -> Value:
        """What a motion costs, and how near it comes to its constraints."""
        costs = {}
        for term in self.costs:
            residual = term.residual(problem, motion)
            costs[term.name] = 0.5 * float(residual @ residual)
        slack, barrier = 0.0, np.inf
        measures = tuple([c.measure(problem, motion) for c in self.constraints])
        for constraint, found in zip(self.constraints, measures, strict=True):
            barrier = min(barrier, found.smallest)
            if len(found.slack):
                slack = max(slack, float(found.slack.max()))
                costs[constraint.name] = _price(constraint, found.slack)
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
        hessian.flat[:: size + 1] += _DAMPING
        blocks = [
            (c, c.rows(problem, motion, sensitivity, found))
            for c, found in zip(self.constraints, value.measures, strict=True)
        ]
        return _program(hessian, gradient, blocks)

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
    hessian: Floats, gradient: Floats, blocks: Sequence[tuple[Constraint, Rows]]
) -> QuadraticProgram:
    """The program of one step; the groups of all constraints are numbered through."""
    low, high = np.full(len(gradient), -_FAR), np.full(len(gradient), _FAR)
    first, names = 0, 0
    group, key = [], []
    for _, rows in blocks:
        group.append(np.where(rows.group >= 0, rows.group + first, -1))
        key.append(rows.key + names)
        first += rows.groups
        names += rows.keys
        if rows.low is not None:
            low = np.maximum(low, rows.low)
        if rows.high is not None:
            high = np.minimum(high, rows.high)
    groups = [rows.groups for _, rows in blocks]
    return QuadraticProgram(
        hessian=hessian,
        gradient=gradient,
        low=low,
        high=high,
        jacobian=np.concatenate([rows.jacobian for _, rows in blocks]),
        margin=np.concatenate([rows.margin for _, rows in blocks]),
        room=np.concatenate([_room(rows) for _, rows in blocks]),
        group=np.concatenate(group),
        key=np.concatenate(key),
        keys=names,
        l1=np.repeat([c.l1 for c, _ in blocks], groups),
        l2=np.repeat([max(c.l2, _DAMPING) for c, _ in blocks], groups),
    )


def _room(rows: Rows) -> Floats:
    return np.full(len(rows.margin), _FAR) if rows.room is None else rows.room


def _price(constraint: Constraint, slack: Floats) -> float:
    return float(constraint.l1 * slack.sum() + 0.5 * constraint.l2 * (slack @ slack))
