"""Record of a ride: arrays at every control tick, and ticks for pictures."""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.maps import OccupancyGrid, Places
from cohelm.messages import Path, Reason
from cohelm.navigation import PlanReason, Tick
from cohelm.robots import Robot
from cohelm.scenarios.scenario import Scenario
from cohelm.simulation import FloorRelief, WorldSetup, is_standing
from cohelm.simulation.sensors.floor_relief import FLAT

GOAL_RADIUS = 0.2
"""Distance from the goal at which it is reached, m."""


class Outcome(StrEnum):
    """End of a ride."""

    REACHED = "reached"
    """Within 0.2 m of the goal, and at a standstill within 2 s."""
    COLLISION = "collision"
    """The footprint touched a person or a wall while the chair moved."""
    FELL = "fell"
    """A wheel dropped over an edge that the chair cannot take."""
    STOPPED = "stopped"
    """The chair stood for longer than ``standing_limit``."""
    TIMEOUT = "timeout"
    """The time limit came first."""
    ENDED = "ended"
    """An observer of the ride ended it early."""


@value
class StopEvent:
    """Interval in which the chair stood or braked for a reason."""

    time: float
    """Start, s."""
    duration: float
    """s."""
    reason: Reason
    detail: str = ""
    """Explanation of a missing path, with places and widths."""


@value
class Replan:
    """New path that replaces another one."""

    time: float
    """Time, s."""
    why: PlanReason
    points: Annotated[Floats, Shape("m 2")]
    """The new path, m."""


@value
class Ride:
    """One ride: k control ticks, n people, w via points; ground truth unless stated otherwise."""

    scenario: Scenario
    seed: int
    outcome: Outcome
    robot: Robot
    grid: OccupancyGrid
    """Map of the navigator."""
    world: OccupancyGrid
    """True occupancy."""
    places: Places = Places()
    """Named places of the map."""
    goal: Annotated[Floats, Shape("2")]
    prefer: Annotated[Floats, Shape("w 2")]
    """Via points that attract the route, m."""

    step: float
    """Time between ticks, s."""
    time: Annotated[Floats, Shape("k")]
    pose: Annotated[Floats, Shape("k 3")]
    twist: Annotated[Floats, Shape("k 3")]
    command: Annotated[Floats, Shape("k 3")]
    """Twist sent to the wheels."""
    requested: Annotated[Floats, Shape("k 3")]
    """Twist that the rider's stick requests; NaN without a device."""
    stick: Annotated[Floats, Shape("k 2")]
    """(forward, left), −1…1; NaN without a device."""
    eta: Annotated[Floats, Shape("k")]
    """Authority of the rider η; 0 without a device."""
    gap_people: Annotated[Floats, Shape("k n")]
    """Distance from footprint to body, m; ≤ 0 is a contact, +inf where a person is absent."""
    gap_wall: Annotated[Floats, Shape("k")]
    """Distance from footprint to walls and obstacles, m."""
    hit_moving: Annotated[Booleans, Shape("k n")]
    """Contact since the previous tick while the chair moved."""
    hit_standing: Annotated[Booleans, Shape("k n")]
    """Contact since the previous tick while the chair stood."""
    hit_wall: Annotated[Booleans, Shape("k")]
    """Contact with a wall since the previous tick."""
    people: Annotated[Floats, Shape("k n 4")]
    """(x, y, v_x, v_y); NaN where a person is absent."""
    people_heading: Annotated[Floats, Shape("k n")]
    """rad."""
    people_target: Annotated[Integers, Shape("k n")]
    """Index of each person's next waypoint."""
    people_radius: Annotated[Floats, Shape("n")]
    people_see: Annotated[Booleans, Shape("n")] | None = None
    """People who may react to the chair; None: not known."""

    setup: WorldSetup | None = None
    """Setup of the world; None: not known."""

    stops: tuple[StopEvent, ...] = ()
    path: Path | None = None
    """First path."""
    replans: tuple[Replan, ...] = ()
    """All later paths."""
    ticks: tuple[Tick, ...] = ()
    """Ticks of the navigator, two per second."""
    closest: Tick | None = None
    """Tick with the smallest gap to a person."""
    durations: Mapping[str, Floats]
    """Thread CPU time of each tick, s, (k,): by stage, and their sum as ``tick``."""

    @property
    def relief(self) -> FloorRelief:
        """Heights of the floor; level where they are not known."""
        return FLAT if self.setup is None else self.setup.relief

    @property
    def standing(self) -> Booleans:
        """Ticks at which the chair stands, (k,)."""
        return is_standing(self.twist)

    @property
    def nearest(self) -> Floats:
        """Gap to the nearest person, clipped at 0, (k,), m; +inf without people."""
        nearest: Floats = self.gap_people.min(axis=1, initial=float("inf")).clip(min=0.0)
        return nearest
