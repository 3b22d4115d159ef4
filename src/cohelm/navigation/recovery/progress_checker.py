"""Progress checker: time since the chair last got on along its path, or turned towards it."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.config import Model


class ProgressParameters(Model):
    """Definition of progress; assumed."""

    min_progress: float = Field(0.3, gt=0.0, le=10.0)
    """Shortening of the remaining path that counts as progress, m."""
    min_turn: float = Field(0.5, gt=0.0, le=3.2)
    """Turn towards the path that counts as progress, rad."""
    time_allowance: float = Field(3.0, ge=0.0, le=120.0)
    """Time without progress after which the ride is stalled, s."""
    creep_speed: float = Field(0.3, gt=0.0, le=3.0)
    """Speed limit of a stalled ride, m/s."""


@value
class ProgressState:
    """State of the progress checker."""

    remaining: float
    """Shortest remaining length on this path so far, m."""
    since: float
    """Time of the last progress, s."""
    path_time: float
    """Time at which the path was planned, s."""
    time: float
    """Time of the last call, s."""
    position: Annotated[Floats, Shape("2")]
    """Position of the chair at ``since``, m."""
    turn: float = 0.0
    """Largest angle between heading and path since then; once the chair turns back, the smallest,
    so that turning to and fro is no progress; rad."""
    has_turned: bool = False
    """The chair has turned towards the path since the path last became shorter."""


_GAP = 1.5
"""Maximum time between two calls, s; a longer gap without observations is not counted."""


def check_progress(
    remaining: float,
    time: float,
    path_time: float,
    memory: ProgressState | None,
    parameters: ProgressParameters,
    *,
    position: Floats,
    turn: float = 0.0,
    replanned: bool = False,
    hold: bool = False,
) -> ProgressState:
    """Update the time ``since`` which there was no progress.

    Args:
        remaining: remaining length of the path, m.
        time: now, s.
        path_time: time at which the path was planned, s; a new path resets the checker.
        memory: of the last call, None at first.
        parameters: definition of progress.
        position: of the chair (2,), m.
        turn: angle between the heading and the path beside the chair, ≥ 0, rad.
        replanned: the path is replaced all the time, because it follows the rider's input or a
            chair that was led off its path, or begins where the chair cannot turn to it; a chair
            that has not moved meanwhile has made no progress.
        hold: the chair need not make progress: it has arrived, or the rider drives or stops it.
    """
    reset = ProgressState(
        remaining=remaining,
        since=time,
        path_time=path_time,
        time=time,
        position=position.copy(),
        turn=turn,
    )
    if memory is None or hold:
        return reset
    elapsed = time - memory.time
    least_or_most = min if memory.has_turned else max
    turned = replace(memory, turn=least_or_most(memory.turn, turn))
    since = memory.since if 0.0 <= elapsed <= _GAP else time
    if path_time > memory.path_time:
        moved = float(np.hypot(*(position - memory.position)))
        stays = replanned and moved < parameters.min_progress
        kept = replace(turned, remaining=remaining, since=since, path_time=path_time, time=time)
        return kept if stays else reset
    if remaining < memory.remaining - parameters.min_progress:
        return reset
    if turn < memory.turn - parameters.min_turn:
        return replace(
            memory, since=time, time=time, position=position.copy(), turn=turn, has_turned=True
        )
    return replace(turned, since=since, time=time)
