"""Quadratic programs, solved by DAQP (Arnström et al. 2022), a dual active-set solver.

Most rows of a crowded problem never become active, so rows are added on demand: solve with the
tightest rows, check the others for violations, add those, solve again. The result is that of the
whole program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import daqp
import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.errors import SolverFailed

_NO_BOUND = 1e30
"""Infinity for DAQP."""
_FIRST, _TIGHT = 96, 0.05
"""First program: maximum number of soft rows, and the margin below which they are used, m."""
_HARD = 0.15
"""First program: distance to a bound below which hard rows are used."""
_TOLERANCE = 1e-7
"""Violation from which a row is added."""
_NEXT = 0.02
"""Rows within this of a violation are added together with a violated one."""
_ROUNDS = 12
"""Rounds of adding rows; then all rows are used."""


class QuadraticProgram(NamedTuple):
    """min ½ xᵀHx + fᵀx + Σ l1·s + ½ l2·s²  s.t.  the rows, low ≤ x ≤ high, s ≥ 0.

    Each row is −margin ≤ G x + s[slack_index] ≤ upper; a hard row (slack_index −1) has no s.
    """

    hessian: Floats
    """H, (x, x), positive definite."""
    gradient: Floats
    """f, (x,)."""
    low: Floats
    """Lower bounds of x, (x,)."""
    high: Floats
    """Upper bounds of x, (x,)."""
    jacobian: Floats
    """G, (r, x)."""
    margin: Floats
    """Distance of each row from its lower bound at x = 0, (r,)."""
    upper: Floats
    """Distance of each row from its upper bound at x = 0, (r,)."""
    slack_index: Integers
    """Slack of each row, (r,); −1: none."""
    row_id: Integers
    """Identifier of each row, (r,), the same from program to program."""
    num_row_ids: int
    """Number of identifiers."""
    l1: Floats
    """Linear penalty of each slack, (s,)."""
    l2: Floats
    """Quadratic penalty of each slack, (s,)."""


@dataclass(slots=True, eq=False)
class Multipliers:
    """Lagrange multipliers of a program, from which the next, similar one starts."""

    box: Floats
    """Of low ≤ x ≤ high, (x,)."""
    slack: Floats
    """Of s ≥ 0, (s,)."""
    rows: Floats
    """Of the rows, by ``QuadraticProgram.row_id``, (num_row_ids,)."""

    @staticmethod
    def none(program: QuadraticProgram) -> Multipliers:
        """No row is active."""
        return Multipliers(
            np.zeros(len(program.gradient)),
            np.zeros(len(program.l1)),
            np.zeros(program.num_row_ids),
        )


def minimise(program: QuadraticProgram, start: Multipliers) -> tuple[Floats, Multipliers]:
    """Solve a program: (the minimiser x, its multipliers).

    Raises:
        SolverFailed: if there is no solution, or it is not finite.
    """
    used = _first_rows(program, start.rows)
    for rounds_left in reversed(range(_ROUNDS + 1)):
        x, slack, start = _solve(program, used, start)
        if not _add_violated(program, x, slack, used):
            break
        if rounds_left == 1:
            used[:] = True
    return x, start


def _solve(
    program: QuadraticProgram, used: Booleans, start: Multipliers
) -> tuple[Floats, Floats, Multipliers]:
    """(x, all slacks, multipliers) with the used rows only."""
    s = _stacked(program, used, start.box, start.slack, start.rows)
    sense = np.zeros(len(s.upper), dtype=np.int32)  # all rows are inequalities
    z, _, flag, info = daqp.solve(
        s.hessian, s.gradient, s.rows, s.upper, s.lower, sense, dual_start=s.dual
    )
    if flag < 1 or not math.isfinite(z @ z):
        raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
    n, multipliers = len(program.gradient), info["lam"]
    slack, of_slack, of_rows = _scattered(program, s, z, multipliers)
    return z[:n], slack, Multipliers(multipliers[:n], of_slack, of_rows)


@njit(cache=True)
def _first_rows(p: QuadraticProgram, multipliers: Floats) -> Booleans:
    """Rows active in the last program, and those with small margins; of soft ones the tightest."""
    margin, slack_index = p.margin, p.slack_index
    used = np.zeros(len(margin), dtype=np.bool_)
    tight = np.empty(len(margin))
    count = 0
    for r in range(len(margin)):
        if slack_index[r] < 0:
            used[r] = min(margin[r], p.upper[r]) < _HARD
        elif margin[r] < _TIGHT:
            tight[count] = margin[r]
            count += 1
    limit = _TIGHT
    if count > _FIRST:
        limit = np.partition(tight[:count], _FIRST)[_FIRST]
    for r in range(len(margin)):
        if (slack_index[r] >= 0 and margin[r] < limit) or multipliers[p.row_id[r]] != 0.0:
            used[r] = True
    return used


class _Stacked(NamedTuple):
    """A program in DAQP's form, over z = (x, the slacks of the used rows)."""

    hessian: Floats
    gradient: Floats
    rows: Floats
    upper: Floats
    lower: Floats
    dual: Floats
    """Start of the multipliers."""
    used_rows: Integers
    """Indices of the used rows."""
    used_slacks: Integers
    """Indices of the used slacks."""


