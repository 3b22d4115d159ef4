"""Inputs made to obey limits on speed and change, for any motion model."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats


def slowed(inputs: Floats, speed: float, translating: int) -> Floats:
    """Inputs (..., m) with the velocity over the floor shortened to ``speed``, its course kept."""
    inputs = np.array(inputs, dtype=float)
    velocity = inputs[..., :translating]
    norm = np.linalg.norm(velocity, axis=-1, keepdims=True)
    velocity *= np.minimum(1.0, speed / np.maximum(norm, 1e-12))
    return inputs


@njit(cache=True)
def within_limits(  # noqa: PLR0917  # a kernel takes plain arrays
    inputs: Floats,
    now: Floats,
    low: Floats,
    high: Floats,
    rise: Floats,
    fall: Floats,
    translating: int,
    speed: float,
) -> Floats:
    """The inputs (N, m) that follow the wanted ones as fast as the limits let them.

    Velocities over the floor with two components change along a straight line from one to the next:
    each component by itself could make the speed greater than it is at either end.

    Args:
        inputs: (N, m), wanted.
        now: (m,), what the wheels do.
        low, high: (m,) of every input.
        rise, fall: (N, m) or (1, m), greatest change at each step; the last row goes on.
        translating: as ``Kinematics.translating``.
        speed: greatest norm of those, m/s; who is faster now comes back to it.
    """
    steps, m = inputs.shape
    joint = translating if translating > 1 else 0
    out = np.empty_like(inputs)
    before, wanted = now.astype(np.float64), np.empty(m)
    for k in range(steps):
        up, down = rise[min(k, rise.shape[0] - 1)], fall[min(k, fall.shape[0] - 1)]
        square = 0.0
        for i in range(m):
            wanted[i] = min(max(inputs[k, i], low[i]), high[i])
            if i < joint:
                square += wanted[i] * wanted[i]
        shorter = min(1.0, speed / math.sqrt(square)) if square > 0.0 else 1.0
        share = 1.0
        for i in range(joint):
            wanted[i] *= shorter
            change = wanted[i] - before[i]
            most = up[i] if change > 0.0 else down[i]
            if abs(change) > most:
                share = min(share, most / abs(change))
        for i in range(m):
            if i < joint:
                before[i] += share * (wanted[i] - before[i])
            else:
                before[i] = min(max(wanted[i], before[i] - down[i]), before[i] + up[i])
            out[k, i] = before[i]
    return out
