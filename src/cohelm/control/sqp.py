"""Condensed Gauss-Newton SQP: a sum of cost terms under a stack of constraints.

The rollout eliminates the states, so that only the inputs Δu and the slacks s are left; the rows of
one person, group or disc share a slack:

    minimise   ½‖r + J Δu‖² + Σ l1·s + ½ l2·s²
    subject to margin + G Δu + s ≥ 0,  s ≥ 0          (hard rows without s)

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
    Trajectory,
)
from cohelm.control.qp import Multipliers, QuadraticProgram, minimise

_DAMPING = 1e-4
"""Added to the diagonal, so that every program has one solution."""
_HALVINGS = 6
"""Number of step lengths in the line search."""
_FAR = 1e6
"""A bound beyond all inputs of a robot."""
RELAXED_SLACK = 0.01
"""A plan with more slack than this is reported as relaxed, m."""


class TrajectoryEvaluation(NamedTuple):
    """Cost of a trajectory and its distance from the constraints.

    A tuple, as ``ConstraintValues`` is.
    """

    merit: float
    """Merit function: cost plus the penalty of all slack."""
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

    trajectory: Trajectory
    evaluation: TrajectoryEvaluation
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
        seed: Trajectory,
        *,
        iterations: int,
        tolerance: float = 1e-2,
        evaluation: TrajectoryEvaluation | None = None,
    ) -> Solution:
        """Solve at most ``iterations`` quadratic programs from ``seed``, until Δu < tolerance.

        Each step is halved until it lowers the merit (‖r‖²/2 plus the penalty of the slack).

        Args:
            problem: the problem.
            seed: start of the iteration.
            iterations: the budget.
            tolerance: on every input, m/s and rad/s.
            evaluation: of the seed, if known.

        Raises:
            SolverFailed: if a quadratic program has no solution.
        """
        trajectory, evaluation = seed, evaluation or self.evaluate(problem, seed)
        solved, change, multipliers = 0, np.inf, None
        while solved < iterations and change >= tolerance:
            program = self.program(problem, trajectory, evaluation)
            step, multipliers = minimise(program, multipliers or Multipliers.none(program))
            solved += 1
            trajectory, evaluation, step_length = self._line_search(
                problem, trajectory, evaluation, step
            )
            change = step_length * float(np.abs(step).max(initial=0.0))
        return Solution(trajectory=trajectory, evaluation=evaluation, iterations=solved)

    def evaluate(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        constraints: tuple[ConstraintValues, ...] | None = None,
    ) -> TrajectoryEvaluation:
        """Evaluate the cost and the constraints at a trajectory.

        Args:
            problem: the problem.
            trajectory: the trajectory.
            constraints: values of the constraints, if known: they do not depend on the reference.
        """
        costs = {}
        for term in self.costs:
            residual = term.residual(problem, trajectory)
            costs[term.name] = 0.5 * float(residual @ residual)
        slack, barrier = 0.0, np.inf
        if constraints is None:
            constraints = tuple([c.values(problem, trajectory) for c in self.constraints])
        for constraint, values in zip(self.constraints, constraints, strict=True):
            barrier = min(barrier, values.smallest)
            if len(values.slack):
                penalty, largest = _penalty(values.slack, constraint.l1, constraint.l2)
                slack = max(slack, largest)
                costs[constraint.name] = penalty
        return TrajectoryEvaluation(sum(costs.values()), costs, slack, barrier, constraints)

    def program(
        self, problem: LocalProblem, trajectory: Trajectory, evaluation: TrajectoryEvaluation
    ) -> QuadraticProgram:
        """The quadratic program of the next step, linearised at an evaluated trajectory."""
        sensitivity = problem.robot.motion_model.sensitivity(
            trajectory.poses, trajectory.inputs, trajectory.step
        )
        size = trajectory.inputs.size
        hessian, gradient = np.zeros((size, size)), np.zeros(size)
        for term in self.costs:
            term_hessian, term_gradient = term.model(problem, trajectory, sensitivity)
            hessian += term_hessian
            gradient += term_gradient
        hessian.ravel()[:: size + 1] += _DAMPING
        blocks = [
            c.rows(problem, trajectory, sensitivity, values)
            for c, values in zip(self.constraints, evaluation.constraints, strict=True)
        ]
        return _program(hessian, gradient, blocks, self._l1, self._l2)

    def _line_search(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        evaluation: TrajectoryEvaluation,
        step: Floats,
    ) -> tuple[Trajectory, TrajectoryEvaluation, float]:
        """Backtrack until the merit falls: (trajectory, its evaluation, step length).

        The step length is a share of ``step``; 0 if no share lowers the merit.
        """
        step = step.reshape(trajectory.inputs.shape)
        step_length = 1.0
        for _ in range(_HALVINGS):
            trial = with_inputs(problem, trajectory, trajectory.inputs + step_length * step)
            trial_evaluation = self.evaluate(problem, trial)
            if trial_evaluation.merit < evaluation.merit:
                return trial, trial_evaluation, step_length
            step_length *= 0.5
        return trajectory, evaluation, 0.0


def with_inputs(problem: LocalProblem, trajectory: Trajectory, inputs: Floats) -> Trajectory:
    """The trajectory with other inputs (N, m)."""
    poses = problem.robot.motion_model.rollout(problem.pose, inputs, trajectory.step)
    return Trajectory(
        step=trajectory.step, poses=poses, inputs=inputs, current_input=trajectory.current_input
    )


def _program(
    hessian: Floats, gradient: Floats, blocks: Sequence[ConstraintRows], l1: Floats, l2: Floats
) -> QuadraticProgram:
    """The program of one step; slacks and row ids of all constraints are numbered consecutively.

    l1, l2: (b,) penalties of each block's slacks.
    """
    low, high = np.full(len(gradient), -_FAR), np.full(len(gradient), _FAR)
    slack_index = np.concatenate([rows.slack_index for rows in blocks])
    row_id = np.concatenate([rows.row_id for rows in blocks])
    sizes = np.array([(len(rows.margin), rows.num_slacks, rows.num_row_ids) for rows in blocks])
    upper, l1, l2 = _number_consecutively(slack_index, row_id, sizes, l1, l2)
    first_row, num_row_ids = 0, 0
    for rows in blocks:
        if rows.upper is not None:
            upper[first_row : first_row + len(rows.upper)] = rows.upper
        if rows.low is not None:
            low = np.maximum(low, rows.low)
        if rows.high is not None:
            high = np.minimum(high, rows.high)
        first_row += len(rows.margin)
        num_row_ids += rows.num_row_ids
    return QuadraticProgram(
        hessian=hessian,
        gradient=gradient,
        low=low,
        high=high,
        jacobian=np.concatenate([rows.jacobian for rows in blocks]),
        margin=np.concatenate([rows.margin for rows in blocks]),
        upper=upper,
        slack_index=slack_index,
        row_id=row_id,
        num_row_ids=num_row_ids,
        l1=l1,
        l2=l2,
    )


@njit(cache=True)
def _number_consecutively(
    slack_index: Integers, row_id: Integers, sizes: Integers, l1: Floats, l2: Floats
) -> tuple[Floats, Floats, Floats]:
    """(infinite upper bounds (r,), l1 and l2 of each slack); renumbers the rows in place.

    slack_index, row_id: (r,) of all rows, counted within each block; overwritten.
    sizes: (b, 3), numbers of rows, slacks and row ids of each block.
    """
    upper = np.full(len(row_id), _FAR)
    num_slacks = np.sum(sizes[:, 1])
    l1_of_slack, l2_of_slack = np.empty(num_slacks), np.empty(num_slacks)
    row, first_slack, first_id = 0, 0, 0
    for b in range(sizes.shape[0]):
        for _ in range(sizes[b, 0]):
            slack_index[row] += first_slack if sizes[b, 1] > 0 else 0
            row_id[row] += first_id
            row += 1
        l1_of_slack[first_slack : first_slack + sizes[b, 1]] = l1[b]
        l2_of_slack[first_slack : first_slack + sizes[b, 1]] = l2[b]
        first_slack += sizes[b, 1]
        first_id += sizes[b, 2]
    return upper, l1_of_slack, l2_of_slack


@njit(cache=True)
def _penalty(slack: Floats, l1: float, l2: float) -> tuple[float, float]:
    """(Σ l1·s + ½ l2·s², the largest s)."""
    penalty, largest = 0.0, 0.0
    for s in slack:
        penalty += l1 * s + 0.5 * l2 * s * s
        largest = max(largest, s)
    return penalty, largest
