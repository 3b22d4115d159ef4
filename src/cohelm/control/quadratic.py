"""The quadratic program, handed to DAQP (Arnström et al. 2022), a dual active-set solver.

Most rows of a crowded problem never become active, so they are brought in as they are needed: solve
with the tightest, look which of the others are violated, add those, solve again. The result is
that of the whole program.
"""

from __future__ import annotations

from dataclasses import dataclass

import daqp
import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape
from cohelm.errors import SolverFailed

_NO_BOUND = 1e30
"""What DAQP takes for infinite."""
_FIRST, _TIGHT = 48, 0.05
"""At first: at most about so many soft rows, and only with a margin below this, m."""
_TOLERANCE = 1e-7
"""A row violated by more than this is brought in."""
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
    used = _first_rows(program)
    used |= start.rows[program.key] != 0.0
    for _ in range(_ROUNDS):
        x, slack, start = _solve(program, np.flatnonzero(used), start)
        missing = _violated(program, x, slack) & ~used
        if not missing.any():
            return x, start
        used |= missing
    x, _, start = _solve(program, np.arange(len(program.margin)), start)
    return x, start


def _first_rows(program: QuadraticProgram) -> Booleans:
    """The hard rows, and the soft ones with the least margin."""
    soft = program.group >= 0
    used: Booleans = ~soft
    count = int(soft.sum())
    if count > _FIRST:
        limit = np.partition(program.margin[soft], _FIRST)[_FIRST]
        used |= soft & (program.margin <= min(limit, _TIGHT))
    else:
        used |= soft & (program.margin <= _TIGHT)
    return used


def _violated(program: QuadraticProgram, x: Floats, slack: Floats) -> Booleans:
    value_ = program.jacobian @ x + program.margin
    soft = program.group >= 0
    value_[soft] += slack[program.group[soft]]
    out: Booleans = value_ < -_TOLERANCE
    return out


def _solve(
    program: QuadraticProgram, rows: Integers, start: Multipliers
) -> tuple[Floats, Floats, Multipliers]:
    """(x, slack of every group, multipliers) with some of the rows only."""
    n = len(program.gradient)
    group, key = program.group[rows], program.key[rows]
    soft = np.flatnonzero(group >= 0)
    present = np.zeros(len(program.l1), dtype=bool)
    present[group[soft]] = True
    groups = np.flatnonzero(present)
    column = np.cumsum(present) - 1
    size = n + len(groups)
    hessian = np.zeros((size, size))
    hessian[:n, :n] = program.hessian
    diagonal = np.arange(n, size)
    hessian[diagonal, diagonal] = program.l2[groups]
    stacked = np.zeros((len(rows), size))
    stacked[:, :n] = program.jacobian[rows]
    stacked[soft, n + column[group[soft]]] = 1.0
    z, _, flag, info = daqp.solve(
        hessian,
        np.concatenate([program.gradient, program.l1[groups]]),
        stacked,
        np.concatenate([program.high, np.full(len(groups), _NO_BOUND), program.room[rows]]),
        np.concatenate([program.low, np.zeros(len(groups)), -program.margin[rows]]),
        np.zeros(size + len(rows), dtype=np.int32),
        dual_start=np.concatenate([start.box, start.slack[groups], start.rows[key]]),
    )
    if flag < 1 or not np.isfinite(z).all():
        raise SolverFailed(f"the quadratic program has no solution (exit flag {flag})")
    slack, multipliers = np.zeros(len(program.l1)), Multipliers.none(program)
    slack[groups] = z[n:]
    found = info["lam"]
    multipliers.box = found[:n]
    multipliers.slack[groups] = found[n:size]
    multipliers.rows[key] = found[size:]
    return np.asarray(z[:n], dtype=float), slack, multipliers
