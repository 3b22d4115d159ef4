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
from cohelm.control.api import Constraint, CostTerm, LocalProblem, Motion, Rows
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
            step, multipliers = self._step(problem, motion, multipliers)
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
        for constraint in self.constraints:
            needed, smallest = constraint.measure(problem, motion)
            barrier = min(barrier, smallest)
            if len(needed):
                slack = max(slack, float(needed.max()))
                costs[constraint.name] = _price(constraint, needed)
        return Value(merit=sum(costs.values()), costs=costs, slack=slack, barrier=barrier)

    def _step(
        self, problem: LocalProblem, motion: Motion, start: Multipliers | None
    ) -> tuple[Floats, Multipliers]:
        """(Δu, (N·m,); the multipliers, to start the next step from)."""
        sensitivity = problem.robot.motion.sensitivity(motion.poses, motion.inputs, motion.step)
        residual = np.concatenate([t.residual(problem, motion) for t in self.costs])
        jacobian = np.vstack([t.jacobian(problem, motion, sensitivity) for t in self.costs])
        blocks = [(c, c.rows(problem, motion, sensitivity)) for c in self.constraints]
        program = _program(residual, jacobian, blocks, self._box(problem, motion))
        return minimise(program, start or Multipliers.none(program))

    def _box(self, problem: LocalProblem, motion: Motion) -> Floats:
        """The bounds (2, N·m) on Δu that all constraints leave."""
        box = np.empty((2, motion.inputs.size))
        box[0], box[1] = -_FAR, _FAR
        for constraint in self.constraints:
            bounds = constraint.box(problem, motion)
            if bounds is not None:
                box[0] = np.maximum(box[0], bounds[0])
                box[1] = np.minimum(box[1], bounds[1])
        return box

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
    residual: Floats, jacobian: Floats, blocks: Sequence[tuple[Constraint, Rows]], box: Floats
) -> QuadraticProgram:
    """The program of one step; the groups of all constraints are numbered through."""
    hessian = jacobian.T @ jacobian
    diagonal = np.arange(len(hessian))
    hessian[diagonal, diagonal] += _DAMPING
    first = np.cumsum([0, *(rows.groups for _, rows in blocks)])
    names = np.cumsum([0, *(rows.keys for _, rows in blocks)])
    return QuadraticProgram(
        hessian=hessian,
        gradient=jacobian.T @ residual,
        low=box[0],
        high=box[1],
        jacobian=np.vstack([rows.jacobian for _, rows in blocks]),
        margin=np.concatenate([rows.margin for _, rows in blocks]),
        room=np.concatenate([_room(rows) for _, rows in blocks]),
        group=np.concatenate(
            [
                np.where(rows.group >= 0, rows.group + start, -1)
                for (_, rows), start in zip(blocks, first[:-1], strict=True)
            ]
        ),
        key=np.concatenate(
            [rows.key + start for (_, rows), start in zip(blocks, names[:-1], strict=True)]
        ),
        keys=int(names[-1]),
        l1=np.repeat([c.l1 for c, _ in blocks], np.diff(first)),
        l2=np.repeat([max(c.l2, _DAMPING) for c, _ in blocks], np.diff(first)),
    )


def _room(rows: Rows) -> Floats:
    return np.full(len(rows.margin), _FAR) if rows.room is None else rows.room


def _price(constraint: Constraint, slack: Floats) -> float:
    return float(constraint.l1 * slack.sum() + 0.5 * constraint.l2 * (slack @ slack))
