"""Whether the ride gets on: how long the way left has not become shorter."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model


class ProgressParameters(Model):
    """What counts as getting on; assumed."""

    least: float = Field(0.3, gt=0.0, le=10.0)
    """Shortening of the way left that counts, m."""
    patience: float = Field(3.0, ge=0.0, le=120.0)
    """How long without getting on until the ride counts as stalled, s."""
    creep: float = Field(0.3, gt=0.0, le=3.0)
    """Speed of a stalled ride, m/s."""


@value
class ProgressState:
    """What progress remembers."""

    left: float
    """The shortest way left so far on this path, m."""
    since: float
    """When it was reached, s."""
    path_time: float
    """When the path was planned, s."""
    time: float
    """Of the last call, s."""
    at: Annotated[Floats, Shape("2")]
    """Where the chair was at ``since``, m."""


_GAP = 1.5
"""Between two calls; a longer while, in which nothing could be seen, is no time lost, s."""


def progress(
    left: float,
    time: float,
    path_time: float,
    memory: ProgressState | None,
    parameters: ProgressParameters,
    *,
    at: Floats,
    follows: bool = False,
    rests: bool = False,
) -> ProgressState:
    """How far the ride has got; it has not got on since ``since``.

    Args:
        left: way left along the path, m.
        time: now, s.
        path_time: when the path was planned, s; a new path starts anew.
        memory: of the last call, None at first.
        parameters: what counts as getting on.
        at: where the chair is (2,), m.
        follows: the path follows the rider's hand, and is planned again and again while the hand
            leads; a chair that has not moved meanwhile has not got on.
        rests: the chair is not to get on: it has arrived, or the rider steers it or wants it to
            stand.
    """
    anew = ProgressState(left=left, since=time, path_time=path_time, time=time, at=at.copy())
    if memory is None or rests:
        return anew
    lost = time - memory.time
    since = memory.since if 0.0 <= lost <= _GAP else time
    if path_time > memory.path_time:
        stays = float(np.hypot(*(at - memory.at))) < parameters.least
        return replace(anew, since=since, at=memory.at) if follows and stays else anew
    if left < memory.left - parameters.least:
        return anew
    return replace(memory, since=since, time=time)
