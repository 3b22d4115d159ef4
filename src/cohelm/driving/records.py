"""What is kept of a session: its rides, each with how it went and what was in force."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path as File
from typing import Literal

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.driving.messages import Limits
from cohelm.messages import Mode, Path

Outcome = Literal["arrived", "left", "collision"]
"""``left``: it was on the way still, at a new destination, none any more, or the session's end."""


def default_folder() -> File:
    """Where everything is kept: ``$XDG_DATA_HOME/cohelm/sessions``."""
    data = os.environ.get("XDG_DATA_HOME", "")
    root = File(data) if File(data).is_absolute() else File.home() / ".local" / "share"
    return root / "cohelm" / "sessions"


class SessionFacts(Model):
    """What does not change while a session goes on."""

    id: str
    """When it began, as ``20260131-142530``; with a number behind where there were two."""
    began: str
    """ISO 8601, UTC."""
    scene: str
    """Name of the scenario or map."""
    robot: str
    simulation: bool = True


class InForceAt(Model):
    """Limits from a moment of the ride on."""

    time: float
    """Of the ride, s."""
    limits: Limits


class StopNote(Model):
    """A while in which the chair stood or braked, and why."""

    time: float
    """Of the ride, s."""
    duration: float
    """s."""
    code: str
    text: str


class RideRecord(Model):
    """One ride, as it is kept."""

    id: str
    """The session's with a number behind, as ``20260131-142530-r1``."""
    session: str
    began: str
    """ISO 8601, UTC."""
    seed: int
    destination: str
    """A place's name, a point in words, or ``""``: driven without one."""
    outcome: Outcome
    time: float
    """s."""
    length: float
    """m."""
    modes: Mapping[Mode, float] = {}
    """How long each was used, s."""
    devices: Mapping[str, float] = {}
    """How long each steered, s."""
    wishes: int = 0
    """How many the route heeded at the end."""
    limits: tuple[InForceAt, ...] = ()
    """Those in force, each from its moment on."""
    stops: tuple[StopNote, ...] = ()
    rating: int | None = None
    """1 to 5, as a person said; None: nobody did."""
    measures: Mapping[str, float] = {}
    """Of :mod:`cohelm.evaluation.metrics`, those that have a meaning in this ride."""
    trouble: str = ""
    """Why there are no measures; empty where they are there or still being taken."""


class SessionSummary(Model):
    """A session with its rides, the oldest first."""

    facts: SessionFacts
    rides: tuple[RideRecord, ...] = ()


@value
class RideLog:
    """What the navigator's process hands over when a ride ends; small, the rows stay in a file."""

    ride: str
    file: File
    """Holds the rows of the ride; see :mod:`.logbook`."""
    outcome: Outcome
    step: float
    """Between ticks, s; on the whole, for a navigator that is late leaves some out."""
    goal: Annotated[Floats, Shape("2")]
    """NaN: driven without one."""
    stops: tuple[StopNote, ...]
    path: Path | None
    """The first route; None: there never was one."""
    prefer: Annotated[Floats, Shape("w 2")]
    """The points that should have attracted the first route, m."""
