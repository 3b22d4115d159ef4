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
    """min ½ xᵀHx + fᵀx + Σ l1·s + ½ l2·s²  s.t.  −margin ≤ G x + s[group] ≤ upper, box, s ≥ 0.

    A hard row (group −1) has no s.
    """

    hessian: Floats
    """H, (x, x), positive definite."""
    gradient: Floats
    """f, (x,)."""
    low: Floats
    """(x,); so is the next."""
    high: Floats
    jacobian: Floats
    """G, (r, x)."""
    margin: Floats
    """(r,); so are the next three."""
    upper: Floats
    group: Integers
    key: Integers
    """Identifier of each row, the same from program to program."""
    keys: int
    """Number of identifiers."""
    l1: Floats
    """(s,); so is the next."""
    l2: Floats


@dataclass(slots=True, eq=False)
class Multipliers:
    """Lagrange multipliers of a program, from which the next, similar one starts."""

    box: Floats
    slack: Floats
    rows: Floats
    """By key, see ``QuadraticProgram.key``."""

    @staticmethod
    def none(program: QuadraticProgram) -> Multipliers:
        """No row is active."""
        return Multipliers(
            np.zeros(len(program.gradient)), np.zeros(len(program.l1)), np.zeros(program.keys)
        )


def minimise(program: QuadraticProgram, start: Multipliers) -> tuple[Floats, Multipliers]:
    """Solve a program: (the minimiser x, its multipliers).

    Raises:
        SolverFailed: if there is no solution, or it is not finite.
    """
    used = _first_rows(program, start.rows)
    for left in reversed(range(_ROUNDS + 1)):
        x, slack, start = _solve(program, used, start)
        if not _add_violated(program, x, slack, used):
            break
        if left == 1:
            used[:] = True
    return x, start


def _solve(
    program: QuadraticProgram, used: Booleans, start: Multipliers
) -> tuple[Floats, Floats, Multipliers]:
    """(x, slack of every group, multipliers) with the used rows only."""
    s = _stacked(program, used, start.box, start.slack, start.rows)
    free = np.zeros(len(s.upper), dtype=np.int32)
    z, _, flag, info = daqp.solve(
        s.hessian, s.gradient, s.rows, s.upper, s.lower, free, dual_start=s.dual
    )
    if flag < 1 or not math.isfinite(z @ z):
        raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
    n, found = len(program.gradient), info["lam"]
    slack, yielding, binding = _scattered(program, s, z, found)
    return z[:n], slack, Multipliers(found[:n], yielding, binding)


@njit(cache=True)
def _first_rows(p: QuadraticProgram, multipliers: Floats) -> Booleans:
    """Rows active in the last program, and those with small margins; of soft ones the tightest."""
    margin, group = p.margin, p.group
    used = np.zeros(len(margin), dtype=np.bool_)
    tight = np.empty(len(margin))
    count = 0
    for r in range(len(margin)):
        if group[r] < 0:
            used[r] = min(margin[r], p.upper[r]) < _HARD
        elif margin[r] < _TIGHT:
            tight[count] = margin[r]
            count += 1
    limit = _TIGHT
    if count > _FIRST:
        limit = np.partition(tight[:count], _FIRST)[_FIRST]
    for r in range(len(margin)):
        if (group[r] >= 0 and margin[r] < limit) or multipliers[p.key[r]] != 0.0:
            used[r] = True
    return used


class _Stacked(NamedTuple):
    """A program in DAQP's form, over x and the slacks of the used rows."""

    hessian: Floats
    gradient: Floats
    rows: Floats
    upper: Floats
    lower: Floats
    dual: Floats
    """Start of the multipliers."""
    which: Integers
    """Indices of the used rows."""
    groups: Integers
    """Indices of the used slacks."""


@njit(cache=True)
def _stacked(
    p: QuadraticProgram, used: Booleans, box: Floats, slack: Floats, rows: Floats
) -> _Stacked:
    """The program with the used rows; box, slack, rows: multipliers to start from."""
    n = len(p.gradient)
    which = np.flatnonzero(used)
    # a column for each slack of a used row
    column = np.full(len(p.l1), -1, dtype=np.int64)
    for r in which:
        if p.group[r] >= 0:
            column[p.group[r]] = 0
    groups = np.flatnonzero(column == 0)
    size, count = n + len(groups), len(which)
    hessian, gradient = np.zeros((size, size)), np.empty(size)
    upper, lower = np.empty(size + count), np.empty(size + count)
    dual = np.empty(size + count)
    hessian[:n, :n] = p.hessian
    gradient[:n], upper[:n], lower[:n], dual[:n] = p.gradient, p.high, p.low, box
    for c in range(len(groups)):
        g, at = groups[c], n + c
        column[g] = at
        hessian[at, at] = p.l2[g]
        gradient[at], upper[at], lower[at], dual[at] = p.l1[g], _NO_BOUND, 0.0, slack[g]
    stacked = np.zeros((count, size))
    for i in range(count):
        r, at = which[i], size + i
        stacked[i, :n] = p.jacobian[r]
        if p.group[r] >= 0:
            stacked[i, column[p.group[r]]] = 1.0
        upper[at], lower[at], dual[at] = p.upper[r], -p.margin[r], rows[p.key[r]]
    return _Stacked(hessian, gradient, stacked, upper, lower, dual, which, groups)


@njit(cache=True)
def _scattered(
    p: QuadraticProgram, s: _Stacked, z: Floats, multipliers: Floats
) -> tuple[Floats, Floats, Floats]:
    """(slack of every group, its multiplier, multipliers of the rows by key); 0 if not used."""
    slack, yielding, binding = np.zeros(len(p.l1)), np.zeros(len(p.l1)), np.zeros(p.keys)
    n = len(p.gradient)
    size = n + len(s.groups)
    for c in range(len(s.groups)):
        slack[s.groups[c]], yielding[s.groups[c]] = z[n + c], multipliers[n + c]
    for i in range(len(s.which)):
        binding[p.key[s.which[i]]] = multipliers[size + i]
    return slack, yielding, binding


@njit(cache=True)
def _add_violated(p: QuadraticProgram, x: Floats, slack: Floats, used: Booleans) -> bool:
    """Check the unused rows for violations; use such rows, and those near, from now on."""
    found = False
    close = np.zeros(len(used), dtype=np.bool_)
    for r in range(len(p.margin)):
        if used[r]:
            continue
        change = 0.0
        for j in range(len(x)):
            change += p.jacobian[r, j] * x[j]
        if p.group[r] >= 0:
            change += slack[p.group[r]]
        left = min(change + p.margin[r], p.upper[r] - change)
        close[r] = left < _NEXT
        found |= left < -_TOLERANCE
    if found:
        used |= close
    return found
