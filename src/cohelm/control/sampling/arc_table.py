"""Table of sampled arcs: three segments each, the same for every decision.

A row is (speed, turn) of each segment, the ends of the first two, and the beginning of the return
to the path. Speeds are shares of the highest speed, turns of the highest turn rate, times of the
horizon. For a holonomic robot a turn of ±1 is the direction ±π from that of the path at its start.

The table is seeded and closed under mirroring, so a mirrored world gives the mirrored command.
"""

from __future__ import annotations

import functools

import numpy as np

from cohelm.arrays import Floats, read_only

SPEED_3, END_1, END_2, RETURN = 4, 6, 7, 8
"""Columns: speed of the third segment, ends of the first two, beginning of the return."""
NEVER = 2.0
"""A beginning of the return beyond the horizon: the arc does not return to the path."""
_SEED = 7
_LEFT_TO_RIGHT = np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0, 1.0, 1.0])
"""Signs of a row under mirroring."""
NO_PERTURBATION = np.array([0.0] * 6 + [0.2, 0.5, NEVER])
"""A perturbation without effect, (9,)."""


@functools.cache
def arc_table(count: int) -> Floats:
    """About ``count`` rows (a, 9), some of them reversing; columns as in the module's text."""
    rng = np.random.default_rng(_SEED)
    half = max(count - len(_PLAIN), 2) // 2
    speed = np.where(rng.random((half, 3)) < 0.5, 1.0, rng.random((half, 3)))
    speed = np.where(rng.random((half, 3)) < 0.12, 0.0, speed)
    speed = np.where(rng.random((half, 3)) < 0.05, -0.5, speed)
    turn = rng.uniform(-1.0, 1.0, (half, 3))
    turn *= np.abs(turn) ** rng.uniform(0.0, 1.5, (half, 1))
    one = rng.uniform(0.04, 0.4, half)
    two = one + rng.uniform(0.05, 0.45, half)
    begin_return = np.where(rng.random(half) < 0.6, two, NEVER)
    rows = np.column_stack([_interleaved(speed, turn), one, two, begin_return])
    return read_only(np.vstack([_PLAIN, _BACKING, rows, rows * _LEFT_TO_RIGHT]))


@functools.cache
def perturbations(count: int) -> Floats:
    """About ``count`` rows (b, 9) that are added to inputs, laid out as in :func:`arc_table`.

    The first has no effect; none returns to the path. The turn is added to the second input: the
    turn rate of a unicycle, the sideways speed of a holonomic robot.
    """
    rng = np.random.default_rng(_SEED + 1)
    half = max(count - 1, 2) // 2
    size = np.where(np.arange(half) % 2 == 0, 0.12, 0.4)[:, None]
    change = size * rng.standard_normal((half, 6))
    one = rng.uniform(0.04, 0.35, half)
    two = one + rng.uniform(0.05, 0.45, half)
    rows = np.column_stack([change, one, two, np.full(half, NEVER)])
    return read_only(np.vstack([NO_PERTURBATION, rows, rows * _LEFT_TO_RIGHT]))


def _interleaved(speed: Floats, turn: Floats) -> Floats:
    out = np.empty((len(speed), 6))
    out[:, 0::2], out[:, 1::2] = speed, turn
    return out


def _plain() -> Floats:
    """Arcs along the path, straight ahead, slower, waiting first, and turning on the spot first."""
    rows = [[v, 0.0] * 3 + [0.3, 0.6, h] for v in (1.0, 0.75, 0.5, 0.25) for h in (0.0, NEVER)]
    rows += [[0.0, 0.0] * 3 + [0.3, 0.6, NEVER]]
    rows += [[0.0, 0.0] * 3 + [t, t, t] for t in (0.1, 0.2, 0.35, 0.5, 0.7)]
    for w in (1.0, -1.0):
        rows += [[0.0, w, 0.0, w, 1.0, 0.0, t, t, h] for t in (0.1, 0.2, 0.4) for h in (t, NEVER)]
        rows += [[-0.5, 0.5 * w, 0.0, w, 1.0, 0.0, t, 2 * t, 2 * t] for t in (0.1, 0.2)]
    return np.array(rows)


_PLAIN = _plain()
_BACKING = np.array(
    [
        [-1.0, 0.0, -1.0, 0.0, -1.0, 0.0, 0.3, 0.6, NEVER],
        [-0.5, 0.0, -0.5, 0.0, -0.5, 0.0, 0.3, 0.6, NEVER],
        [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.3, 0.6, NEVER],
    ]
)
"""Straight back over the whole horizon or a third of it: farther than any random arc."""
