"""What a page says to the chair and the chair to a page: one union each way, and one version.

Everything crosses the wire as one JSON object a message, told apart by ``type``. Units are SI, the
frame is the map's (REP-103). What comes from a page is bounded in every number and every length:
``FromPage`` refuses the rest before anybody looks at it.
"""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cohelm.config import Model
from cohelm.messages import Mode

VERSION = 1
"""Of the messages; grows with every change that a page of before would not understand."""
LARGEST = 16_384
"""A message from a page is no longer than this, bytes."""

Finite = Annotated[float, Field(allow_inf_nan=False, ge=-1e6, le=1e6)]
Point = Annotated[tuple[Finite, Finite], Field(description="(x, y), m")]
Line = Annotated[tuple[Point, ...], Field(min_length=1, max_length=300)]
Deflection = Annotated[float, Field(allow_inf_nan=False, ge=-1.0, le=1.0)]
Name = Annotated[str, Field(min_length=1, max_length=80)]
Device = Literal["none", "joystick", "gamepad", "keys", "switch"]
Pace = Literal["slow", "normal", "brisk"]
WishKind = Literal["attract", "avoid", "stroke"]
Number = Annotated[int, Field(ge=0, le=2**53 - 1)]


class Message(Model):
    """One message; frozen, and nothing in it that is not declared."""


# From a page


class Beat(Message):
    """The page is alive, and this is where its stick is; ten times a second and at every change."""

    type: Literal["beat"] = "beat"
    seq: Number
    """Grows with every beat of a connection; one that does not is dropped."""
    sent: Annotated[float, Field(allow_inf_nan=False, ge=0.0, le=1e15)]
    """By the page's own steady clock, ms; how late a beat is shows in it."""
    forward: Deflection = 0.0
    left: Deflection = 0.0
    device: Device = "none"
    """What steers; ``none``: nothing is touched, and the chair is only told that somebody is
    there."""
    visible: bool = True
    """False in the last beat of a page that is hidden, blurred or closed: stop, do not wait."""


class Take(Message):
    """This page wants to drive; who drove before is told and does not any more."""

    type: Literal["take"] = "take"


class Release(Message):
    """This page drives no more; the chair stands."""

    type: Literal["release"] = "release"


class Stop(Message):
    """STOP, from anybody who is signed in, in any state."""

    type: Literal["stop"] = "stop"


class Resume(Message):
    """The driver confirms that the chair may move again; heeded with the stick centred only."""

    type: Literal["resume"] = "resume"


class Go(Message):
    """A new destination: a place by its name, or a point; neither: no destination any more."""

    type: Literal["go"] = "go"
    id: Number = 0
    place: Name | None = None
    point: Point | None = None


class Want(Message):
    """“Go this way” or “not this way”; with ``preview`` only its price is asked for."""

    type: Literal["want"] = "want"
    id: Number = 0
    kind: WishKind
    points: Line
    radius: Annotated[float, Field(ge=0.0, le=20.0)] = 0.0
    preview: bool = False


class Unwant(Message):
    """Take back one wish, the last one (``wish`` is None), or all of them."""

    type: Literal["unwant"] = "unwant"
    id: Number = 0
    wish: Number | None = None
    all: bool = False


class SetMode(Message):
    """Who steers."""

    type: Literal["mode"] = "mode"
    id: Number = 0
    mode: Mode


class SetPace(Message):
    """How fast, within the therapist's limits."""

    type: Literal["pace"] = "pace"
    id: Number = 0
    pace: Pace


class Rate(Message):
    """How a ride was, 1 to 5, as a person says."""

    type: Literal["rate"] = "rate"
    id: Number = 0
    ride: Name
    rating: Annotated[int, Field(ge=1, le=5)]


class Simulate(Message):
    """What only a simulation can: somebody comes, a door shuts, time stands still."""

    type: Literal["simulate"] = "simulate"
    id: Number = 0
    what: Literal["person", "walker", "door", "pause", "restart"]
    point: Point | None = None
    """``person``: where; None: near the chair. ``walker`` comes into the chair's way."""
    door: Number | None = None
    on: bool = True
    """``door``: shut it, or open it; ``pause``: stand still, or go on."""
    seed: Annotated[int, Field(ge=0, le=2**31 - 1)] | None = None
    """``restart``: with which; None: with the same."""


class Echo(Message):
    """Answered at once with the same number: the link's own time."""

    type: Literal["echo"] = "echo"
    id: Number = 0


FromPage = Annotated[
    Beat
    | Take
    | Release
    | Stop
    | Resume
    | Go
    | Want
    | Unwant
    | SetMode
    | SetPace
    | Rate
    | Simulate
    | Echo,
    Field(discriminator="type"),
]
FROM_PAGE: TypeAdapter[FromPage] = TypeAdapter(FromPage)


# To a page

Role = Literal["driver", "therapist"]
Link = Literal["nobody", "silent", "stopped", "centre", "confirm", "ready"]
"""``nobody`` drives; the driver is ``silent``; ``stopped``: STOP was pressed and the stick is still
held; ``centre``: the stick must be let go first; ``confirm``: then the driver says to go on;
``ready``: the chair does what the driver asks."""
Pose = tuple[float, float, float]


class Place(Message):
    """Somewhere with a name."""

    name: str
    x: float
    y: float


class Doorway(Message):
    """A door that can be shut in simulation: where it is across, from a to b."""

    id: int
    a: tuple[float, float]
    b: tuple[float, float]


class Floor(Message):
    """The map's picture and where it lies: its lower left corner, and metres a pixel."""

    image: str
    """Path of a PNG on the same server; it changes with the map."""
    width: int
    height: int
    resolution: float
    x: float
    y: float


class Chair(Message):
    """The chair that is driven; its outline about the middle of the drive axle, m."""

    name: str
    outline: tuple[tuple[float, float], ...]
    max_speed: float
    max_turn_rate: float


class Limits(Message):
    """What only the therapist changes."""

    max_speed: Annotated[float, Field(ge=0.1, le=3.0)]
    """m/s."""
    max_acceleration: Annotated[float, Field(ge=0.1, le=2.0)]
    """m/s²; braking is never limited by it."""
    min_distance: Annotated[float, Field(ge=0.0, le=2.0)]
    """Least distance kept from people, m."""


class RiderSettings(Message):
    """How this rider's hand and switch are understood."""

    tremor_filter: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Time constant of the low-pass on the stick, s; 0 is off."""
    dead_zone: Annotated[float, Field(ge=0.0, le=0.6)] = 0.08
    """Deflection below which the stick counts as centred."""
    dwell: Annotated[float, Field(ge=0.3, le=5.0)] = 1.2
    """How long a switch's scanning rests on each choice, s."""


class Scene(Message):
    """What does not change while the chair drives."""

    name: str
    description: str
    simulation: bool
    seed: int
    floor: Floor
    places: tuple[Place, ...]
    doors: tuple[Doorway, ...]
    chair: Chair
    modes: tuple[Mode, ...]


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
