"""Quadratic programs of the SQP, solved by DAQP with rows that are added on demand.

Most rows of a crowded problem never become active: solve with the tightest, check the others, add
the violated ones, solve again. The result is that of the whole program.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.daqp_call import NO_BOUND, DaqpAddresses, solve_dense
from cohelm.control.solver_tables import SolverWorkspace
from cohelm.kernels import INNER, KERNEL, callee

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


@njit(**KERNEL)
def minimise(daqp: DaqpAddresses, w: SolverWorkspace, count: int) -> int:
    """Solve the program of ``count`` rows: DAQP's flag; the step is the beginning of z."""
    rows, multipliers = w.rows, w.program.of_rows
    tight = 0
    for r in range(count):
        rows.used[r] = False
        if rows.slack[r] < 0:
            rows.used[r] = min(rows.margin[r], rows.upper[r]) < _HARD
        elif rows.margin[r] < _TIGHT:
            rows.left[tight] = rows.margin[r]
            tight += 1
    limit = _TIGHT
    if tight > _FIRST:
        limit = _nth(rows.left[:tight], _FIRST)
    for r in range(count):
        if (rows.slack[r] >= 0 and rows.margin[r] < limit) or multipliers[rows.key[r]] != 0.0:
            rows.used[r] = True
    for rounds_left in range(_ROUNDS, -1, -1):
        flag = _solve_used(daqp, w, count)
        if flag < 1 or not _add_violated(w, count):
            return flag
        if rounds_left == 1:
            rows.used[:count] = True
    return 1


@callee(KERNEL)
def _nth(values: Floats, n: int) -> float:
    """The value with n smaller ones, by bisection: sorting is dear to compile."""
    low: float = values[0]
    high: float = values[0]
    for each in values:
        low, high = min(low, each), max(high, each)
    for _ in range(30):
        middle, smaller = 0.5 * (low + high), 0
        for each in values:
            smaller += each < middle
        if smaller > n:
            high = middle
        else:
            low = middle
    return low


@callee(KERNEL)
def _solve_used(daqp: DaqpAddresses, w: SolverWorkspace, count: int) -> int:
    """Solve with the used rows only: DAQP's flag."""
    p = w.program
    n, num_slacks = _choose(w, count)
    size = p.gradient.shape[0] + num_slacks
    whole = p.whole[: size * size].reshape((size, size))
    stacked = p.rows[: n * size].reshape((n, size))
    _fill_objective(w, num_slacks, whole)
    _fill_rows(w, n, stacked)
    total = size + n
    flag = solve_dense(
        daqp, w.daqp, whole, p.slope[:size], stacked, p.upper[:total], p.lower[:total],
        p.dual[:total], p.z, p.multipliers,
    )  # fmt: skip
    if flag < 1 or not _finite(p.z[:size]):
        return min(flag, 0)
    _keep_solution(w, n, num_slacks)
    return flag


@callee(INNER)
def _choose(w: SolverWorkspace, count: int) -> tuple[int, int]:
    """Numbers of used rows and of their slacks, which get a column each."""
    rows, p = w.rows, w.program
    p.column[:] = -1
    n = 0
    for r in range(count):
        if rows.used[r]:
            rows.chosen[n] = r
            n += 1
            if rows.slack[r] >= 0:
                p.column[rows.slack[r]] = 0
    num_slacks = 0
    for s in range(p.column.shape[0]):
        if p.column[s] == 0:
            p.slacks[num_slacks] = s
            p.column[s] = p.gradient.shape[0] + num_slacks
            num_slacks += 1
    return n, num_slacks


@callee(INNER)
def _fill_objective(w: SolverWorkspace, num_slacks: int, whole: Floats) -> None:
    """Fill the Hessian ``whole``, the gradient and the bounds of inputs and slacks."""
    p = w.program
    x = p.gradient.shape[0]
    whole[:] = 0.0
    for i in range(x):
        for j in range(x):
            whole[i, j] = p.hessian[i, j]
        p.slope[i], p.upper[i], p.lower[i] = p.gradient[i], p.high[i], p.low[i]
        p.dual[i] = p.of_inputs[i]
    for c in range(num_slacks):
        s, at = p.slacks[c], x + c
        whole[at, at] = p.l2[s]
        p.slope[at], p.upper[at], p.lower[at], p.dual[at] = p.l1[s], NO_BOUND, 0.0, p.of_slacks[s]


@callee(INNER)
def _fill_rows(w: SolverWorkspace, n: int, stacked: Floats) -> None:
    """Fill the ``n`` used rows with their bounds."""
    rows, p = w.rows, w.program
    x, size = p.gradient.shape[0], stacked.shape[1]
    for i in range(n):
        r, at = rows.chosen[i], size + i
        for j in range(x):
            stacked[i, j] = rows.jacobian[r, j]
        for j in range(x, size):
            stacked[i, j] = 0.0
        if rows.slack[r] >= 0:
            stacked[i, p.column[rows.slack[r]]] = 1.0
        p.upper[at], p.lower[at] = rows.upper[r], -rows.margin[r]
        p.dual[at] = p.of_rows[rows.key[r]]


@callee(INNER)
def _keep_solution(w: SolverWorkspace, n: int, num_slacks: int) -> None:
    """Keep slacks and multipliers, also for a warm start; those of unused rows are 0."""
    rows, p = w.rows, w.program
    x = p.gradient.shape[0]
    p.slack[:] = 0.0
    p.of_slacks[:] = 0.0
    p.of_rows[:] = 0.0
    for i in range(x):
        p.of_inputs[i] = p.multipliers[i]
    for c in range(num_slacks):
        s = p.slacks[c]
        p.slack[s], p.of_slacks[s] = p.z[x + c], p.multipliers[x + c]
    for i in range(n):
        p.of_rows[rows.key[rows.chosen[i]]] = p.multipliers[x + num_slacks + i]


@callee(KERNEL)
def _finite(values: Floats) -> bool:
    total = 0.0
    for each in values:
        total += abs(each)
    return bool(np.isfinite(total))


@callee(KERNEL)
def _add_violated(w: SolverWorkspace, count: int) -> bool:
    """Check the unused rows; if one is violated, use it, and all that are nearly violated."""
    rows, p = w.rows, w.program
    violated = False
    for r in range(count):
        if rows.used[r]:
            continue
        change = 0.0
        for j in range(p.gradient.shape[0]):
            change += rows.jacobian[r, j] * p.z[j]
        if rows.slack[r] >= 0:
            change += p.slack[rows.slack[r]]
        rows.left[r] = min(change + rows.margin[r], rows.upper[r] - change)
        violated |= rows.left[r] < -_TOLERANCE
    for r in range(count if violated else 0):
        if not rows.used[r] and rows.left[r] < _NEXT:
            rows.used[r] = True
    return violated
