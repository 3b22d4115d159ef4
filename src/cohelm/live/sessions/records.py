"""Stored values of sessions and rides."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path as File
from typing import NamedTuple

from cohelm.config import Model
from cohelm.folders import data_folder
from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.messages import Limits, RideOutcome
from cohelm.live.sessions.database import Database
from cohelm.messages import Mode
from cohelm.planning.alternatives.learned_preference import RouteChoice

SESSION = re.compile(r"[0-9]{8}-[0-9]{6}(-[0-9]+)?")
"""Pattern of a session's id; nothing else becomes part of a path."""
RIDE = re.compile(r"([0-9]{8}-[0-9]{6}(?:-[0-9]+)?)-r[0-9]+")
"""Pattern of a ride's id; nothing else becomes part of a path."""

OLDER = "of an older version, not read"


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
    """Smallest gap to a person, m; None: nobody was seen, or it is not measured yet."""
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


class RideBegin(NamedTuple):
    """Beginning of a ride, for the navigator's process."""

    ride: str
    """Id of the ride."""
    file: File
    """File for its log."""
    session: str
    """``SessionInfo``, JSON."""
    summary: str
    """``RideSummary`` so far, JSON."""


class RideLog(NamedTuple):
    """Answer of the navigator's process when the log of a ride is complete."""

    ride: str
    lost_ticks: int = 0
    """Number of ticks that could not be written."""
    changes: MapChanges = NO_CHANGES
    """Contradictions between map and sweeps, of earlier rides as well."""


def stored_sessions(database: Database) -> Iterator[SessionSummary]:
    """Return all sessions with their rides, in no order; rides of another version say so.

    Raises:
        StoreError: The database cannot be read.
    """
    found: dict[str, tuple[SessionInfo, list[RideSummary]]] = {}
    query = "SELECT id, session, info, summary FROM ride WHERE state != 'deleted'"
    for ride, session, info, summary in database.rows(query):
        try:
            known = SessionInfo.model_validate_json(info)
            read = RideSummary.model_validate_json(summary)
        except ValueError:
            known = unknown_session(session, OLDER)
            read = unknown_ride(ride, f"The record of this ride ({ride}) cannot be read.")
        found.setdefault(session, (known, []))[1].append(read)
    for info_, rides in found.values():
        rides.sort(key=lambda each: int(each.id.rpartition("-r")[2]))
        yield SessionSummary(session=info_, rides=tuple(rides))


def session_of(ride: str) -> str:
    """Return the id of the session that a ride belongs to."""
    return ride.rpartition("-r")[0]


def session_sort_key(session: str) -> tuple[str, int]:
    """Return the time and the number in the id of a session."""
    return session[:15], int(session[16:] or 1)


def now_utc() -> str:
    """Return the current time, ISO 8601."""
    return datetime.now(UTC).isoformat(timespec="seconds")


def unknown_session(session: str, scene: str) -> SessionInfo:
    """Return the properties of a session of which only the id is known."""
    return SessionInfo(id=session, started=_started(session), scene=scene, robot="unknown")


def unknown_ride(ride: str, error: str) -> RideSummary:
    """Return the summary of a ride of which only the id is known."""
    return RideSummary(
        id=ride,
        session=session_of(ride),
        started=_started(ride),
        seed=0,
        destination="",
        outcome="cancelled",
        duration=0.0,
        length=0.0,
        error=error,
    )


def _started(id_: str) -> str:
    """Time in an id, ISO 8601; that of 1970 if there was no such time."""
    try:
        begun = datetime.strptime(id_[:15], "%Y%m%d-%H%M%S").astimezone()
    except (ValueError, OverflowError):
        begun = datetime.fromtimestamp(0.0, UTC)
    return begun.isoformat(timespec="seconds")
