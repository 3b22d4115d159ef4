"""What a ride leaves behind: arrays at every control tick, and a tick now and then for pictures."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.evaluation.scenario import Scenario
from cohelm.maps import OccupancyGrid, Places
from cohelm.messages import Path, Reason
from cohelm.navigation import Tick, Why
from cohelm.robots import Robot
from cohelm.simulation import WorldSetup, is_standing

GOAL_RADIUS = 0.2
"""Within this of the goal the chair is there, m."""


class Outcome(StrEnum):
    """How a ride ended."""

    REACHED = "reached"
    """Within 0.2 m of the goal, and standing still within 2 s of coming there."""
    COLLISION = "collision"
    """The footprint touched a person or a wall while the chair moved."""
    STOPPED = "stopped"
    """The chair stood for more than 20 s and said why."""
    TIMEOUT = "timeout"
    """The time limit came first."""


@value
class Stop:
    """A while in which the chair stood or braked and said why."""

    time: float
    """When it began, s."""
    duration: float
    """s."""
    reason: Reason
    detail: str = ""
    """Of a path that there is not: why, with places and widths."""


@value
class Replan:
    """A new path in place of another one."""

    time: float
    """When, s."""
    why: Why
    points: Annotated[Floats, Shape("m 2")]
    """The new path, m."""


@value
class Ride:
    """One ride: k control ticks, n people, w wishes. Truth, unless a field says otherwise."""

    scenario: Scenario
    seed: int
    outcome: Outcome
    robot: Robot
    grid: OccupancyGrid
    """The map as the navigator has it."""
    world: OccupancyGrid
    """All that truly stands there."""
    places: Places = Places()
    """Named on the map."""
    goal: Annotated[Floats, Shape("2")]
    prefer: Annotated[Floats, Shape("w 2")]
    """The points that should attract the route."""

    step: float
    """Between ticks, s."""
    time: Annotated[Floats, Shape("k")]
    pose: Annotated[Floats, Shape("k 3")]
    twist: Annotated[Floats, Shape("k 3")]
    command: Annotated[Floats, Shape("k 3")]
    """The twist sent to the wheels."""
    asked: Annotated[Floats, Shape("k 3")]
    """The twist that the rider's stick asks for; NaN where there is no device."""
    stick: Annotated[Floats, Shape("k 2")]
    """(forward, left), −1…1; NaN where there is no device."""
    eta: Annotated[Floats, Shape("k")]
    """η; 0 where there is no device."""
    gap_people: Annotated[Floats, Shape("k n")]
    """Footprint to body, m; ≤ 0 is a contact, +inf where a person is not there."""
    gap_wall: Annotated[Floats, Shape("k")]
    """Footprint to whatever stands there, m."""
    hit_moving: Annotated[Booleans, Shape("k n")]
    """Touched since the tick before, while the chair moved."""
    hit_standing: Annotated[Booleans, Shape("k n")]
    """Touched since the tick before, while the chair stood."""
    hit_wall: Annotated[Booleans, Shape("k")]
    """A wall was touched since the tick before."""
    people: Annotated[Floats, Shape("k n 4")]
    """(x, y, v_x, v_y); NaN where a person is not there."""
    people_heading: Annotated[Floats, Shape("k n")]
    """rad."""
    people_target: Annotated[Integers, Shape("k n")]
    """Index of the way-point that each walks to."""
    people_radius: Annotated[Floats, Shape("n")]
    people_see: Annotated[Booleans, Shape("n")] | None = None
    """Who may react to the chair; None: nobody said."""

    setup: WorldSetup | None = None
    """What the world was made of; None: nobody said."""

    stops: tuple[Stop, ...] = ()
    path: Path | None = None
    """The first route."""
    replans: tuple[Replan, ...] = ()
    """Every other one."""
    ticks: tuple[Tick, ...] = ()
    """The navigator's ticks, two a second."""
    closest: Tick | None = None
    """The tick nearest to a person."""
    durations: Mapping[str, Floats]
    """Thread CPU time of each tick, s, (k,): by stage, and their sum as ``tick``."""

    @property
    def standing(self) -> Booleans:
        """Where the chair stands still, (k,)."""
        return is_standing(self.twist)

    @property
    def nearest(self) -> Floats:
        """Gap to the nearest person, clipped at 0, (k,), m; +inf where there is nobody."""
        nearest: Floats = self.gap_people.min(axis=1, initial=float("inf")).clip(min=0.0)
        return nearest
