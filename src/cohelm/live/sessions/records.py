"""Stored values of sessions and rides."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path as File

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.folders import data_folder
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.messages import Limits, RideOutcome
from cohelm.messages import Mode, Path
from cohelm.planning.alternatives.learned_preference import RouteChoice


def default_folder() -> File:
    """Return the default folder: ``$XDG_DATA_HOME/cohelm/sessions``."""
    return data_folder("sessions")


class SessionInfo(Model):
    """Properties that stay the same during a session."""

    id: str
    """Start time as ``20260131-142530``; a second one in the same second gets a number."""
    started: str
    """ISO 8601, UTC."""
    scene: str
    """Name of the scenario or map."""
    robot: str
    simulation: bool = True
    rider: str = ""
    """Id of the rider, see ``sessions.riders``; empty: nobody was chosen."""


class LimitsAt(Model):
    """Limits in force from a time on."""

    time: float
    """Time since the beginning of the ride, s."""
    limits: Limits


class RideStop(Model):
    """Stop or braking during a ride, with its reason."""

    time: float
    """Time since the beginning of the ride, s."""
    duration: float
    """s."""
    code: str
    text: str


class RideSummary(Model):
    """Stored summary of a ride."""

    id: str
    """Id of the session with a number, as ``20260131-142530-r1``."""
    session: str
    started: str
    """ISO 8601, UTC."""
    seed: int
    destination: str
    """Name of a place, coordinates of a point, or ``""``: no destination."""
    outcome: RideOutcome
    duration: float
    """s."""
    length: float
    """m."""
    modes: Mapping[Mode, float] = {}
    """Duration of each mode, s."""
    devices: Mapping[str, float] = {}
    """Duration of each input device, s."""
    wishes: int = 0
    """Number of active wishes at the end."""
    limits: tuple[LimitsAt, ...] = ()
    """Limits in force, in order of time."""
    stops: tuple[RideStop, ...] = ()
    choice: RouteChoice | None = None
    """Choice of the route before the trip; None: there was nothing to choose."""
    nearest: float | None = None
    """Smallest gap to a person, m, known before the measures are; None: nobody was seen."""
    rating: int | None = None
    """1 to 5; None: not rated."""
    measures: Mapping[str, float] = {}
    """Measures of :mod:`cohelm.evaluation.metrics` that apply to this ride."""
    error: str = ""
    """Reason why there are no measures; empty if they exist or are being computed."""


class SessionSummary(Model):
    """Session with its rides, the oldest first."""

    session: SessionInfo
    rides: tuple[RideSummary, ...] = ()


@value
class RideLog:
    """Log that the navigator's process delivers at the end of a ride; its rows stay in a file."""

    ride: str
    file: File
    """File with the rows of the ride; see :mod:`.ride_log`."""
    outcome: RideOutcome
    step: float
    """Mean time between ticks, s; a late navigator skips some."""
    goal: Annotated[Floats, Shape("2")]
    """m; NaN: no destination."""
    stops: tuple[RideStop, ...]
    path: Path | None
    """First route; None: there was none."""
    nearest: float = math.inf
    """Smallest gap to a person, clipped at 0, m."""
    lost_rows: int = 0
    """Number of ticks that could not be written."""
    changes: MapChanges = NO_CHANGES
    """Contradictions between map and sweeps, of earlier rides as well."""
    prefer: Annotated[Floats, Shape("w 2")]
    """Points that attracted the first route, m."""
