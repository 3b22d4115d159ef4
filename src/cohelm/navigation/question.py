"""What is asked when the way is in question."""

from __future__ import annotations

from enum import StrEnum

from cohelm.arrays import Floats, value
from cohelm.maps import CostmapFilter, DistanceField, OccupancyGrid
from cohelm.messages import (
    Authority,
    Crowding,
    LiveObstacles,
    People,
    Reason,
    Request,
    Side,
    Wish,
)
from cohelm.planning import RouteProblem
from cohelm.robots import Robot


class Why(StrEnum):
    """What a path was planned for."""

    FIRST = "first"
    """There was none."""
    GOAL = "goal"
    """The rider wants to go elsewhere."""
    WISH = "wish"
    """The rider wants to go another way."""
    BLOCKED = "blocked"
    """Something stood in the old one's way for a while."""
    BETTER = "better"
    """A much better one has opened, or the old one has become much worse."""
    ASTRAY = "astray"
    """The chair had left the old one."""
    STALLED = "stalled"
    """The ride did not get on."""
    STEERING = "steering"
    """The rider's hand led elsewhere."""


@value
class RouteQuestion:
    """Everything that decides whether to plan anew."""

    time: float
    request: Request
    pose: Floats
    robot: Robot
    grid: OccupancyGrid
    live: LiveObstacles
    walls: DistanceField
    """About the chair."""
    authority: Authority | None
    people: People
    stalled: bool = False
    """The ride does not get on, and another way is to be looked for now, round those who stand."""
    side: Side = "none"
    """On which the rider wants to pass what is ahead."""
    crowding: Crowding | None = None
    groups: tuple[Floats, ...] = ()
    """Outlines (k, 2) of those who stand together, m."""
    filters: tuple[CostmapFilter, ...] = ()


@value
class Refusal:
    """A request that there was no path for: not asked again at once."""

    request: Request
    time: float
    """s."""
    reason: Reason
    trouble: str
    """The same with places and widths."""


def problem_of(
    q: RouteQuestion,
    start: Floats,
    wishes: tuple[Wish, ...],
    *,
    wished_from: Floats,
    kept: Floats | None,
    effort: float = 1.0,
) -> RouteProblem:
    """What the global planner is asked.

    Args:
        q: everything it may know.
        start: (2,), m.
        wishes: those that are still ahead.
        wished_from: where the chair was when they were set, (2,), m.
        kept: the rest of the path that is followed (k, 2), m.
        effort: share of what it may spend that the planner spends.
    """
    return RouteProblem(
        grid=q.grid,
        robot=q.robot,
        start=start,
        goal=q.request.goal,
        wishes=wishes,
        wished_from=wished_from,
        live=q.live,
        crowding=q.crowding,
        groups=q.groups,
        filters=q.filters,
        kept=kept,
        clearance=q.request.profile.clearance,
        effort=effort,
    )
