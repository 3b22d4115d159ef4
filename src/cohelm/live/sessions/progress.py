"""Progress of a rider over sessions: five quantities, the goals, and whether there is a direction.

A direction is said only if chance alone would seldom produce it: Kendall's rank test of a quantity
against the order of the sessions, two-sided, at 1 %. Fewer than six sessions cannot reach that: the
most extreme order has the probability 2/n!, which is 1.7 % for five and 0.3 % for six. Five
quantities at 1 % give one false direction in twenty riders. Only sessions mostly in the mode of
the latest one are compared, because another mode changes all of the quantities.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType
from typing import Literal

from scipy.stats import kendalltau

from cohelm.config import Model
from cohelm.live.sessions.records import RideSummary, SessionSummary
from cohelm.live.sessions.report import breach_of_distance
from cohelm.live.sessions.riders import RiderGoal
from cohelm.messages import Mode

MIN_SESSIONS = 6
"""Least number of sessions that can show a direction; see above."""
SIGNIFICANCE = 0.01
"""Probability below which a direction is said."""
UNAIDED_SHARE = 0.95
"""Least share of a trip in a mode in which the chair does not steer; assumed."""
_UNAIDED_MODES = (Mode.STOP_ONLY, Mode.MANUAL)
Direction = Literal["few", "unclear", "rising", "falling"]
"""``few``: fewer than ``MIN_SESSIONS`` have a value; ``unclear``: the test finds none."""


class SessionProgress(Model):
    """Session of a rider in numbers."""

    session: str
    started: str
    """ISO 8601, UTC."""
    scene: str
    simulation: bool
    rides: int
    trips: int
    """Rides with a destination."""
    arrivals: int
    unaided: int
    """Arrivals of trips that the rider steered alone."""
    distance: float
    """m."""
    mode: Mode | None
    """Mode of the longest duration; None: nothing was driven."""
    values: Mapping[str, float | None]
    """Quantity of :data:`QUANTITIES` → its value; None: no ride has one."""


class GoalProgress(Model):
    """Goal with what is reached of it."""

    goal: RiderGoal
    reached: int
    """Number of trips; 0 or 1 for a goal in own words."""
    done: bool


class RiderProgress(Model):
    """Progress of a rider."""

    sessions: tuple[SessionProgress, ...]
    """The oldest first."""
    directions: Mapping[str, Direction]
    """Quantity → direction over the sessions in the mode of the latest one."""
    goals: tuple[GoalProgress, ...]
    min_sessions: int = MIN_SESSIONS


def rider_progress(
    sessions: Iterable[SessionSummary], goals: Iterable[RiderGoal] = ()
) -> RiderProgress:
    """Return the progress over sessions in any order, and towards the goals."""
    ordered = sorted(sessions, key=lambda each: each.session.started)
    points = tuple(_session(each) for each in ordered if each.rides)
    return RiderProgress(
        sessions=points,
        directions={
            name: direction([p.values[name] for p in points if p.mode == points[-1].mode])
            for name in QUANTITIES
        },
        goals=tuple(_goal(each, points) for each in goals),
    )


def direction(values: Iterable[float | None]) -> Direction:
    """Return the direction of values in their order; those that are missing are left out."""
    known = [each for each in values if each is not None]
    if len(known) < MIN_SESSIONS:
        return "few"
    if len(set(known)) == 1:
        return "unclear"  # no rank differs, and the test is not defined
    found = kendalltau(range(len(known)), known)
    if not found.pvalue <= SIGNIFICANCE:
        return "unclear"
    return "rising" if found.statistic > 0.0 else "falling"


def is_unaided(ride: RideSummary) -> bool:
    """Check that a trip arrived, and that the chair steered in at most 5 % of its time."""
    whole = sum(ride.modes.values())
    alone = sum(ride.modes.get(mode, 0.0) for mode in _UNAIDED_MODES)
    return _is_arrival(ride) and whole > 0.0 and alone >= UNAIDED_SHARE * whole


def _session(summary: SessionSummary) -> SessionProgress:
    facts, rides = summary.session, summary.rides
    durations: dict[Mode, float] = {}
    for ride in rides:
        for mode, seconds in ride.modes.items():
            durations[mode] = durations.get(mode, 0.0) + seconds
    return SessionProgress(
        session=facts.id,
        started=facts.started,
        scene=facts.scene,
        simulation=facts.simulation,
        rides=len(rides),
        trips=sum(bool(ride.destination) for ride in rides),
        arrivals=sum(map(_is_arrival, rides)),
        unaided=sum(map(is_unaided, rides)),
        distance=round(_distance(rides), 2),
        mode=max(durations, key=lambda mode: durations[mode]) if durations else None,
        values={name: compute(rides) for name, compute in QUANTITIES.items()},
    )


def _goal(goal: RiderGoal, points: Iterable[SessionProgress]) -> GoalProgress:
    if goal.kind == "words":
        return GoalProgress(goal=goal, reached=int(goal.done), done=goal.done)
    counts = [p.arrivals if goal.kind == "arrivals" else p.unaided for p in points]
    return GoalProgress(goal=goal, reached=sum(counts), done=sum(counts) >= goal.target)


def _is_arrival(ride: RideSummary) -> bool:
    return ride.outcome == "arrived"


def _distance(rides: Iterable[RideSummary]) -> float:
    return sum(ride.length for ride in rides)


def _arrivals(rides: tuple[RideSummary, ...]) -> float | None:
    """Share of trips that arrived; None without a trip."""
    trips = [ride for ride in rides if ride.destination]
    return sum(map(_is_arrival, trips)) / len(trips) if trips else None


def _stops(rides: tuple[RideSummary, ...]) -> float | None:
    """Stops and brakings with a reason, on 100 m; None below 1 m."""
    return _per_100_m(sum(len(ride.stops) for ride in rides), rides)


def _effort(rides: tuple[RideSummary, ...]) -> float | None:
    """Movement of the stick in full deflections, on 100 m; None if no ride has it."""
    known = tuple(ride for ride in rides if "rider_effort" in ride.measures)
    return _per_100_m(sum(ride.measures["rider_effort"] for ride in known), known)


def _reversals(rides: tuple[RideSummary, ...]) -> float | None:
    """Stick reversals, 1/min: the mean over the time of the rides; None if no ride has it."""
    known = [ride for ride in rides if "rider_reversals" in ride.measures]
    time = sum(ride.duration for ride in known)
    weighted = sum(ride.measures["rider_reversals"] * ride.duration for ride in known)
    return round(weighted / time, 4) if time > 0.0 else None


def _near_passes(rides: tuple[RideSummary, ...]) -> float | None:
    """Share of rides in which somebody was closer than the target; None if nobody was seen."""
    known = [ride for ride in rides if "min_distance" in ride.measures and ride.limits]
    near = sum(breach_of_distance(ride) is not None for ride in known)
    return near / len(known) if known else None


def _per_100_m(count: float, rides: tuple[RideSummary, ...]) -> float | None:
    length = _distance(rides)
    return round(100.0 * count / length, 4) if length >= 1.0 else None


QUANTITIES: Mapping[str, Callable[[tuple[RideSummary, ...]], float | None]] = MappingProxyType(
    {
        "arrivals": _arrivals,
        "stops": _stops,
        "effort": _effort,
        "reversals": _reversals,
        "near_passes": _near_passes,
    }
)
"""Quantity → its value from the rides of a session."""
