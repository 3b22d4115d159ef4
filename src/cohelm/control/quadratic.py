"""The quadratic program, handed to DAQP (Arnström et al. 2022), a dual active-set solver.

Most rows of a crowded problem never become active, so they are brought in as they are needed: solve
with the tightest, look which of the others are violated, add those, solve again. The result is
that of the whole program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import daqp
import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape
from cohelm.errors import SolverFailed

_NO_BOUND = 1e30
"""What DAQP takes for infinite."""
_FIRST, _TIGHT = 96, 0.05
"""At first: at most so many soft rows, and only with a margin below this, m."""
_HARD = 0.15
"""At first: only hard rows that are nearer than this to a bound."""
_TOLERANCE = 1e-7
"""A row violated by more than this is brought in."""
_NEXT = 0.02
"""Where a row is brought in, those within this of being violated come with it."""
_ROUNDS = 12
"""Of bringing rows in; then all are taken at once."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class QuadraticProgram:
    """min ½ xᵀHx + fᵀx + Σ l1·s + ½ l2·s²  s.t.  −margin ≤ G x + s[group] ≤ room, box, s ≥ 0.

    A hard row (group −1) has no s.
    """

    hessian: Annotated[Floats, Shape("x x")]
    """H, positive definite."""
    gradient: Annotated[Floats, Shape("x")]
    """f."""
    low: Annotated[Floats, Shape("x")]
    high: Annotated[Floats, Shape("x")]
    jacobian: Annotated[Floats, Shape("r x")]
    """G."""
    margin: Annotated[Floats, Shape("r")]
    room: Annotated[Floats, Shape("r")]
    group: Annotated[Integers, Shape("r")]
    key: Annotated[Integers, Shape("r")]
    """Names each row, the same from program to program."""
    keys: int
    """How many names there are."""
    l1: Annotated[Floats, Shape("s")]
    l2: Annotated[Floats, Shape("s")]


@dataclass(slots=True, eq=False)
class Multipliers:
    """Lagrange multipliers of the last program: where the next one, much like it, starts."""

    box: Floats
    slack: Floats
    rows: Floats
    """By key, see ``QuadraticProgram.key``."""

    @staticmethod
    def none(program: QuadraticProgram) -> Multipliers:
        """Nothing binds."""
        return Multipliers(
            np.zeros(len(program.gradient)), np.zeros(len(program.l1)), np.zeros(program.keys)
        )


def minimise(program: QuadraticProgram, start: Multipliers) -> tuple[Floats, Multipliers]:
    """(the minimising x, its multipliers).

    Raises:
        SolverFailed: if there is no solution, or it is not finite.
    """
    p = program
    used = _first_rows(p.margin, p.room, p.group, p.key, start.rows)
    for left in reversed(range(_ROUNDS + 1)):
        x, slack, start = _solve(program, used, start)
        if not _bring_in(p.jacobian, p.margin, p.room, p.group, x, slack, used):
            break
        if left == 1:
            used[:] = True
    return x, start


def _solve(
    program: QuadraticProgram, used: Booleans, start: Multipliers
) -> tuple[Floats, Floats, Multipliers]:
    """(x, slack of every group, multipliers) with some of the rows only."""
    p = program
    hessian, gradient, stacked, high, low, dual, rows, groups = _stacked(
        p.hessian,
        p.gradient,
        p.low,
        p.high,
        p.jacobian,
        p.margin,
        p.room,
        p.group,
        p.key,
        p.l1,
        p.l2,
        used,
        start.box,
        start.slack,
        start.rows,
    )
    z, _, flag, info = daqp.solve(
        hessian, gradient, stacked, high, low, np.zeros(len(high), dtype=np.int32), dual_start=dual
    )
    if flag < 1 or not math.isfinite(z @ z):
        raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
    n, found = len(p.gradient), info["lam"]
    slack, yielding, binding = _scattered(z, found, n, groups, rows, p.key, len(p.l1), p.keys)
    return z[:n], slack, Multipliers(found[:n], yielding, binding)


