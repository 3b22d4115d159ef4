"""Quadratic programs of the SQP as plain arrays, for tests and comparisons with other solvers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.control import qp, sqp
from cohelm.control.daqp_call import daqp_addresses, daqp_arrays
from cohelm.control.objective import trajectory_cost
from cohelm.control.optimal_control import PreparedControl
from cohelm.control.solver_tables import Program, Rows, SolverWorkspace, solver_workspace
from cohelm.errors import SolverFailed

_ROWS = 8192


class QuadraticProgram(NamedTuple):
    """A complete program.

    Minimise ½ xᵀHx + gᵀx + Σ l1·s + ½ l2·s² subject to low ≤ x ≤ high, s ≥ 0 and
    −margin ≤ J x + s ≤ upper.
    """

    hessian: Floats
    """H, (n, n)."""
    gradient: Floats
    """g, (n,)."""
    low: Floats
    """(n,)."""
    high: Floats
    """(n,)."""
    jacobian: Floats
    """J, (r, n)."""
    margin: Floats
    """(r,)."""
    upper: Floats
    """(r,)."""
    slack: Integers
    """(r,) index of the slack; −1: none."""
    key: Integers
    """(r,) different for each row."""
    l1: Floats
    """(S,) prices of the slacks."""
    l2: Floats
    """(S,)."""

    def slacks(self, x: Floats) -> Floats:
        """The smallest feasible slacks (S,) at x."""
        soft, out = self.slack >= 0, np.zeros(len(self.l1))
        np.maximum.at(out, self.slack[soft], -(self.jacobian @ x + self.margin)[soft])
        return out

    def objective(self, x: Floats) -> float:
        """Objective at x with its smallest slacks."""
        s = self.slacks(x)
        price = self.l1 @ s + 0.5 * s @ (self.l2 * s)
        return float(0.5 * x @ self.hessian @ x + self.gradient @ x + price)


class Duals(NamedTuple):
    """Multipliers with which a solve begins."""

    inputs: Floats
    """(n,)."""
    slacks: Floats
    """(S,)."""
    rows: Floats
    """(keys,)."""


def program_at(prepared: PreparedControl, inputs: Floats) -> QuadraticProgram:
    """The program of the SQP at inputs (L, m), with all its rows.

    Raises:
        SolverFailed: if it has too many rows.
    """
    scene, o = prepared.scene, prepared.objective
    space = solver_workspace(scene, o, _ROWS)
    space.inputs[0][:] = inputs
    trajectory_cost(scene, o, space.inputs[0], space.poses[0], space.work)
    count = sqp.linearise(scene, o, space, space.inputs[0])
    if count < 0:
        raise SolverFailed(f"the quadratic program has more than {_ROWS} rows")
    p, rows = space.program, space.rows
    return QuadraticProgram(
        p.hessian, p.gradient, p.low, p.high, rows.jacobian[:count].copy(),
        rows.margin[:count].copy(), rows.upper[:count].copy(), rows.slack[:count].copy(),
        rows.key[:count].copy(), p.l1, p.l2,
    )  # fmt: skip


def minimise(
    program: QuadraticProgram, like: SolverWorkspace, start: Duals | None = None
) -> tuple[Floats, Duals]:
    """(x, multipliers) by the planner's solver, which adds rows on demand.

    Args:
        program: the program.
        like: workspace of any problem, for the types of its arrays.
        start: multipliers of a similar program.

    Raises:
        SolverFailed: if there is no solution.
    """
    space = program_workspace(program, like)
    if start is not None:
        space.program.of_inputs[:] = start.inputs
        space.program.of_slacks[:] = start.slacks
        space.program.of_rows[:] = start.rows
    flag = qp.minimise(daqp_addresses(), space, len(program.margin))
    if flag < 1:
        raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
    p = space.program
    return p.z[: len(program.gradient)], Duals(p.of_inputs, p.of_slacks, p.of_rows)


def program_workspace(program: QuadraticProgram, like: SolverWorkspace) -> SolverWorkspace:
    """The workspace that holds a program; ``like`` is any other, for the types of its arrays."""
    n, slacks, count = len(program.gradient), len(program.l1), len(program.margin)
    size, keys = n + slacks, int(program.key.max(initial=0)) + 1

    def zeros(*shape: int) -> Floats:
        return np.zeros(shape)

    def whole(length: int) -> Integers:
        return np.zeros(length, np.int64)

    rows = Rows(
        program.margin.copy(), program.upper.copy(), np.ascontiguousarray(program.jacobian),
        program.slack.copy(), program.key.copy(), np.zeros(count, np.bool_), whole(count),
        zeros(count),
    )  # fmt: skip
    made = Program(
        np.ascontiguousarray(program.hessian), program.gradient.copy(), program.low.copy(),
        program.high.copy(), program.l1.copy(), program.l2.copy(), whole(slacks), whole(slacks),
        zeros(size * size), zeros(size), zeros(size + count), zeros(size + count),
        zeros(size + count), zeros(count * size), zeros(size), zeros(size + count),
        zeros(n), zeros(slacks), zeros(keys), zeros(slacks),
    )  # fmt: skip
    return like._replace(rows=rows, program=made, daqp=daqp_arrays(size + count))
