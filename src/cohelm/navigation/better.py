"""Whether another way has become much better than the one that is followed.

A way is looked for only after something has changed that could matter, and not often. It replaces
the path only where it is better by a share and by some metres, under one and the same costmap, so
that two ways of about the same worth never take turns: what made the second one better must first
change by twice that. The way that was left last asks for more still, and not at once.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from pydantic import Field
from scipy.spatial import cKDTree

from cohelm.arrays import Annotated, Bytes, Floats, Shape, value
from cohelm.config import Model
from cohelm.geometry import resample
from cohelm.messages import Crowding, LiveObstacles, Path
from cohelm.navigation.question import Why

_ROUNDING = 1e-9  # s; times are sums of float steps
_SPACING = 0.25
"""Between points of ways that are compared, m."""


class BetterParameters(Model):
    """When another way replaces one that is still good; all assumed."""

    look_every: float = Field(3.0, ge=0.1, le=60.0)
    """Least time between two looks for a better way, s."""
    least_left: float = Field(5.0, ge=0.0, le=1000.0)
    """Where less than this is left of the path, no other way is looked for, m."""
    notice: float = Field(0.05, ge=0.0, le=10.0)
    """Area of live obstacles that must have come or gone before it is looked again, m²."""
    settle: float = Field(4.0, ge=0.0, le=120.0)
    """A new path is followed for at least so long before another one may be better, s."""
    gain: float = Field(0.12, ge=0.0, lt=1.0)
    """Share of the old path's score that a better one must save …"""
    metres: float = Field(1.0, ge=0.0, le=100.0)
    """… and what it must save beyond, m."""
    back: float = Field(1.1, ge=1.0, le=10.0)
    """How many times as much the way that was left last must save."""
    regret: float = Field(20.0, ge=0.0, le=600.0)
    """How long the way that was left last stays left, unless the other one is blocked, s."""
    alike: float = Field(1.0, gt=0.0, le=10.0)
    """Points nearer than this to a way are on it, m: a line that strays no farther from the path
    is no other way."""


@value
class Lookout:
    """What looking for a better way remembers."""

    at: float
    """When it was last looked or planned, s."""
    live: LiveObstacles
    """What stood about then."""
    crowding: Crowding | None = None
    """Where people had been then."""
    cuts: int = 0
    """Between the members of how many groups the path led then."""
    shut_since: float = math.inf
    """Since when the path is known to be blocked out of sight of the local planner, s."""
    again: bool = False
    """Whether to look again though nothing changes: a better way was found that is to stay left."""
    compares: bool = True
    """Whether the planner says what the old path is worth."""


@value
class Left:
    """The way that was left last."""

    points: Annotated[Floats, Shape("k 2")]
    """What was left of it, m."""
    at: float
    """When, s."""


def worth_a_look(
    lookout: Lookout,
    time: float,
    live: LiveObstacles,
    crowding: Crowding | None,
    resolution: float,
    parameters: BetterParameters,
    *,
    cuts: int = 0,
) -> bool:
    """Whether enough has changed, long enough ago, to look for a better way now.

    Args:
        lookout: when and on what it was looked last.
        time: now, s.
        live: what stands about now.
        crowding: where people have been now.
        resolution: of the live obstacles' cells, m.
        parameters: what is enough.
        cuts: between the members of how many groups the path leads now.
    """
    p = parameters
    if not lookout.compares or time - lookout.at < p.look_every - _ROUNDING:
        return False
    if lookout.again or math.isfinite(lookout.shut_since) or cuts > lookout.cuts:
        return True
    if _version(crowding) != _version(lookout.crowding):
        return True
    if live.version == lookout.live.version:
        return False
    return _changed_cells(live, lookout.live) * resolution**2 >= p.notice


def judged(
    found: Path,
    rest: Floats,
    lookout: Lookout,
    left: Left | None,
    *,
    time: float,
    blocked_time: float,
    parameters: BetterParameters,
) -> tuple[Why | None, Lookout]:
    """Why to take the way that was found, None: not at all; and the look remembered.

    Args:
        found: with ``score`` and ``kept_score``.
        rest: of the path that is followed (k, 2), m.
        lookout: of this look.
        left: the way that was left last.
        time: now, s.
        blocked_time: how long a way must be blocked to be given up, s.
        parameters: how much better is much better.
    """
    p, kept = parameters, found.kept_score
    if kept is None:
        return None, replace(lookout, compares=False)
    if math.isinf(kept):
        since = min(lookout.shut_since, time)
        shut = time - since >= blocked_time - _ROUNDING
        return (Why.BLOCKED if shut else None), replace(lookout, shut_since=since)
    lookout = replace(lookout, shut_since=math.inf, again=False)
    if _distances(found.points, rest).max() <= p.alike:
        return None, lookout
    returns = left is not None and _returns(found.points, left.points, rest, p.alike)
    times = p.back if returns else 1.0
    wins = found.score < kept * (1.0 - min(times * p.gain, 1.0)) - times * p.metres
    if wins and returns and left is not None and time - left.at < p.regret - _ROUNDING:
        return None, replace(lookout, again=True)
    return (Why.BETTER if wins else None), lookout


def _version(crowding: Crowding | None) -> int:
    return -1 if crowding is None else crowding.version


def _changed_cells(now: LiveObstacles, then: LiveObstacles) -> int:
    """How many cells of the floor that both windows cover have come or gone."""
    low = np.maximum(now.corner, then.corner)
    high = np.minimum(now.corner + now.occupied.shape, then.corner + then.occupied.shape)
    if (high <= low).any():
        return int(now.occupied.sum()) + int(then.occupied.sum())
    return int(np.count_nonzero(_part(now, low, high) != _part(then, low, high)))


def _part(live: LiveObstacles, low: Floats, high: Floats) -> Bytes:
    (r0, c0), (r1, c1) = low - live.corner, high - live.corner
    return live.occupied[int(r0) : int(r1), int(c0) : int(c1)]


def _returns(found: Floats, left: Floats, rest: Floats, alike: float) -> bool:
    """Whether ``found`` runs mostly where ``left`` did and the present path does not."""
    points = resample(left, _SPACING)
    apart = points[_distances(points, rest) > alike]
    return len(apart) > 0 and bool((_distances(apart, found) <= alike).mean() > 0.5)


def _distances(points: Floats, line: Floats) -> Floats:
    """(m,) from points (m, 2) to the points of a line, good to a fraction of the spacing."""
    distance: Floats = cKDTree(resample(line, _SPACING)).query(points)[0]
    return distance