@njit(cache=True)
def _first_rows(
    margin: Floats, room: Floats, group: Integers, key: Integers, multipliers: Floats
) -> Booleans:
    """Those that bound the last program, and those with little margin; soft ones the tightest."""
    used = np.zeros(len(margin), dtype=np.bool_)
    tight = np.empty(len(margin))
    count = 0
    for r in range(len(margin)):
        if group[r] < 0:
            used[r] = min(margin[r], room[r]) < _HARD
        elif margin[r] < _TIGHT:
            tight[count] = margin[r]
            count += 1
    limit = _TIGHT
    if count > _FIRST:
        limit = np.partition(tight[:count], _FIRST)[_FIRST]
    for r in range(len(margin)):
        if (group[r] >= 0 and margin[r] < limit) or multipliers[key[r]] != 0.0:
            used[r] = True
    return used


@njit(cache=True)
def _stacked(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    hessian: Floats,
    gradient: Floats,
    low: Floats,
    high: Floats,
    jacobian: Floats,
    margin: Floats,
    room: Floats,
    group: Integers,
    key: Integers,
    l1: Floats,
    l2: Floats,
    used: Booleans,
    box_start: Floats,
    slack_start: Floats,
    row_start: Floats,
) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats, Integers, Integers]:
    """(H, f, A, upper, lower, dual start) over x and the slacks of the used rows; rows, groups."""
    n = len(gradient)
    rows = np.flatnonzero(used)
    column = np.full(len(l1), -1, dtype=np.int64)
    for r in rows:
        if group[r] >= 0:
            column[group[r]] = 0
    groups = np.flatnonzero(column == 0)
    size, count = n + len(groups), len(rows)
    whole, slope = np.zeros((size, size)), np.empty(size)
    upper, lower = np.empty(size + count), np.empty(size + count)
    dual = np.empty(size + count)
    whole[:n, :n] = hessian
    slope[:n], upper[:n], lower[:n], dual[:n] = gradient, high, low, box_start
    for c in range(len(groups)):
        g, at = groups[c], n + c
        column[g] = at
        whole[at, at] = l2[g]
        slope[at], upper[at], lower[at], dual[at] = l1[g], _NO_BOUND, 0.0, slack_start[g]
    stacked = np.zeros((count, size))
    for i in range(count):
        r, at = rows[i], size + i
        stacked[i, :n] = jacobian[r]
        if group[r] >= 0:
            stacked[i, column[group[r]]] = 1.0
        upper[at], lower[at], dual[at] = room[r], -margin[r], row_start[key[r]]
    return whole, slope, stacked, upper, lower, dual, rows, groups


@njit(cache=True)
def _scattered(  # noqa: PLR0917  # a kernel takes plain arrays
    z: Floats,
    multipliers: Floats,
    n: int,
    groups: Integers,
    rows: Integers,
    key: Integers,
    slacks: int,
    keys: int,
) -> tuple[Floats, Floats, Floats]:
    """(slack of every group, its multiplier, multipliers of the rows by key); 0 where not used."""
    slack, yielding, binding = np.zeros(slacks), np.zeros(slacks), np.zeros(keys)
    size = n + len(groups)
    for c in range(len(groups)):
        slack[groups[c]], yielding[groups[c]] = z[n + c], multipliers[n + c]
    for i in range(len(rows)):
        binding[key[rows[i]]] = multipliers[size + i]
    return slack, yielding, binding


@njit(cache=True)
def _bring_in(  # noqa: PLR0917  # a kernel takes plain arrays
    jacobian: Floats,
    margin: Floats,
    room: Floats,
    group: Integers,
    x: Floats,
    slack: Floats,
    used: Booleans,
) -> bool:
    """Whether a row that is not used is violated; such rows are used from now on."""
    found = False
    close = np.zeros(len(used), dtype=np.bool_)
    for r in range(len(margin)):
        if used[r]:
            continue
        change = 0.0
        for j in range(len(x)):
            change += jacobian[r, j] * x[j]
        if group[r] >= 0:
            change += slack[group[r]]
        left = min(change + margin[r], room[r] - change)
        close[r] = left < _NEXT
        found |= left < -_TOLERANCE
    if found:
        used |= close
    return found
