"""Terms of one's own: one residual function, which sampler, SQP, choice and report all obey.

A term is a class with a ``name``, a ``residual`` made by :func:`residual`, and ``table``:

    @residual
    def right_of_path(p, z):
        return p[0] * (z[D] + p[1])

    class KeepRight:
        name = "keep_right"
        residual = right_of_path

        def table(self, problem):
            return np.array([0.5, 0.4])

Its cost is Δt·r² per step, in seconds. The derivatives are central differences, so r should be
continuous; ``p`` are the numbers of ``table``, made once a tick, ``z`` the state by the names
below. ``examples/06_keep_right.py`` is a complete one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np
from llvmlite import ir
from numba import cfunc, types
from numba.extending import intrinsic

from cohelm.arrays import Floats, Integers
from cohelm.control.api import LocalProblem
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel, Stage, add_square
from cohelm.errors import ConfigError, ControlError
from cohelm.kernels import KERNEL, callee

TIME, X, Y, HEADING, SPEED, TURN, S, D, TANGENT = range(9)
"""Entries of ``z``: time ahead, s; pose in the map frame; speed, m/s; turn rate, rad/s; arc length
and distance to the left on the path, m; direction of the path there, rad."""
_SIZE = 9
_NUDGE = 1e-4
"""Step of the differences, m, rad, m/s and rad/s."""
_NUMBERS: Any = types.CPointer(types.float64)
_SIGNATURE = types.float64(_NUMBERS, _NUMBERS)


def residual(function: Callable[[Any, Any], float]) -> Any:
    """Compile the residual r(p, z) of a term; p and z are indexed like arrays."""
    return cfunc(_SIGNATURE)(function)


class ExtraTerm(Protocol):
    """A cost term of one's own."""

    name: str
    residual: Any
    """Made by :func:`residual`."""

    def table(self, problem: LocalProblem) -> Floats:
        """Numbers for the residual, (w,), made once a tick."""
        ...


class ExtraTable(NamedTuple):
    """All terms of one's own in a problem."""

    address: Integers
    """(q,) of the residuals."""
    parameters: Floats
    """(q, w) numbers of each, filled up with zeros."""
    step: float
    """s."""
    state: Floats
    """(9,) space for z: a kernel owns no array."""
    slope: Floats
    """(5,) space for the derivatives of a residual."""


def checked_terms(terms: Sequence[ExtraTerm], taken: Sequence[str]) -> tuple[ExtraTerm, ...]:
    """Terms of one's own, each with a name that is not ``taken`` and a compiled residual.

    Raises:
        ConfigError: otherwise.
    """
    if not isinstance(terms, Sequence):
        raise ConfigError(f"extra_terms: a list of terms, not {terms!r}")
    names = list(taken)
    for term in terms:
        name = getattr(term, "name", None)
        if isinstance(term, type) or not isinstance(name, str):
            raise ConfigError(f"extra_terms: {term!r} is no instance of a term with a name")
        if name in names:
            raise ConfigError(f"extra_terms: there is another term of the name {name!r}")
        if not hasattr(getattr(term, "residual", None), "address"):
            raise ConfigError(f"extra_terms: the residual of {name!r} is not made by @residual")
        names.append(name)
    return tuple(terms)


def extra_table(terms: Sequence[ExtraTerm], problem: LocalProblem, scene: Scene) -> ExtraTable:
    """The table of some terms.

    Raises:
        ControlError: Numbers of a term are not finite.
    """
    numbers = [np.asarray(term.table(problem), dtype=float).ravel() for term in terms]
    width = max([1, *map(len, numbers)])
    parameters = np.zeros((len(terms), width))
    for row, given in zip(parameters, numbers, strict=True):
        row[: len(given)] = given
    if not np.isfinite(parameters).all():
        wrong = int(np.argmin(np.isfinite(parameters).all(axis=1)))
        raise ControlError(f"the table of the term {terms[wrong].name!r} is not of finite numbers")
    address = np.array([term.residual.address for term in terms], dtype=np.int64)
    return ExtraTable(address, parameters, scene.step, np.empty(_SIZE), np.empty(5))


def _call_residual(typing_context: Any, address: Any, p: Any, z: Any) -> Any:
    """Call a residual by the addresses of it and of its arguments."""
    signature = types.float64(types.int64, types.int64, types.int64)

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.DoubleType().as_pointer()
        kind = ir.FunctionType(ir.DoubleType(), [pointer, pointer])
        function = builder.inttoptr(arguments[0], kind.as_pointer())
        return builder.call(function, [builder.inttoptr(a, pointer) for a in arguments[1:]])

    return signature, generate


_call: Any = intrinsic(_call_residual)
"""Without the typing context, which numba passes."""


@callee(KERNEL)
def _fill(z: Floats, time: float, stage: Stage, turn: float, tangent: float) -> None:
    z[TIME], z[X], z[Y], z[HEADING] = time, stage.x, stage.y, stage.heading
    z[SPEED], z[TURN], z[S], z[D], z[TANGENT] = stage.speed, turn, stage.s, stage.d, tangent


@callee(KERNEL)
def cost(t: ExtraTable, stage: Stage, turn: float, tangent: float, by_term: Floats) -> float:
    """Cost of a stage, s; also added to ``by_term`` (q,)."""
    total, z = 0.0, t.state
    _fill(z, stage.k * t.step, stage, turn, tangent)
    for j in range(t.address.shape[0]):
        r: float = _call(t.address[j], t.parameters[j].ctypes.data, z.ctypes.data)
        by_term[j] += t.step * r * r
        total += t.step * r * r
    return total


@callee(KERNEL)
def model(
    t: ExtraTable, stage: Stage, u: Floats, n_linear: int, tangent: float, q: LocalModel
) -> None:
    """Add the model of the stage that the inputs ``u`` (m,) led to."""
    z, slope, last = t.state, t.slope, u.shape[0] - 1
    turn = u[last]
    cos, sin = math.cos(tangent), math.sin(tangent)
    for j in range(t.address.shape[0]):
        p = t.parameters[j].ctypes.data
        slope[:] = 0.0
        for a in range(5):
            for side in (-0.5, 0.5):
                _fill(z, stage.k * t.step, stage, turn, tangent)
                change = side * _NUDGE
                if a < 2:  # the arc length and the distance move with the position
                    z[X + a] += change
                    z[S] += change * (cos if a == 0 else sin)
                    z[D] += change * (-sin if a == 0 else cos)
                else:
                    z[X + a] += change
                slope[a] += (
                    math.copysign(1.0, side) * _call(t.address[j], p, z.ctypes.data) / _NUDGE
                )
        _fill(z, stage.k * t.step, stage, turn, tangent)
        r: float = _call(t.address[j], p, z.ctypes.data)
        add_square(q, stage.k, t.step, r, slope[0], slope[1], slope[2])
        for a in range(n_linear):  # ∂‖v‖/∂v_a; a robot that stands gains speed forward
            share = u[a] / stage.speed if stage.speed > 0.0 else (1.0 if a == 0 else 0.0)
            q.input_gradient[stage.k - 1, a] += 2.0 * t.step * r * share * slope[3]
            q.input_curvature[stage.k - 1, a] += 2.0 * t.step * share * share * slope[3] * slope[3]
        q.input_gradient[stage.k - 1, last] += 2.0 * t.step * r * slope[4]
        q.input_curvature[stage.k - 1, last] += 2.0 * t.step * slope[4] * slope[4]
