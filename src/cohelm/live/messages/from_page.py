"""Messages from a page to the chair."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cohelm.live.messages.message import (
    Deflection,
    Device,
    Line,
    Name,
    Number,
    Pace,
    Point,
    RouteFigures,
    WireMessage,
    WishKind,
)
from cohelm.messages import Mode


class Heartbeat(WireMessage):
    """Sign of life of a page, with its stick position; sent 10 times a second and on changes."""

    type: Literal["heartbeat"] = "heartbeat"
    seq: Number
    """Grows with every heartbeat of a connection; a repeated or smaller number is dropped."""
    sent: Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1e15)]
    """Send time by the page's monotonic clock, ms; used to measure delays."""
    forward: Deflection = 0.0
    left: Deflection = 0.0
    device: Device = "none"
    """Input device in use; ``none``: the rider touches nothing, but the page is alive."""
    visible: bool = True
    """False in the last heartbeat of a page that is hidden, blurred or closed: stop at once."""


class TakeControl(WireMessage):
    """Request to drive from this page; the previous driver loses control and gets a notice."""

    type: Literal["take_control"] = "take_control"
    confirm: bool = False
    """True: confirm at once that the chair may move, as ``resume`` does, because the same press of
    the rider sets off; has no effect while another page drives."""


class ReleaseControl(WireMessage):
    """Give up control; the chair stops."""

    type: Literal["release_control"] = "release_control"


class StopCommand(WireMessage):
    """STOP, accepted from every page that is signed in, in any state."""

    type: Literal["stop"] = "stop"


class ResumeCommand(WireMessage):
    """Confirmation by the driver that the chair may move again; needs a centred stick."""

    type: Literal["resume"] = "resume"


class RouteWish(WireMessage):
    """Wish about the route of a trip."""

    kind: WishKind
    points: Line
    radius: Annotated[float, Field(ge=0.0, le=20.0)] = 0.0
    """m; of ``avoid``."""
    visit: bool = False
    """Of ``attract``: go there, however long the detour."""


class ChosenRoute(WireMessage):
    """Route of ``TripPlans`` that the rider chose."""

    figures: Annotated[tuple[RouteFigures, ...], Field(min_length=2, max_length=8)]
    """Of all routes that were shown."""
    taken: Annotated[int, Field(ge=0, le=7)]
    """Index of the chosen one."""


Wishes = Annotated[tuple[RouteWish, ...], Field(max_length=12)]


class PlanTrip(WireMessage):
    """Request for the routes to a destination; the chair and its trip stay as they are."""

    type: Literal["plan_trip"] = "plan_trip"
    id: Number = 0
    place: Name | None = None
    point: Point | None = None
    wishes: Wishes = ()
    """All wishes of the trip."""


class SetGoal(WireMessage):
    """New destination: a named place or a point; without both, the trip is cancelled."""

    type: Literal["set_goal"] = "set_goal"
    id: Number = 0
    place: Name | None = None
    point: Point | None = None
    wishes: Wishes = ()
    """All wishes of the trip."""
    choice: ChosenRoute | None = None
    """None: there was no choice."""


class SetMode(WireMessage):
    """New sharing mode."""

    type: Literal["set_mode"] = "set_mode"
    id: Number = 0
    mode: Mode


class SetPace(WireMessage):
    """New pace, within the therapist's limits."""

    type: Literal["set_pace"] = "set_pace"
    id: Number = 0
    pace: Pace


class RateRide(WireMessage):
    """Rating of a ride by a person, 1 to 5."""

    type: Literal["rate_ride"] = "rate_ride"
    id: Number = 0
    ride: Name
    rating: Annotated[int, Field(ge=1, le=5)]


class ChangeSimulation(WireMessage):
    """Change of the simulated world: add a person, move a door, pause, restart."""

    type: Literal["change_simulation"] = "change_simulation"
    id: Number = 0
    action: Literal["person", "crossing_person", "door", "pause", "restart"]
    """``person``: add a pedestrian; ``crossing_person``: add one who crosses the chair's path."""
    point: Point | None = None
    """Position of a new ``person``; None: near the chair."""
    door: Number | None = None
    on: bool = True
    """``door``: close it, or open it; ``pause``: pause, or continue."""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None
    """Seed of ``restart``; None: the current one."""


class ChangeStorey(WireMessage):
    """Report that the chair is on another storey now, as after a lift; it stands.

    The drive begins anew on the map of that storey, at the same pose, and all pages connect again.
    """

    type: Literal["change_storey"] = "change_storey"
    id: Number = 0
    storey: Name


class Echo(WireMessage):
    """Message returned at once with its number, to measure the round trip."""

    type: Literal["echo"] = "echo"
    id: Number = 0


FromPage = Annotated[
    Heartbeat
    | TakeControl
    | ReleaseControl
    | StopCommand
    | ResumeCommand
    | PlanTrip
    | SetGoal
    | SetMode
    | SetPace
    | RateRide
    | ChangeSimulation
    | ChangeStorey
    | Echo,
    Field(discriminator="type"),
]
FROM_PAGE: TypeAdapter[FromPage] = TypeAdapter(FromPage)
