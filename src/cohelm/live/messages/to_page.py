"""Messages from the chair to a page."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cohelm.live.messages.from_page import Echo
from cohelm.live.messages.message import (
    VERSION,
    Device,
    Pace,
    RouteFigures,
    WireMessage,
    WishKind,
)
from cohelm.live.messages.scene import EdgeCells, Limits, MapDifferences, RiderSettings, SceneInfo
from cohelm.messages import Mode

Role = Literal["driver", "therapist"]
LinkStatus = Literal["no_driver", "no_heartbeat", "stick_held", "centre_stick", "confirm", "ready"]
"""State of the link to the driver.

``no_driver``; ``no_heartbeat``: the driver's page is silent; ``centre_stick``: once the stick is
released the chair moves on; ``stick_held``: the driver must release the stick, and then confirm;
``confirm``: the driver must confirm; ``ready``: the chair follows the driver.
"""
Pose = tuple[float, float, float]
RideOutcome = Literal["arrived", "cancelled", "collision", "fell"]
"""``cancelled``: the ride ended on the way, by a new destination, none, or the session's end."""


class Welcome(WireMessage):
    """First message of a connection."""

    type: Literal["welcome"] = "welcome"
    version: int = VERSION
    client: str
    """Name of this page; ``ChairState.driver`` is the name of the page that drives."""
    role: Role
    scene: SceneInfo
    limits: Limits
    rider: RiderSettings


class SettingsChanged(WireMessage):
    """New limits or rider's settings."""

    type: Literal["settings_changed"] = "settings_changed"
    limits: Limits
    rider: RiderSettings


class ReasonText(WireMessage):
    """Reason for a stop or a slower speed: a stable code, and a sentence for the rider."""

    code: str
    text: str


class PersonInfo(WireMessage):
    """Tracked person and the extent of their social space ahead, aside and behind, m."""

    id: int
    x: float
    y: float
    vx: float
    vy: float
    radius: float
    axis: float
    """Direction of the largest extent, rad."""
    front: float
    side: float
    rear: float
    group: int = -1
    """Id of the person's group; −1: none."""
    seen: bool = True
    """False: remembered, no scanner sees them now."""


class Destination(WireMessage):
    """Place or point that the chair drives to; x, y in m."""

    name: str
    """Empty for a point."""
    x: float
    y: float


class OfferInfo(WireMessage):
    """Place that the rider may want to go to; ``SetGoal`` chooses it, nothing else does."""

    name: str
    slot: int
    """Position among the offers, 0…2; an offer keeps it while it is shown."""
    highlighted: bool
    why: str
    """Why it is believed, in the rider's words."""


class NavigatorState(WireMessage):
    """Part of the state that the navigator's process computes."""

    rider_authority: float
    """Rider's share η of the control authority, 0…1."""
    remaining: float | None = None
    """Distance along the route, m."""
    plan: tuple[Pose, ...] = ()
    """Poses of the next two seconds."""
    people: tuple[PersonInfo, ...] = ()
    groups: tuple[tuple[tuple[float, float], ...], ...] = ()
    """Outlines of standing and walking groups, m."""
    offers: tuple[OfferInfo, ...] = ()
    """Destinations that the rider may want, at most three; empty with a destination."""
    free: tuple[float, ...] = ()
    """Free distance from the chair's outline in 36 directions, from ahead counter-clockwise, m;
    −1: no scanner looks there. Empty without a planar scanner."""


class Preparing(WireMessage):
    """Progress of compiling for this computer, at the first start."""

    share: float
    """What is done, 0…1."""
    left: float | None = None
    """Time left, s; None: not known yet."""


class ChairState(NavigatorState):
    """State of chair, link and route; sent 20 times a second, more seldom without a world."""

    type: Literal["state"] = "state"
    seq: int
    time: float
    """Time of the simulation, s."""
    pose: Pose
    speed: float
    """Forward, m/s."""
    turn_rate: float
    """rad/s."""
    command: tuple[float, float]
    """Command at the wheels, (m/s, rad/s)."""
    heartbeat: int = -1
    """``Heartbeat.seq`` that the command is based on; −1: none."""
    driver: str | None = None
    device: Device = "none"
    link: LinkStatus = "no_driver"
    mode: Mode
    pace: Pace
    reason: ReasonText | None = None
    """Reason why the chair stands or is slower than requested; None: nothing holds it."""
    not_ready: ReasonText | None = None
    """What ``ResumeCommand`` cannot end, whatever it answers; None: it is enough."""
    can_plan: bool = True
    """True if ``PlanTrip`` would be answered now."""
    preparing: Preparing | None = None
    """None: everything is compiled; else there are no destinations yet."""
    arrived: bool = False
    paused: bool = False
    goal: Destination | None = None
    route_version: int = 0
    """``RouteUpdate.version`` of the route in use."""
    ride: str = ""
    """Id of the current ride; empty: none."""
    true_people: tuple[tuple[float, float, float], ...] = ()
    """Ground truth of all people, (x, y, radius), m; in simulation only."""
    closed_doors: tuple[int, ...] = ()
    """Ids of closed doors."""
    lateness: float = 0.0
    """Delay of the start of this step after its deadline, ms."""
    rate: float = 1.0
    """Speed of simulated time, 1: real time; below, this computer is too slow."""
    unstored: str = ""
    """What cannot be stored, and why; empty: everything is."""
    clock: float = 0.0
    """Time just before the command was selected, by the chair's monotonic clock, s."""


