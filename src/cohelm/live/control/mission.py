"""Mission of a live ride: destination, wishes about the route, mode and pace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from cohelm.errors import CohelmError, InvalidProblem
from cohelm.live.control.limits import PACES, limited_profile
from cohelm.live.messages import (
    ActiveWish,
    ChosenRoute,
    Destination,
    FloorInfo,
    Limits,
    Pace,
    RiderSettings,
    RouteWish,
)
from cohelm.maps import OccupancyGrid, Places
from cohelm.messages import Mode, Request, RiderProfile, Wish
from cohelm.planning.alternatives.learned_preference import FeatureVector, RouteChoice
from cohelm.reasons import Reason

MAX_LENGTH = 300.0
"""Maximum length of a drawn line, m; scribbles are longer than they look."""
MARGIN = 2.0
"""Distance by which a wish may exceed the map, m."""


class GoalRefused(CohelmError):
    """No chair can stand at the requested destination; the current one stays."""


class GoalOutside(GoalRefused):
    """The destination lies outside the known part of the map."""

    code = Reason.OUTSIDE_MAP.value


class GoalOnObstacle(GoalRefused):
    """The destination lies on an obstacle of the map."""

    code = Reason.GOAL_BLOCKED.value


@dataclass(frozen=True, slots=True, kw_only=True)
class Mission:
    """Requests of the rider that are in force."""

    goal: Destination | None = None
    wishes: tuple[ActiveWish, ...] = ()
    choice: RouteChoice | None = None
    """Choice of the route to this destination; None: there was nothing to choose."""
    mode: Mode = Mode.SHARED
    pace: Pace = "normal"
    version: int = 0
    """Grows with every change of goal or wishes."""

    @property
    def active_mode(self) -> Mode:
        """Mode in which the chair drives: without a destination the rider steers."""
        return self.mode if self.goal is not None or self.mode.rider_drives else Mode.ASSISTED

    @property
    def under_way(self) -> bool:
        """True if the chair would drive with the stick released."""
        return self.goal is not None and not self.mode.rider_drives

    def with_goal(
        self,
        goal: Destination | None,
        wishes: tuple[ActiveWish, ...] = (),
        choice: RouteChoice | None = None,
    ) -> Mission:
        """Return the mission with another destination, or with none; wishes end with their trip."""
        return replace(self, goal=goal, wishes=wishes, choice=choice, version=self.version + 1)


def goal_of(
    place: str | None, point: tuple[float, float] | None, places: Places
) -> Destination | None:
    """Return the destination of a ``SetGoal`` message.

    Raises:
        MapError: There is no place of this name.
    """
    if place is not None:
        found = places.find(place)
        return Destination(name=found.name, x=float(found.point[0]), y=float(found.point[1]))
    if point is not None:
        return Destination(name=places.at(point), x=point[0], y=point[1])
    return None


def choice_of(chosen: ChosenRoute | None, goal: Destination) -> RouteChoice | None:
    """Return the choice of a ``SetGoal`` message; None: it names no route that was shown."""
    if chosen is None or chosen.taken >= len(chosen.figures):
        return None
    routes = tuple(FeatureVector(**figures.model_dump()) for figures in chosen.figures)
    return RouteChoice(where=goal.name, routes=routes, taken=chosen.taken)


def check_goal(goal: Destination, grid: OccupancyGrid) -> None:
    """Reject a destination at which no chair can stand, before it replaces another one.

    Raises:
        GoalOutside: It lies outside the map, or where the map is unknown.
        GoalOnObstacle: It lies on an obstacle.
    """
    point = np.array([goal.x, goal.y])
    if not grid.contains(point) or grid.data[tuple(grid.cells(point))] < 0:
        raise GoalOutside(Reason.OUTSIDE_MAP.sentence)
    if grid.occupied()[tuple(grid.cells(point))]:
        raise GoalOnObstacle(Reason.GOAL_BLOCKED.sentence)


def wish_of(message: RouteWish, number: int) -> ActiveWish:
    """Return the wish of a message, with ``number`` as its id."""
    return ActiveWish(id=number, **dict(message))


def check_wish(message: RouteWish, floor: FloorInfo) -> None:
    """Reject a wish that no route can satisfy, before any planning.

    Raises:
        InvalidProblem: It lies outside the map, its line is too long, or its line or area is empty.
    """
    points = np.array(message.points)
    low = np.array([floor.x, floor.y]) - MARGIN
    high = low + 2.0 * MARGIN + floor.resolution * np.array([floor.width, floor.height])
    if (points < low).any() or (points > high).any():
        raise InvalidProblem("The wish is outside the map.")
    length = float(np.hypot(*np.diff(points, axis=0).T).sum())
    if message.kind != "avoid" and length > MAX_LENGTH:  # the outline of a hall may be longer
        raise InvalidProblem("The line is too long.")
    if message.kind == "stroke" and len(points) < 2:
        raise InvalidProblem("A line to follow needs two points or more.")
    if message.kind == "avoid" and len(points) < 3 and message.radius <= 0.0:
        raise InvalidProblem("The area to avoid is empty.")


def request_of(
    mission: Mission,
    profile: RiderProfile,
    limits: Limits,
    rider: RiderSettings,
    *,
    moves: bool,
    stop: bool = False,
    over_edges: bool = False,
) -> Request:
    """Return the request to the navigator.

    For a chair that must stand the speed limit is zero: perception and planning go on.

    Args:
        mission: Mission in force.
        profile: Profile of the scenario.
        limits, rider: Settings in force.
        moves: True if the chair may move.
        stop: STOP, or the driver's wait after a fault, which ends findings of the health monitor.
        over_edges: Edges of the floor may be crossed now.
    """
    mode = mission.active_mode
    if not moves and mode.rider_drives:
        mode = Mode.SHARED  # needs no stick in order to look around
    goal = mission.goal
    return Request(
        goal=np.full(2, np.nan) if goal is None else np.array([goal.x, goal.y]),
        wishes=wishes_of(mission.wishes),
        mode=mode,
        profile=limited_profile(profile, mission.pace, limits, rider),
        speed_limit=min(PACES[mission.pace], limits.max_speed) if moves else 0.0,
        stop=stop,
        over_edges=over_edges,
        # The safety gate, too, keeps what the therapist adds to the distance of the profile.
        extra_clearance=max(limits.min_distance - profile.social_distance, 0.0),
    )


def wishes_of(wishes: Sequence[ActiveWish | RouteWish]) -> tuple[Wish, ...]:
    """Return the wishes as the planner takes them."""
    return tuple(
        Wish(kind=each.kind, points=np.array(each.points), radius=each.radius, visit=each.visit)
        for each in wishes
    )
