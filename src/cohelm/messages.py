"""Every value that flows: the language of the project. Read this file first.

    scan ─► people ─► predictions ─► spaces ──────┐
    goal ─► path ───► reference ─┐                ├─► local plan ─► decision ─► wheels
    rider ─► authority ──────────┴► shared ref. ──┘

All values are frozen and check the shapes of their arrays (``arrays.value``). SI units and REP-103
(metres, seconds, radians, x forward, y left); positions and poses are in the map frame unless a
field says otherwise. A *twist* is (v_x, v_y, ω) in the robot frame. n people, h hypotheses a
person, N horizon steps (N+1 states), k points. The ``Tick``, which binds them all, is in
``navigation.tick``, because it also holds each stage's memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from enum import StrEnum
from types import MappingProxyType
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Integers, Shape, value
from cohelm.config import Model
from cohelm.reasons import Reason

# --------------------------------------------------------------------------- what goes in


class Mode(StrEnum):
    """Who steers. Not a planner: there is no planner called manual."""

    AUTONOMOUS = "autonomous"
    """The chair alone."""
    SHARED = "shared"
    """The reference blends the path and the rider's hand by η."""
    ASSISTED = "assisted"
    """The rider alone, behind the whole safety gate, separation included."""
    MANUAL = "manual"
    """The rider alone; the gate checks freshness, NaN and limits only, so it can collide."""


class RiderProfile(Model):
    """What this rider likes, as the introduction of Xu et al. asks for; the values are assumed."""

    preferred_speed: float = Field(0.8, gt=0.0, le=3.0)
    """Cruising speed, m/s; bounded by the robot's limit."""
    clearance: float = Field(0.05, ge=0.0, le=1.0)
    """Distance kept from walls beyond the footprint, m."""
    social_distance: float = Field(0.45, ge=0.0, le=2.0)
    """Least reach of a person's social space, m (Hall's intimate distance)."""
    passing_side: Literal["left", "right", "none"] = "none"
    """Side on which to pass a person, where both are as good. No part reads it yet."""
    tremor_filter: float = Field(0.0, ge=0.0, le=1.0)
    """Time constant of the low-pass on the stick, s; 0 is off."""
    dead_zone: float = Field(0.05, ge=0.0, lt=1.0)
    """Deflection below which the stick counts as centred, share of full deflection."""


@value
class Wish:
    """Where the rider wants the route to go, or not to.

    The points of one wish are passed in their order; wishes among themselves in whatever order is
    best.
    """

    kind: Literal["attract", "avoid", "stroke"] = "attract"
    """``attract``: pass near each point; ``stroke``: follow the line; ``avoid``: keep out of the
    zone: about a point or a line of two as far as ``radius``, or within a drawn outline of three
    points and more, and as far beyond."""
    points: Annotated[Floats, Shape("k 2")]
    """(x, y), m."""
    radius: float = 0.0
    """Reach of an avoided zone beyond its points, m."""
    hard: bool = False
    """Of an avoided zone: never enter it, even if no way is left; else only rather not."""


@value
class Request:
    """What is wanted; may change in mid-ride."""

    goal: Annotated[Floats, Shape("2")]
    """(x, y), m."""
    wishes: tuple[Wish, ...] = ()
    mode: Mode = Mode.SHARED
    profile: RiderProfile = RiderProfile()
    speed_limit: float = np.inf
    """m/s."""
    stop: bool = False
    """The STOP control is pressed."""


@value
class Scan:
    """One sweep of a planar laser scanner, after sensor_msgs/LaserScan and REP-117."""

    time: float
    """When it was taken, s."""
    mount: Annotated[Floats, Shape("3")]
    """X_RL, the sensor on the robot."""
    angle_min: float
    """Direction of the first beam in the sensor's frame, rad."""
    angle_increment: float
    """From beam to beam, rad, counter-clockwise."""
    range_max: float
    """m."""
    ranges: Annotated[Floats, Shape("b")]
    """m; +inf: nothing within reach; NaN: a dropout."""


@value
class RiderCommand:
    """The rider's device. *Alive* and *deflected* are different things."""

    heartbeat: float
    """When the device was last heard, s."""
    deflection: Annotated[Floats, Shape("2")]
    """(forward, left), each −1…1 of full deflection; (0, 0) is centred."""


