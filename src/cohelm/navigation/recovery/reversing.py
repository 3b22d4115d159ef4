"""Reversing along the driven track, where the chair can neither go on nor turn.

A chair that has driven past its goal, or past the place where its path turns off, cannot turn in a
narrow corridor. It backs up along the track, on which it fitted, until it can turn to its path: at
the goal itself, before it for another approach, or at the nearest place that is wide enough. A
chair in a corridor full of people who want to pass backs up to such a place as well.
"""

from __future__ import annotations

import math
from dataclasses import replace
from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.navigation.recovery.turning_room import BEHIND

_ABREAST = math.radians(60.0)
"""Turn to a goal nearby below which the chair drives forward again, rad."""
NEAR_GOAL = 1.5
"""Remaining length up to which reversing to the goal is shorter than turning twice, m."""
_MIN_CLEARANCE = 0.1
"""Free distance behind from which reversing begins, m; near the goal the chair waits for it."""
MIN_WAY = 0.3
"""Minimum length of the way back, m; less changes nothing."""
_MAX_ATTEMPTS = 4
"""Attempts on the way to one goal; a chair that needs more is not helped by another one."""
_PAUSE = 5.0
"""Time without reversing after a way back that was blocked, s."""
_ROUNDING = 1e-9  # s; times are sums of float steps


class ReversingCause(StrEnum):
    """Cause of reversing."""

    TURN = "turn"
    """The path begins behind the chair."""
    JAM = "jam"
    """People ahead want to pass, and every other recovery has failed."""


@value
class ReversingContext:
    """Facts on which reversing is decided."""

    time: float
    """s."""
    goal: Annotated[Floats, Shape("2")]
    """m."""
    turn: float
    """Angle between the heading and the direction of the path ahead, ≥ 0, rad."""
    has_room: bool
    """The chair can turn by it on the spot; in a jam, the chair can turn about."""
    waited: bool = False
    """The ride makes no progress, and waiting did not help."""
    jammed: bool = False
    """People ahead want to pass, and every other recovery has failed."""
    remaining: float
    """Remaining length of the path, m."""
    way_back: float
    """Length of the way back, m."""
    clearance: float = math.inf
    """Distance that the chair may back up now, as far as observed, m."""
    allowed: bool = True
    """Neither the rider nor the robot forbids it."""

    @property
    def is_behind(self) -> bool:
        """The path leads aside or back; far from the goal this matters once waiting did not help.

        A chair that has made way for a person may find another way to its path.
        """
        return self.turn > BEHIND and (self.waited or self.remaining <= NEAR_GOAL)


@value
class ReversingState:
    """State of reversing on the way to one goal."""

    goal: Annotated[Floats, Shape("2")]
    """m."""
    cause: ReversingCause | None = None
    """None while the chair does not reverse."""
    attempts: int = 0
    blocked_since: float = math.inf
    """Time since which the way back is blocked, s."""
    paused_until: float = -math.inf
    """s."""
    ended_at: float = -math.inf
    """Time at which the chair could turn again; a path planned before begins elsewhere, s."""

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
        ready = now.time >= memory.paused_until - _ROUNDING and memory.attempts < _MAX_ATTEMPTS
        free = now.clearance >= _MIN_CLEARANCE or now.remaining <= NEAR_GOAL
        if not (ready and free and is_caused(now)):
            return memory
        cause = ReversingCause.TURN if now.is_behind else ReversingCause.JAM
        return replace(memory, cause=cause, attempts=memory.attempts + 1)
    if _ends(now, memory.cause):
        return replace(memory, cause=None, blocked_since=math.inf, ended_at=now.time)
    if now.clearance > 0.0:
        return replace(memory, blocked_since=math.inf)
    since = min(memory.blocked_since, now.time)
    if now.time - since < patience - _ROUNDING:
        return replace(memory, blocked_since=since)
    return replace(memory, cause=None, blocked_since=math.inf, paused_until=now.time + _PAUSE)


def is_caused(now: ReversingContext) -> bool:
    """Check for a cause of reversing, and for a way back."""
    caused = now.is_behind or now.jammed
    return now.allowed and caused and not now.has_room and now.way_back >= MIN_WAY


def _ends(now: ReversingContext, cause: ReversingCause | None) -> bool:
    """Check for turning room; near the goal the chair goes on until the goal is ahead."""
    near = cause is ReversingCause.TURN and now.remaining <= NEAR_GOAL
    turns = now.has_room and (now.turn <= _ABREAST or not near)
    return turns or not now.allowed or now.way_back < MIN_WAY