class ActiveWish(WireMessage):
    """Wish that the route takes into account."""

    id: int
    kind: WishKind
    points: tuple[tuple[float, float], ...]
    radius: float
    visit: bool = False


RouteCause = Literal[
    "first",
    "goal",
    "wish",
    "blocked",
    "off_path",
    "stalled",
    "backed_up",
    "turn",
    "steering",
]
"""Cause of planning a route: ``navigation.PlanReason``."""


class RouteUpdate(WireMessage):
    """Route of the chair, and the route without wishes."""

    type: Literal["route"] = "route"
    version: int
    points: tuple[tuple[float, float], ...] = ()
    without_wishes: tuple[tuple[float, float], ...] = ()
    length: float = 0.0
    """m."""
    extra_length: float = 0.0
    """Difference from the route without wishes, m."""
    wishes: tuple[ActiveWish, ...] = ()
    error: str = ""
    """Reason why there is no route; empty if there is one."""
    cause: RouteCause = "first"


class RouteDifference(WireMessage):
    """Noticeable difference of a route from the first one."""

    what: Literal["length", "clearance", "encounters", "turns", "doors"]
    more: float
    """Of the route, less that of the first one; m, m, people, turns, narrow passages."""


class TripRoute(WireMessage):
    """Route to choose from."""

    points: tuple[tuple[float, float], ...]
    """m."""
    length: float
    """m."""
    duration: float
    """Travel time at the chosen pace without people in the way, s."""
    differences: tuple[RouteDifference, ...] = ()
    """The most important first; empty for the first route."""
    via: tuple[float, float] | None = None
    """Point to wish for in order to get this route; None: it needs none."""
    figures: RouteFigures


class TripPlans(WireMessage):
    """Answer to ``PlanTrip``: the routes to choose from, the best first."""

    type: Literal["trip_plans"] = "trip_plans"
    id: int
    routes: tuple[TripRoute, ...] = ()
    extra_length: float = 0.0
    """Additional length of the planner's own route due to the wishes, m."""
    closest: tuple[float, ...] = ()
    """Minimum distance of that route from each point to go via, in their order, m."""
    through: tuple[float, ...] = ()
    """Length of that route within each area to avoid, in their order, m."""
    learned: bool = False
    """The order is the rider's, learned from their choices; otherwise the planner's."""
    complete: bool = True
    """False: alternatives are still looked for; they come in another answer with this ``id``."""
    error: str = ""
    """Reason why there is no route; empty if there is one."""


class Accepted(WireMessage):
    """Positive answer to the request with this number."""

    type: Literal["accepted"] = "accepted"
    id: int


class Rejected(WireMessage):
    """Negative answer to the request with this number; 0: the message had no number."""

    type: Literal["rejected"] = "rejected"
    id: int = 0
    code: str
    text: str


class Notice(WireMessage):
    """Event to show once: a take-over, a restart, a failure."""

    type: Literal["notice"] = "notice"
    code: str
    text: str


class RideEnded(WireMessage):
    """End of a ride; the rider may rate it."""

    type: Literal["ride_ended"] = "ride_ended"
    ride: str
    outcome: RideOutcome
    duration: float
    """s."""
    length: float
    """m."""


ToPage = Annotated[
    Welcome
    | SettingsChanged
    | ChairState
    | RouteUpdate
    | MapDifferences
    | EdgeCells
    | TripPlans
    | Accepted
    | Rejected
    | Notice
    | RideEnded
    | Echo,
    Field(discriminator="type"),
]
TO_PAGE: TypeAdapter[ToPage] = TypeAdapter(ToPage)
Send = Callable[[ToPage, str | None], None]
"""Sends a message to the page of that client; None: to all pages. It neither waits nor raises."""
