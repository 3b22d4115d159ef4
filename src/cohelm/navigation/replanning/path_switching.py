"""Path switching: replacement of a usable path by a much better one.

A better path is searched for only after a relevant change, and not often. It replaces the current
path only if it is better by a share and by an absolute amount under the same costmap, so that two
paths of about equal cost never alternate: the change that made the second one better must first be
reversed twice over. The path abandoned last needs a larger gain, and some time.
"""

from __future__ import annotations

import math

import numpy as np
from pydantic import Field
from scipy.spatial import cKDTree

from cohelm.arrays import Annotated, Bytes, Floats, Shape, replace, value
from cohelm.config import Model
from cohelm.geometry import resample
from cohelm.messages import Crowding, LiveObstacles, Path
from cohelm.navigation.replanning.route_query import PlanReason, RouteQuery

_ROUNDING = 1e-9  # s; times are sums of float steps
_SPACING = 0.25
"""Spacing of points of paths that are compared, m."""


class SwitchingParameters(Model):
    """Conditions for replacing a usable path; all assumed."""

    search_interval: float = Field(3.0, ge=0.1, le=60.0)
    """Minimum time between two searches, s."""
    min_remaining: float = Field(5.0, ge=0.0, le=1000.0)
    """Minimum remaining length of the path for a search, m."""
    changed_area: float = Field(0.05, ge=0.0, le=10.0)
    """Minimum area of appeared or disappeared live obstacles for a search, m²."""
    min_hold: float = Field(4.0, ge=0.0, le=120.0)
    """Minimum time on a new path, s."""
    relative_gain: float = Field(0.12, ge=0.0, lt=1.0)
    """Share of the current path's score that a better path must save …"""
    absolute_gain: float = Field(1.0, ge=0.0, le=100.0)
    """… and the additional saving that is required, m."""
    return_factor: float = Field(1.1, ge=1.0, le=10.0)
    """Factor on both gains for the path abandoned last."""
    return_time: float = Field(20.0, ge=0.0, le=600.0)
    """Time before the path abandoned last may return, unless the current one is blocked, s."""
    same_path_distance: float = Field(1.0, gt=0.0, le=10.0)
    """Distance up to which points lie on the same path, m."""


@value
class SwitchingState:
    """State of the search for a better path."""

    at: float
    """Time of the last search or plan, s."""
    live: LiveObstacles
    """Live obstacles at that time."""
    crowding: Crowding | None = None
    """Crowding at that time."""
    crossed_groups: int = 0
    """Number of standing groups that the path crossed at that time."""
    blocked_since: float = math.inf
    """Start of a blockage outside the window of the local planner, s."""
    repeat: bool = False
    """Search again without any change: a better path was found that may not return yet."""
    has_scores: bool = True
    """The planner reports the score of the current path."""


@value
class AbandonedPath:
    """The path that was abandoned last."""

    points: Annotated[Floats, Shape("k 2")]
    """Its remaining part, m."""
    at: float
    """Time of abandoning it, s."""


def should_search(
    state: SwitchingState,
    query: RouteQuery,
    parameters: SwitchingParameters,
    *,
    crossed_groups: int = 0,
) -> bool:
    """Check that enough has changed, long enough after the last search.

    Args:
        state: of the last search.
        query: time, live obstacles, crowding and grid.
        parameters: thresholds.
        crossed_groups: number of standing groups that the path crosses now.
    """
    if not state.has_scores or query.time - state.at < parameters.search_interval - _ROUNDING:
        return False
    if (
        state.repeat
        or math.isfinite(state.blocked_since)
        or crossed_groups > state.crossed_groups
        or _version(query.crowding) != _version(state.crowding)
    ):
        return True
    if query.live.version == state.live.version:
        return False
    cells = _changed_cells(query.live, state.live)
    return cells * query.grid.resolution**2 >= parameters.changed_area


def evaluate_candidate(
    candidate: Path,
    remaining: Floats,
    state: SwitchingState,
    abandoned: AbandonedPath | None,
    *,
    time: float,
    blocked_time: float,
    parameters: SwitchingParameters,
) -> tuple[PlanReason | None, SwitchingState]:
    """Decide on a found path: the reason to switch, None to stay; and the new state.

    Args:
        candidate: with ``score`` and ``previous_score``.
        remaining: rest of the current path (k, 2), m.
        state: of this search.
        abandoned: the path abandoned last.
        time: now, s.
        blocked_time: time after which a blocked path is given up, s.
        parameters: gains and distances.
    """
    p, previous = parameters, candidate.previous_score
    if previous is None:
        return None, replace(state, has_scores=False)
    if math.isinf(previous):
        since = min(state.blocked_since, time)
        blocked = time - since >= blocked_time - _ROUNDING
        return (PlanReason.BLOCKED if blocked else None), replace(state, blocked_since=since)
    state = replace(state, blocked_since=math.inf, repeat=False)
    if distances_to(candidate.points, remaining).max() <= p.same_path_distance:
        return None, state
    returns = abandoned is not None and _returns(
        candidate.points, abandoned.points, remaining, p.same_path_distance
    )
    factor = p.return_factor if returns else 1.0
    bound = previous * (1.0 - min(factor * p.relative_gain, 1.0)) - factor * p.absolute_gain
    better = candidate.score < bound
    if (
        better
        and returns
        and abandoned is not None
        and time - abandoned.at < p.return_time - _ROUNDING
    ):
        return None, replace(state, repeat=True)
    return (PlanReason.BETTER if better else None), state


def _version(crowding: Crowding | None) -> int:
    return -1 if crowding is None else crowding.version


def _changed_cells(now: LiveObstacles, before: LiveObstacles) -> int:
    """Number of changed cells on the floor that both windows cover; all cells if none is."""
    low = np.maximum(now.corner, before.corner)
    high = np.minimum(now.corner + now.occupied.shape, before.corner + before.occupied.shape)
    if (high <= low).any():
        return int(now.occupied.sum()) + int(before.occupied.sum())
    return int(np.count_nonzero(_cut(now, low, high) != _cut(before, low, high)))


def _cut(live: LiveObstacles, low: Floats, high: Floats) -> Bytes:
    (r0, c0), (r1, c1) = low - live.corner, high - live.corner
    return live.occupied[int(r0) : int(r1), int(c0) : int(c1)]


def _returns(candidate: Floats, abandoned: Floats, remaining: Floats, same: float) -> bool:
    """Check that the candidate mostly follows the abandoned path where that left the current."""
    points = resample(abandoned, _SPACING)
    apart = points[distances_to(points, remaining) > same]
    return len(apart) > 0 and bool((distances_to(apart, candidate) <= same).mean() > 0.5)


def distances_to(points: Floats, line: Floats) -> Floats:
    """(m,) from points (m, 2) to a line (k, 2), exact to a fraction of the spacing, m."""
    distance: Floats = cKDTree(resample(line, _SPACING)).query(points)[0]
    return distance
