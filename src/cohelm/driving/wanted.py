"""What the rider wants of the chair: where to, which way, how fast, and who steers."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.driving.limits import profile_under
from cohelm.driving.messages import Floor, Goal, Limits, Pace, RiderSettings, Want, Wanted
from cohelm.driving.setup import PACES
from cohelm.errors import InvalidProblem
from cohelm.maps import Places
from cohelm.messages import Mode, Request, RiderProfile, Wish

MOST_WISHES = 12
"""At once; more are refused."""
LONGEST = 300.0
"""Line that can be drawn, m; one that goes to and fro is longer than it looks."""
MARGIN = 2.0
"""So far beyond the map's edge a wish may reach, m."""
_ALONE = frozenset({Mode.MANUAL, Mode.ASSISTED})


@dataclass(frozen=True, slots=True, kw_only=True)
class Errand:
    """All that the rider has asked for and not taken back."""

    goal: Goal | None = None
    wishes: tuple[Wanted, ...] = ()
    """In the order in which they were wished."""
    mode: Mode = Mode.SHARED
    pace: Pace = "normal"
    version: int = 0
    """Grows with every change of goal or wishes."""

    @property
    def drives(self) -> Mode:
        """The mode in which the chair drives: with nowhere to go the rider steers."""
        return self.mode if self.goal is not None or self.mode in _ALONE else Mode.ASSISTED

    @property
    def under_way(self) -> bool:
        """Whether the chair would go on with the stick let go."""
        return self.goal is not None and self.mode not in _ALONE

    def to(self, goal: Goal | None) -> Errand:
        """To another destination, or to none."""
        return replace(self, goal=goal, version=self.version + 1)

    def wishing(self, wish: Wanted) -> Errand:
        """With one wish more."""
        return replace(self, wishes=(*self.wishes, wish), version=self.version + 1)

    def without(self, wish: int | None, *, every: bool = False) -> Errand:
        """With one wish less (None: the last one), or with none."""
        if every:
            left: tuple[Wanted, ...] = ()
        elif wish is None:
            left = self.wishes[:-1]
        else:
            left = tuple(each for each in self.wishes if each.id != wish)
        return replace(self, wishes=left, version=self.version + 1)

    def steered(self, mode: Mode) -> Errand:
        """In another mode."""
        return replace(self, mode=mode)

    def paced(self, pace: Pace) -> Errand:
        """At another pace."""
        return replace(self, pace=pace)


def goal_of(place: str | None, point: tuple[float, float] | None, places: Places) -> Goal | None:
    """The destination that a page named.

    Raises:
        MapError: if no place is called so.
    """
    if place is not None:
        found = places.find(place)
        return Goal(name=found.name, x=float(found.point[0]), y=float(found.point[1]))
    if point is not None:
        return Goal(name=places.at(point), x=point[0], y=point[1])
    return None


def wish_of(want: Want, number: int) -> Wanted:
    """A wish as the chair keeps it.

    Raises:
        InvalidProblem: if it encloses nothing or leads nowhere.
    """
    if want.kind == "stroke" and len(want.points) < 2:
        raise InvalidProblem("a line to follow needs two points or more")
    if want.kind == "avoid" and len(want.points) < 3 and want.radius <= 0.0:
        raise InvalidProblem("what is to be avoided has no size")
    return Wanted(id=number, kind=want.kind, points=want.points, radius=want.radius)


def check_wish(want: Want, floor: Floor) -> None:
    """Refuse a wish that no way can heed, before anybody looks for one.

    Raises:
        InvalidProblem: if it lies off the map, or its line is too long.
    """
    points = np.array(want.points)
    low = np.array([floor.x, floor.y]) - MARGIN
    high = low + 2.0 * MARGIN + floor.resolution * np.array([floor.width, floor.height])
    if (points < low).any() or (points > high).any():
        raise InvalidProblem("that is outside the map")
    if float(np.hypot(*np.diff(points, axis=0).T).sum()) > LONGEST:
        raise InvalidProblem("that line is too long")


def request_of(
    errand: Errand,
    profile: RiderProfile,
    limits: Limits,
    rider: RiderSettings,
    *,
    moves: bool,
) -> Request:
    """What the navigator is asked.

    A chair that must stand is asked to go nowhere fast: it looks about and plans all the same.

    Args:
        errand: what the rider wants.
        profile: of the scenario.
        limits, rider: in force.
        moves: whether the chair may move.
    """
    mode = errand.drives
    if not moves and mode in _ALONE:
        mode = Mode.SHARED  # which wants no stick to look about
    return Request(
        goal=_point(errand.goal),
        wishes=tuple(wishes_of(errand.wishes)),
        mode=mode,
        profile=profile_under(profile, errand.pace, limits, rider),
        speed_limit=min(PACES[errand.pace], limits.max_speed) if moves else 0.0,
    )


def wishes_of(wanted: tuple[Wanted, ...]) -> list[Wish]:
    """The same for the planner."""
    return [
        Wish(kind=each.kind, points=np.array(each.points), radius=each.radius) for each in wanted
    ]


def _point(goal: Goal | None) -> Floats:
    return np.full(2, np.nan) if goal is None else np.array([goal.x, goal.y])
