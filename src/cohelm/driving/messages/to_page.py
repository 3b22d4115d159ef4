"""What the chair says to a page."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cohelm.driving.messages.from_page import Echo
from cohelm.driving.messages.message import VERSION, Device, Message, Pace, WishKind
from cohelm.driving.messages.scene import Limits, RiderSettings, Scene
from cohelm.messages import Mode

Role = Literal["driver", "therapist"]
Link = Literal["nobody", "silent", "stopped", "centre", "confirm", "ready"]
"""``nobody`` drives; the driver is ``silent``; ``stopped``: STOP was pressed and the stick is still
held; ``centre``: the stick must be let go first; ``confirm``: then the driver says to go on;
``ready``: the chair does what the driver asks."""
Pose = tuple[float, float, float]


class Welcome(Message):
    """The first message of a connection."""

    type: Literal["welcome"] = "welcome"
    version: int = VERSION
    client: str
    """This page; ``State.driver`` names who drives."""
    role: Role
    scene: Scene
    limits: Limits
    rider: RiderSettings


class Configured(Message):
    """Limits or the rider's settings have changed."""

    type: Literal["configured"] = "configured"
    limits: Limits
    rider: RiderSettings


class Why(Message):
    """A reason: a stable code, and a sentence for the rider."""

    code: str
    text: str


class Person(Message):
    """Somebody whom the chair sees, with their social space: reach ahead, aside and behind, m."""

    id: int
    x: float
    y: float
    vx: float
    vy: float
    radius: float
    axis: float
    """Direction in which the space reaches furthest, rad."""
    front: float
    side: float
    rear: float
    group: int = -1


class Goal(Message):
    """Where the chair is going."""

    name: str
    """Empty for a point."""
    x: float
    y: float


class State(Message):
    """How things are; 20 times a second."""

    type: Literal["state"] = "state"
    seq: int
    time: float
    """Of the ride, s."""
    pose: Pose
    speed: float
    """Forward, m/s."""
    turn: float
    """rad/s."""
    command: tuple[float, float]
    """What goes to the wheels, (m/s, rad/s)."""
    heard: int = -1
    """``Beat.seq`` that the command heeds; −1: none."""
    driver: str | None = None
    device: Device = "none"
    link: Link = "nobody"
    mode: Mode
    pace: Pace
    eta: float
    """The rider's share, 0…1."""
    why: Why | None = None
    """Why the chair stands or is slower than wished; None: nothing holds it."""
    arrived: bool = False
    paused: bool = False
    goal: Goal | None = None
    remaining: float | None = None
    """Along the route, m."""
    route: int = 0
    """``Route.version`` that is driven."""
    ride: str = ""
    """The ride that is going on; empty: none."""
    plan: tuple[Pose, ...] = ()
    """The next two seconds."""
    people: tuple[Person, ...] = ()
    groups: tuple[tuple[tuple[float, float], ...], ...] = ()
    """Outlines of standing and walking groups."""
    bodies: tuple[tuple[float, float, float], ...] = ()
    """Everybody who is truly there, (x, y, radius): in simulation only."""
    shut: tuple[int, ...] = ()
    """Doors that are shut."""
    late: float = 0.0
    """By how much this state missed its time, ms."""
    clock: float = 0.0
    """When the command went to the wheels, by the chair's steady clock, s: it begins anywhere."""


class Wanted(Message):
    """A wish that the route heeds."""

    id: int
    kind: WishKind
    points: tuple[tuple[float, float], ...]
    radius: float


class Route(Message):
    """The way, and the one that would be taken without wishes."""

    type: Literal["route"] = "route"
    version: int
    points: tuple[tuple[float, float], ...] = ()
    without: tuple[tuple[float, float], ...] = ()
    length: float = 0.0
    extra: float = 0.0
    """Metres more than without wishes."""
    wishes: tuple[Wanted, ...] = ()
    trouble: str = ""
    """Why there is no way; empty where there is one."""


class Preview(Message):
    """What a wish would cost; ``id`` is the question's."""

    type: Literal["preview"] = "preview"
    id: int
    points: tuple[tuple[float, float], ...] = ()
    length: float = 0.0
    extra: float = 0.0
    """Metres more than the present way."""
    trouble: str = ""


class Done(Message):
    """What was asked under this number is done."""

    type: Literal["done"] = "done"
    id: int


class Refused(Message):
    """What was asked under this number is not done, and why; 0: a message that had no number."""

    type: Literal["refused"] = "refused"
    id: int = 0
    code: str
    text: str


class Notice(Message):
    """Something to be told once: who took over, a door that did not shut, a restart."""

    type: Literal["notice"] = "notice"
    code: str
    text: str


class Ended(Message):
    """A ride is over; it may be rated."""

    type: Literal["ended"] = "ended"
    ride: str
    outcome: Literal["arrived", "left", "collision"]
    time: float
    """s."""
    length: float
    """m."""


ToPage = Annotated[
    Welcome | Configured | State | Route | Preview | Done | Refused | Notice | Ended | Echo,
    Field(discriminator="type"),
]
TO_PAGE: TypeAdapter[ToPage] = TypeAdapter(ToPage)