@value
class People:
    """Who is there, as a struct of arrays; nobody is n = 0."""

    time: float
    """s."""
    id: Annotated[Integers, Shape("n")]
    """Stable over a person's life in view."""
    mean: Annotated[Floats, Shape("n 4")]
    """(x, y, v_x, v_y), m and m/s."""
    covariance: Annotated[Floats, Shape("n 4 4")]
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad; NaN where unknown; kept from the last walk by those at rest."""
    radius: Annotated[Floats, Shape("n")]
    """Of the body's disc, m."""
    confidence: Annotated[Floats, Shape("n")]
    """0…1."""
    source: str = "tracker"
    """``tracker``: from the sensors; anything else came from outside and labels the results."""

    @staticmethod
    def nobody(time: float, source: str = "tracker") -> People:
        """No one at ``time``."""
        none = np.empty(0)
        return People(
            time=time,
            id=np.empty(0, dtype=np.int64),
            mean=none.reshape(0, 4),
            covariance=none.reshape(0, 4, 4),
            heading=none,
            radius=none,
            confidence=none,
            source=source,
        )

    def __len__(self) -> int:
        """How many people."""
        return len(self.id)


@value
class Observation:
    """All that the navigator may ever know of the world at one instant."""

    time: float
    """Now, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR, as a localiser gives it."""
    pose_time: float
    """When the localiser last spoke, s."""
    twist: Annotated[Floats, Shape("3")]
    """As odometry measures it, robot frame."""
    twist_time: float
    """When odometry last spoke, s."""
    scans: tuple[Scan, ...] = ()
    """Those that arrived since the last observation."""
    rider: RiderCommand | None = None
    """None: no device."""
    people: People | None = None
    """People given from outside, with their source named; None: see for yourself."""
    late: float = 0.0
    """By how much this tick missed its deadline, s; 0 in simulation and replay unless injected."""


# --------------------------------------------------------------------------- perception, social


@value
class StaticPoints:
    """Returns that are not people; none is dropped on the way."""

    points: Annotated[Floats, Shape("k 2")]


@value
class Groups:
    """Who belongs together."""

    id: Annotated[Integers, Shape("g")]
    member: Annotated[Integers, Shape("n")]
    """Index of each person's group, −1: alone."""

    @staticmethod
    def alone(n: int) -> Groups:
        """``n`` people, no groups."""
        return Groups(id=np.empty(0, dtype=np.int64), member=np.full(n, -1))


@value
class Predictions:
    """Where people will be: hypotheses over the horizon, a Gaussian at every step."""

    step: float
    """Time between steps, s; step 0 is now."""
    names: tuple[str, ...]
    """Of the h hypotheses."""
    weight: Annotated[Floats, Shape("n h")]
    """Probability of each hypothesis; rows sum to 1."""
    mean: Annotated[Floats, Shape("n h N+1 2")]
    """Positions, m."""
    velocity: Annotated[Floats, Shape("n h N+1 2")]
    """m/s."""
    deviation: Annotated[Floats, Shape("n h N+1")]
    """Standard deviation of the position, the larger axis, m."""


@value
class SocialSpaces:
    """The shape of each person's space over the horizon, and of the robot's own; see ``shapes``."""

    kind: int
    """``shapes.PRINTED`` or ``shapes.CONTOUR``."""
    scale: float
    """c of eq. (5)."""
    axis: Annotated[Floats, Shape("n h N+1")]
    """Direction of motion, rad; irrelevant for a circle."""
    front: Annotated[Floats, Shape("n h N+1")]
    """σ_h, m; so are the next two."""
    side: Annotated[Floats, Shape("n h N+1")]
    rear: Annotated[Floats, Shape("n h N+1")]
    floor: float
    """Least reach of a person's space, m."""
    robot: Annotated[Floats, Shape("3")]
    """The robot's own (σ_h, σ_s, σ_r) at its measured speed, m."""
    robot_floor: float = 0.0
    """Least reach of the robot's own space, m."""


@value
class Crowding:
    """Where people have been lately: a coarse grid over the floor."""

    density: Annotated[Floats32, Shape("rows cols")]
    """People per m², faded by how long ago they were seen."""
    resolution: float
    """Side of a cell, m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the grid's lower left corner in the map frame."""
    version: int = 0
    """Grows whenever the density changes by more than fading a little."""


@value
class LiveObstacles:
    """What the sensors have seen lately that is neither in the map nor a person: a rolling window.

    Cells are those of the map's grid, so that ``corner`` says which of them the window covers.
    """

    corner: Annotated[Integers, Shape("2")]
    """(row, column) of the window's first cell in the map's grid; may lie outside it."""
    occupied: Annotated[Bytes, Shape("rows cols")]
    """1 where something stands."""
    version: int
    """Grows whenever a cell changes."""


