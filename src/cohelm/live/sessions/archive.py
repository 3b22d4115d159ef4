"""Reading of the sessions in a folder; see :mod:`.store` for its files."""

from __future__ import annotations

import contextlib
import logging
from pathlib import Path

from cohelm.errors import StoreError
from cohelm.live.sessions import report
from cohelm.live.sessions.files import make_private_folder
from cohelm.live.sessions.records import SessionInfo, SessionSummary
from cohelm.live.sessions.riders import RiderStore
from cohelm.live.sessions.session_files import (
    RIDE,
    SESSION,
    read,
    rides_in,
    session_of,
    session_sort_key,
    unknown_session,
)
from cohelm.live.sessions.timeline import Timeline

_log = logging.getLogger(__name__)


class SessionArchive:
    """Sessions and rides in a folder, to read; a damaged record is listed with its damage.

    Args:
        folder: Created if it is missing.

    Raises:
        StoreError: The folder cannot be created or written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = make_private_folder(folder)
        self.riders = RiderStore(self.folder)

    def list(self) -> tuple[SessionSummary, ...]:
        """Return all sessions with a ride, the newest first."""
        found = []
        for each in sorted(self._folders(), key=lambda f: session_sort_key(f.name), reverse=True):
            with contextlib.suppress(StoreError):  # deleted meanwhile
                found.append(self.summary(each.name))
        return tuple(each for each in found if each.rides)

    def summary(self, session: str) -> SessionSummary:
        """Return one session.

        Raises:
            StoreError: There is no such session.
        """
        folder = self._session(session)
        try:
            facts = read(SessionInfo, folder / "session.json")
        except StoreError as error:
            _log.error("sessions: %s", error)
            facts = unknown_session(session)
        return SessionSummary(session=facts, rides=tuple(rides_in(folder)))

    def html(self, session: str) -> str:
        """Return the HTML report of a session; errors as in :meth:`summary`."""
        summary = self.summary(session)
        maps = {}
        for ride in summary.rides:
            with contextlib.suppress(StoreError):
                maps[ride.id] = self.png(ride.id)
        timelines = {}
        for ride in summary.rides:
            with contextlib.suppress(StoreError, ValueError):  # of another version, or missing
                timelines[ride.id] = Timeline.model_validate_json(self.timeline(ride.id))
        name = self.riders.name(summary.session.rider)
        return report.session_html(summary, maps, timelines, rider=name)

    def csv(self, session: str) -> str:
        """Return the CSV table of a session; errors as in :meth:`summary`."""
        return report.session_csv(self.summary(session))

    def png(self, id_: str) -> bytes:
        """Return the map of a ride, or of a session's last ride that has one.

        Raises:
            StoreError: There is no map, or not yet.
        """
        if RIDE.fullmatch(id_):
            file = self._file(id_, ".png")
        else:
            maps = [self._file(ride.id, ".png") for ride in self.summary(id_).rides]
            file = next((each for each in reversed(maps) if each.is_file()), None) or maps[-1]
        try:
            return file.read_bytes()
        except OSError:
            raise StoreError(f"there is no map of {id_}, or not yet") from None

    def timeline(self, ride: str) -> bytes:
        """Return the timeline of a ride as JSON, see :mod:`.timeline`.

        Raises:
            StoreError: There is no timeline, or not yet.
        """
        try:
            return self._ride(ride).with_suffix(".timeline").read_bytes()
        except OSError:
            raise StoreError(f"there is no timeline of {ride}, or not yet") from None

    def list_of(self, rider: str) -> tuple[SessionSummary, ...]:
        """Return the sessions of one rider with a ride, the newest first."""
        return tuple(each for each in self.list() if rider and each.session.rider == rider)

    def folders_of(self, rider: str) -> tuple[Path, ...]:
        """Return the folders of the sessions of a rider, unordered."""
        return tuple(f for f in self._folders() if rider and self._rider_of(f) == rider)

    def unreadable(self) -> int:
        """Return the number of sessions of which the rider cannot be read."""
        return sum(self._rider_of(folder) is None for folder in self._folders())

    def _rider_of(self, folder: Path) -> str | None:
        """Id of the rider of a session; None: it cannot be read."""
        try:
            return read(SessionInfo, folder / "session.json").rider
        except StoreError:
            return None

    def _folders(self) -> tuple[Path, ...]:
        """Return the folders of all sessions, unordered."""
        return tuple(f for f in self.folder.iterdir() if SESSION.fullmatch(f.name))

    def _session(self, session: str) -> Path:
        folder = self.folder / session
        if not SESSION.fullmatch(session) or not folder.is_dir():
            raise StoreError("there is no such session")
        return folder

    def _ride(self, ride: str) -> Path:
        if not RIDE.fullmatch(ride) or not self._file(ride, ".json").is_file():
            raise StoreError("there is no such ride")
        return self._file(ride, ".json")

    def _file(self, ride: str, suffix: str) -> Path:
        return self.folder / session_of(ride) / f"{ride}{suffix}"
