"""Kind of the rider's input: which directions it can request, and how steady they are.

A switched joystick has eight directions, a single switch with a scanning display has four. Both are
recognised by their messages: directions of a grid, always with the same deflection. All other input
is that of a free stick, with a measured unsteadiness: the standard deviation of the stick's
direction from its low-pass.

From this follows the *width* of the direction that the rider means: half of the angle between
neighbouring directions, or twice the unsteadiness.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from cohelm.arrays import Floats, replace, value
from cohelm.geometry import wrap_angle

HandKind = Literal["stick", "eight_directions", "one_switch"]

_ON_GRID = 0.01
"""Angle from a direction of the grid that is on it, rad."""
_ALIKE = 0.02
"""Difference of two deflections that are alike, share of full."""
_CHANGES = 2
"""Number of presses and changes of direction after which a grid is recognised …"""
_HELD = 0.5
"""… or the time for which one direction is held exactly, s: a free stick never does."""
_MEMORY_TIME = 2.0
"""Time constant of the unsteadiness, s."""
_PUSHED = 0.1
"""Deflection from which the direction of a stick is measured, share of full."""
COARSE = math.pi / 8.0
"""Width of eight directions, and the largest one of a free stick, rad."""
_WIDTHS = {"eight_directions": COARSE, "one_switch": math.pi / 4.0}


@value
class HandState:
    """Kind of the input, and the memory of its recognition."""

    kind: HandKind = "stick"
    width: float = 0.0
    """Half of the interval of directions that the rider may mean, rad."""
    deflections: tuple[float, float, float] = (math.nan, math.nan, math.nan)
    """Deflection of forward and back, of left and right, of diagonals; NaN: not yet seen."""
    direction: int = -1
    """Last direction in eighths of a turn; −1: released."""
    changes: int = 0
    """Presses and changes of direction since the stick last left the grid."""
    held: float = 0.0
    """Longest time for which a direction was held since then, s."""
    mean: float = 0.0
    """Mean angle of the stick from its low-pass, rad …"""
    square: float = 0.0
    """… and its mean square, rad²."""

    @property
    def unsteadiness(self) -> float:
        """Standard deviation of the direction of the stick, rad."""
        return math.sqrt(max(self.square - self.mean**2, 0.0))


FREE_STICK = HandState()


def update_hand(
    raw: Floats,
    smoothed: Floats,
    elapsed: float,
    memory: HandState,
    *,
    given: HandKind | None = None,
) -> HandState:
    """Recognise the kind of input with the newest deflection.

    Args:
        raw: deflection (2,) as the device sent it.
        smoothed: deflection (2,) after a low-pass.
        elapsed: time since the last call, s.
        memory: result of the last call.
        given: kind that is known; None: it is recognised.
    """
    state = _measured(raw, smoothed, elapsed, _on_grid(raw, elapsed, memory))
    kind = given or _kind(state)
    width = _WIDTHS.get(kind, min(2.0 * state.unsteadiness, COARSE))
    return replace(state, kind=kind, width=width)


def _on_grid(raw: Floats, elapsed: float, memory: HandState) -> HandState:
    """Compare a deflection with the grid of directions; one beside the grid restarts the count."""
    if not raw.any():
        return memory if memory.direction < 0 else replace(memory, direction=-1)
    eighths = math.atan2(raw[1], raw[0]) / (math.pi / 4.0)
    direction, size = round(eighths) % 8, float(np.hypot(*raw))
    axis = 2 if direction % 2 else direction % 4 // 2
    before = memory.deflections[axis]
    off = abs(eighths - round(eighths)) * math.pi / 4.0 > _ON_GRID
    if off or abs(size - before) > _ALIKE:
        sizes = _with_size((math.nan, math.nan, math.nan), axis, math.nan if off else size)
        return replace(memory, deflections=sizes, direction=direction, changes=0, held=0.0)
    if direction == memory.direction and not math.isnan(before):
        held = memory.held + max(elapsed, 0.0)
        return memory if memory.held > _HELD else replace(memory, held=held)
    sizes = _with_size(memory.deflections, axis, size)
    changes = min(memory.changes + 1, _CHANGES)
    return replace(memory, deflections=sizes, direction=direction, changes=changes)


def _with_size(
    sizes: tuple[float, float, float], axis: int, size: float
) -> tuple[float, float, float]:
    changed = [*sizes]
    changed[axis] = size
    return changed[0], changed[1], changed[2]


def _kind(state: HandState) -> HandKind:
    if state.changes < _CHANGES and state.held < _HELD:
        return "stick"
    return "one_switch" if math.isnan(state.deflections[2]) else "eight_directions"


def _measured(raw: Floats, smoothed: Floats, elapsed: float, memory: HandState) -> HandState:
    """Average the angle between a stick that pushes forward and its low-pass."""
    if not (raw[0] > 0.0 and smoothed[0] > 0.0 and np.hypot(*raw) > _PUSHED):
        return memory
    angle = math.atan2(raw[1], raw[0]) - math.atan2(smoothed[1], smoothed[0])
    off = float(wrap_angle(angle))
    share = 1.0 - math.exp(-max(elapsed, 0.0) / _MEMORY_TIME)
    return replace(
        memory,
        mean=memory.mean + share * (off - memory.mean),
        square=memory.square + share * (off * off - memory.square),
    )
