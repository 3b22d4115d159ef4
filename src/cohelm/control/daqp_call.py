"""DAQP (Arnström et al. 2022), a dual active-set solver, called by address from compiled code.

Its Python interface costs more than a solve. The C interface is part of the same wheel: functions
``daqp_quadprog`` and ``daqp_dual_init_active`` and the structures of its ``api.h``, which
:func:`daqp_addresses` verifies on a small program before anything relies on them.
"""

from __future__ import annotations

import ctypes
import functools
from typing import Any, NamedTuple

import daqp
import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic
from numpy.typing import NDArray

from cohelm.arrays import Floats, Integers
from cohelm.errors import SolverFailed
from cohelm.kernels import KERNEL

_SETTINGS = 256
"""Bytes for DAQP's settings, more than it needs."""
NO_BOUND = 1e30
"""Infinity for DAQP."""


class DaqpAddresses(NamedTuple):
    """DAQP for compiled code."""

    quadprog: int
    dual_init: int
    settings: NDArray[np.uint8]


class DaqpArrays(NamedTuple):
    """DAQP's problem and result, which hold the addresses of the program's arrays."""

    problem: Integers
    """(11,)."""
    result: Integers
    """(8,)."""
    sense: NDArray[np.int32]
    """(b + r,) 0: all rows are inequalities."""


def daqp_arrays(rows: int) -> DaqpArrays:
    """Arrays for programs of at most ``rows`` rows, bounds included."""
    return DaqpArrays(np.zeros(11, np.int64), np.zeros(8, np.int64), np.zeros(rows, np.int32))


def _call_c(typing_context: Any, function: Any, first: Any, second: Any, third: Any) -> Any:
    """Call a C function with three pointers."""
    signature = types.void(types.int64, types.int64, types.int64, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [pointer] * 3)
        address = builder.inttoptr(arguments[0], kind.as_pointer())
        builder.call(address, [builder.inttoptr(each, pointer) for each in arguments[1:]])
        return context.get_dummy_value()

    return signature, generate


_call: Any = intrinsic(_call_c)
"""Without the typing context, which numba passes."""


@njit(**KERNEL)
def solve_dense(
    daqp: DaqpAddresses,
    arrays: DaqpArrays,
    hessian: Floats,
    gradient: Floats,
    rows: Floats,
    upper: Floats,
    lower: Floats,
    dual: Floats,
    x: Floats,
    multipliers: Floats,
) -> int:
    """Minimise ½ xᵀHx + fᵀx with lower ≤ (x, A x) ≤ upper; DAQP's exit flag, ≥ 1 if it succeeds.

    Args:
        daqp: the solver.
        arrays: workspace.
        hessian: H, (b, b).
        gradient: f, (b,).
        rows: A, (r, b).
        upper, lower: (b + r,).
        dual: (b + r,) multipliers of a similar program.
        x: (b,), filled.
        multipliers: (b + r,), filled.
    """
    problem, result, size = arrays.problem, arrays.result, gradient.shape[0]
    total = size + rows.shape[0]
    arrays.sense[:total] = 0
    problem[0], problem[1] = size | (total << 32), size
    problem[2], problem[3] = hessian.ctypes.data, gradient.ctypes.data
    problem[4] = rows.ctypes.data
    problem[5], problem[6] = upper.ctypes.data, lower.ctypes.data
    problem[7], problem[8], problem[9] = arrays.sense.ctypes.data, 0, 0
    result[0], result[1] = x.ctypes.data, multipliers.ctypes.data
    _call(daqp.dual_init, problem.ctypes.data, dual.ctypes.data, 0)
    _call(daqp.quadprog, result.ctypes.data, problem.ctypes.data, daqp.settings.ctypes.data)
    return int(result.view(np.int32)[8])


@functools.cache
def daqp_addresses() -> DaqpAddresses:
    """DAQP's functions, after a small program has shown that they work as expected.

    Raises:
        SolverFailed: with another version of DAQP than expected.
    """
    library = ctypes.CDLL(daqp.__file__)
    settings = np.zeros(_SETTINGS, np.uint8)
    library.daqp_default_settings(ctypes.c_void_p(settings.ctypes.data))
    quadprog, dual_init = (
        int(ctypes.cast(getattr(library, name), ctypes.c_void_p).value or 0)
        for name in ("daqp_quadprog", "daqp_dual_init_active")
    )
    found = DaqpAddresses(quadprog, dual_init, settings)
    x, multipliers, dual = np.zeros(2), np.zeros(3), np.zeros(3)
    flag = solve_dense(
        found, daqp_arrays(3), np.eye(2), np.array([-2.0, 0.0]), np.array([[1.0, 1.0]]),
        np.array([1.5, 9.0, 1.0]), np.full(3, -9.0), dual, x, multipliers,
    )  # fmt: skip
    if flag < 1 or not np.allclose(x, [1.5, -0.5]):
        raise SolverFailed(f"DAQP {daqp.__version__} does not solve as expected")
    return found