@njit(cache=True)
def _stacked(
    p: QuadraticProgram, used: Booleans, box: Floats, slack: Floats, rows: Floats
) -> _Stacked:
    """The program with the used rows; box, slack, rows: multipliers to start from."""
    n = len(p.gradient)
    used_rows = np.flatnonzero(used)
    # a column for each slack of a used row
    column = np.full(len(p.l1), -1, dtype=np.int64)
    for r in used_rows:
        if p.slack_index[r] >= 0:
            column[p.slack_index[r]] = 0
    used_slacks = np.flatnonzero(column == 0)
    size, count = n + len(used_slacks), len(used_rows)
    hessian, gradient = np.zeros((size, size)), np.empty(size)
    upper, lower = np.empty(size + count), np.empty(size + count)
    dual = np.empty(size + count)
    hessian[:n, :n] = p.hessian
    gradient[:n], upper[:n], lower[:n], dual[:n] = p.gradient, p.high, p.low, box
    for c in range(len(used_slacks)):
        g, at = used_slacks[c], n + c
        column[g] = at
        hessian[at, at] = p.l2[g]
        gradient[at], upper[at], lower[at], dual[at] = p.l1[g], _NO_BOUND, 0.0, slack[g]
    stacked = np.zeros((count, size))
    for i in range(count):
        r, at = used_rows[i], size + i
        stacked[i, :n] = p.jacobian[r]
        if p.slack_index[r] >= 0:
            stacked[i, column[p.slack_index[r]]] = 1.0
        upper[at], lower[at], dual[at] = p.upper[r], -p.margin[r], rows[p.row_id[r]]
    return _Stacked(hessian, gradient, stacked, upper, lower, dual, used_rows, used_slacks)


@njit(cache=True)
def _scattered(
    p: QuadraticProgram, s: _Stacked, z: Floats, multipliers: Floats
) -> tuple[Floats, Floats, Floats]:
    """(all slacks (s,), their multipliers, multipliers of the rows by id); 0 if not used."""
    slack, of_slack = np.zeros(len(p.l1)), np.zeros(len(p.l1))
    of_rows = np.zeros(p.num_row_ids)
    n = len(p.gradient)
    size = n + len(s.used_slacks)
    for c in range(len(s.used_slacks)):
        slack[s.used_slacks[c]], of_slack[s.used_slacks[c]] = z[n + c], multipliers[n + c]
    for i in range(len(s.used_rows)):
        of_rows[p.row_id[s.used_rows[i]]] = multipliers[size + i]
    return slack, of_slack, of_rows


@njit(cache=True)
def _add_violated(p: QuadraticProgram, x: Floats, slack: Floats, used: Booleans) -> bool:
    """Check the unused rows; if one is violated, add it to ``used``, and all nearly violated."""
    violated = False
    close = np.zeros(len(used), dtype=np.bool_)
    for r in range(len(p.margin)):
        if used[r]:
            continue
        change = 0.0
        for j in range(len(x)):
            change += p.jacobian[r, j] * x[j]
        if p.slack_index[r] >= 0:
            change += slack[p.slack_index[r]]
        left = min(change + p.margin[r], p.upper[r] - change)
        close[r] = left < _NEXT
        violated |= left < -_TOLERANCE
    if violated:
        used |= close
    return violated
