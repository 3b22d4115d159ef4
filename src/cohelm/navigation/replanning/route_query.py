"""Route query: everything on which replanning depends."""

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
)
from cohelm.robots import Robot


class PlanReason(StrEnum):
    """Cause of planning a path."""

    FIRST = "first"
    """There was no path."""
    GOAL = "goal"
    """The goal changed."""
    WISH = "wish"
    """The wishes changed."""
    BLOCKED = "blocked"
    """The path was blocked for some time."""
    OFF_PATH = "off_path"
    """The chair had left the path."""
    STALLED = "stalled"
    """The ride made no progress."""
    BACKED_UP = "backed_up"
    """The chair has backed up along its track."""
    TURN = "turn"
    """The path began behind the chair, which cannot turn there."""
    STEERING = "steering"
    """The rider steered away from the path."""


@value
class RouteQuery:
    """State of one tick as far as it decides on replanning."""

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
    """Recovery demands another path now, around people who stand."""
    backed_up: bool = False
    """The chair has backed up along its track since the last plan."""
    cannot_turn: bool = False
    """The path begins behind the chair, which cannot turn to it."""
    side: Side = "none"
    """Passing side that the rider selected."""
    crowding: Crowding | None = None
    groups: tuple[Floats, ...] = ()
    """Outlines (k, 2) of standing groups, m."""
    filters: tuple[CostmapFilter, ...] = ()


@value
class PlanningFailure:
    """A request without a path; planning is not repeated at once."""

    request: Request
    time: float
    """s."""
    reason: Reason
    detail: str
    """Text of the error, with places and widths."""
