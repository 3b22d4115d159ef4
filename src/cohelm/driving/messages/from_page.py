"""What a page says to the chair."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field, TypeAdapter

from cohelm.driving.messages.message import (
    Deflection,
    Device,
    Line,
    Message,
    Name,
    Number,
    Pace,
    Point,
    WishKind,
)
from cohelm.messages import Mode


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