# --------------------------------------------------------------------------- planning, sharing


@value
class WishReport:
    """What a wish does to a route."""

    closest: Annotated[Floats, Shape("w")]
    """Least distance of the path to each attracting point, m."""
    along: Annotated[Floats, Shape("s")] = field(default_factory=lambda: np.empty(0))
    """Mean distance of each stroke's line to the path, m."""
    avoided: Annotated[Floats, Shape("a")] = field(default_factory=lambda: np.empty(0))
    """Least distance of the path to each avoided zone, m; negative: as deep inside."""
    extra_length: float = 0.0
    """Against the path without wishes, m."""
    extra_cost: float = 0.0
    """Against the path without wishes, in the unit of ``Path.cost``."""


@value
class Path:
    """A route from start to goal."""

    points: Annotated[Floats, Shape("k 2")]
    """m; about evenly spaced."""
    length: float
    """m."""
    cost: float
    """Length weighted by the costmap, m."""
    method: str
    """The planner's name."""
    wishes: WishReport
    without_wishes: Annotated[Floats, Shape("j 2")]
    """The path that would have been taken without wishes, m; the same where there are none."""
    score: float = 0.0
    """What the method minimises, m: weighted length and the price of the wishes; to be compared
    with ``kept_score`` only."""
    kept_score: float | None = None
    """The same of ``RouteProblem.kept``; ∞ where that is blocked by now."""
    pivots: Annotated[Integers, Shape("p")] = field(
        default_factory=lambda: np.empty(0, dtype=np.int64)
    )
    """Indices of the points where no curve that the robot can drive fits, and it must turn on the
    spot instead."""


@value
class Reference:
    """Where the robot should be over the horizon."""

    step: float
    """Time between states, s; state 0 is now."""
    poses: Annotated[Floats, Shape("N+1 3")]
    """Headings unwrapped, continuous with the robot's own."""
    speeds: Annotated[Floats, Shape("N+1")]
    """Wanted forward speed, m/s."""


@value
class Authority:
    """How much the rider steers, and where to."""

    eta: float
    """η, weight of the rider's states in the reference, 0…1; Xu et al., eq. (13) corrected."""
    intent: float
    """i, the number of intents within the time frame."""
    deflection: Annotated[Floats, Shape("2")]
    """The stick after filter and dead zone."""
    twist: Annotated[Floats, Shape("3")]
    """What the stick asks of the wheels."""
    states: Reference
    """Where the rider's command would lead."""
    wants_stop: bool = False
    """The stick is held against the travel."""


# --------------------------------------------------------------------------- control, safety


class Status(StrEnum):
    """What a local plan is."""

    OK = "ok"
    """Every constraint holds."""
    RELAXED = "relaxed"
    """Some soft constraint yields; see ``slack``. Verified all the same."""
    STOP = "stop"
    """No verified plan: braking."""


@value
class LocalPlan:
    """What the local planner wants to do next, and everything it knew when it chose."""

    time: float
    """When it was made, s."""
    step: float
    """Between states, s."""
    command: Annotated[Floats, Shape("3")]
    """Twist for the wheels."""
    poses: Annotated[Floats, Shape("N+1 3")]
    inputs: Annotated[Floats, Shape("N m")]
    """In the kinematics' own inputs, (v, ω) for a unicycle."""
    status: Status
    reason: Reason | None = None
    """Given with ``Status.STOP``."""
    costs: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """By term."""
    smallest_barrier: float = np.inf
    """Least h over people and walls along the plan, m; below 0 a social space is entered."""
    slack: float = 0.0
    """Largest yielding of a soft constraint, m."""
    iterations: int = 0
    """Quadratic programs solved."""


@value
class Decision:
    """What goes to the wheels."""

    twist: Annotated[Floats, Shape("3")]
    reason: Reason | None = None
    """None: exactly what the planner or the rider wanted."""
    emergency: bool = False
    """Brake as hard as the chair can; the twist is zero."""


__all__ = [
    "Authority",
    "Crowding",
    "Decision",
    "Groups",
    "LiveObstacles",
    "LocalPlan",
    "Mode",
    "Observation",
    "Path",
    "People",
    "Predictions",
    "Reason",
    "Reference",
    "Request",
    "RiderCommand",
    "RiderProfile",
    "Scan",
    "SocialSpaces",
    "StaticPoints",
    "Status",
    "Wish",
    "WishReport",
]
