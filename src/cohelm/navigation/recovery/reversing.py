"""Reversing: along a leg of the path that is driven backwards, or out of a jam.

A path that begins behind a chair that cannot turn has legs in both gears. The chair drives those
backwards as far as the space behind is known to be free. A chair in a corridor full of people who
want to pass backs up along the track that it drove, on which it fitted, to a place where it can
turn about.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value

_MIN_CLEARANCE = 0.1
"""Free distance behind from which backing out of a jam begins, m."""
MIN_WAY = 0.3
"""Minimum length of the way back, m; less changes nothing."""
_MAX_ATTEMPTS = 4
"""Jams backed out of, or legs given up, on the way to one goal; then the rider is asked."""
_STUCK = 1.5
"""Standstill on a leg with free space behind, s: the local planner finds no motion, and a path from
here may be better."""
_PAUSE = 5.0
"""Time without reversing after a way back that was blocked, s."""
_ROUNDING = 1e-9  # s; times are sums of float steps


class ReversingCause(StrEnum):
    """Cause of reversing."""

    LEG = "leg"
    """The path leads backwards."""
    JAM = "jam"
    """People ahead want to pass, and every other recovery has failed."""


@value
class ReversingContext:
    """Facts on which reversing is decided."""

    time: float
    """s."""
    goal: Annotated[Floats, Shape("2")]
    """m."""
    backward: bool = False
    """The present leg of the path is driven backwards."""
    jammed: bool = False
    """People ahead want to pass, and every other recovery has failed."""
    has_room: bool = True
    """In a jam: the chair can turn about."""
    way_back: float = 0.0
    """Length of the way back, m."""
    clearance: float = math.inf
    """Distance that the chair may back up now, as far as observed, m."""
    stands: bool = False
    allowed: bool = True
    """Neither the rider nor the robot forbids it."""


@value
class ReversingState:
    """State of reversing on the way to one goal."""

    goal: Annotated[Floats, Shape("2")]
    """m."""
    cause: ReversingCause | None = None
    """None while the chair does not reverse."""
    attempts: int = 0
    stood_since: float = math.inf
    """Start of the standstill with free space behind, s."""
    blocked_since: float = math.inf
    """Time since which the way back is blocked, s."""
    paused_until: float = -math.inf
    """s."""
    ended_at: float = -math.inf
    """Time at which the chair has left a jam or got stuck; a new path begins there, s."""

    @property
    def active(self) -> bool:
        """The chair reverses, or waits for people behind it."""
        return self.cause is not None


def update_reversing(
    now: ReversingContext, memory: ReversingState | None, *, patience: float
) -> ReversingState:
    """Begin, continue or end reversing.

    Args:
        now: facts of this tick.
        memory: of the last call, None at first.
        patience: time to wait for people behind the chair, s.
    """
    if memory is None or not np.array_equal(memory.goal, now.goal):
        memory = ReversingState(goal=now.goal.copy())
    if not memory.active:
        ready = now.time >= memory.paused_until - _ROUNDING and is_caused(now)
        return _begun(now, memory) if ready else memory
    if _ends(now, memory.cause):
        jammed = memory.cause is ReversingCause.JAM
        ended_at = now.time if jammed else memory.ended_at
        return replace(memory, cause=None, blocked_since=math.inf, ended_at=ended_at)
    if now.clearance > 0.0:
        return _going(now, memory)
    since = min(memory.blocked_since, now.time)
    if now.time - since < patience - _ROUNDING:
        return replace(memory, blocked_since=since)
    return replace(memory, cause=None, blocked_since=math.inf, paused_until=now.time + _PAUSE)


def _begun(now: ReversingContext, memory: ReversingState) -> ReversingState:
    """Begin reversing, which is not tried for ever; out of a jam it needs free space behind."""
    if memory.attempts >= _MAX_ATTEMPTS:
        return memory
    if now.backward:
        return replace(memory, cause=ReversingCause.LEG)
    if now.clearance < _MIN_CLEARANCE:
        return memory
    return replace(memory, cause=ReversingCause.JAM, attempts=memory.attempts + 1)


def _going(now: ReversingContext, memory: ReversingState) -> ReversingState:
    """Go on where the space behind is free; give up a leg on which the chair stands."""
    since = min(memory.stood_since, now.time) if now.stands else math.inf
    memory = replace(memory, blocked_since=math.inf, stood_since=since)
    if memory.cause is not ReversingCause.LEG or now.time - since < _STUCK - _ROUNDING:
        return memory
    return replace(
        memory,
        cause=None,
        stood_since=math.inf,
        attempts=memory.attempts + 1,
        ended_at=now.time,
    )


def is_caused(now: ReversingContext) -> bool:
    """Check for a cause of reversing, and for a way back."""
    out_of_jam = now.jammed and not now.has_room and now.way_back >= MIN_WAY
    return now.allowed and (now.backward or out_of_jam)


def _ends(now: ReversingContext, cause: ReversingCause | None) -> bool:
    """Check for the end of the leg, or for room to turn about."""
    if cause is ReversingCause.LEG:
        return not now.allowed or not now.backward
    return not now.allowed or now.has_room or now.way_back < MIN_WAY
