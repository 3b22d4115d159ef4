"""Progress checker: time since the remaining path last became shorter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model


class ProgressParameters(Model):
    """Definition of progress; assumed."""

    min_progress: float = Field(0.3, gt=0.0, le=10.0)
    """Shortening of the remaining path that counts as progress, m."""
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
    """Time at which it was reached, s."""
    path_time: float
    """Time at which the path was planned, s."""
    time: float
    """Time of the last call, s."""
    position: Annotated[Floats, Shape("2")]
    """Position of the chair at ``since``, m."""


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
    follows_rider: bool = False,
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
        follows_rider: the path follows the rider's input and is therefore replanned all the time;
            a chair that has not moved meanwhile has made no progress.
        hold: the chair need not make progress: it has arrived, or the rider drives or stops it.
    """
    reset = ProgressState(
        remaining=remaining, since=time, path_time=path_time, time=time, position=position.copy()
    )
    if memory is None or hold:
        return reset
    elapsed = time - memory.time
    since = memory.since if 0.0 <= elapsed <= _GAP else time
    if path_time > memory.path_time:
        moved = float(np.hypot(*(position - memory.position)))
        stays = follows_rider and moved < parameters.min_progress
        return replace(reset, since=since, position=memory.position) if stays else reset
    if remaining < memory.remaining - parameters.min_progress:
        return reset
    return replace(memory, since=since, time=time)
