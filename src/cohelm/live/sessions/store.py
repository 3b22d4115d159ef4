"""Storage of sessions in one folder, which one action deletes.

    DIR/                             0700, every file in it 0600
      cohelm.sqlite                  settings, riders, audit log, and the index of the rides
      rides/20260131-142530-r1.mcap  log of a ride, see ``ride_log``

The index has the summary of each ride, its map and its timeline. A log without an entry is a ride
that was cut off, or whose index was lost: it gets one at the next start.

Every method may be called from any thread. Those that change rides do not wait for the disk, but
for the deletions: a writer thread keeps their order. :attr:`SessionStore.error` says what could not
be written; it is tried again with every further write, and by ``retry``.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import logging
import math
import shutil
import threading
import time
from collections.abc import Callable, Mapping
from concurrent.futures import Future, ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from cohelm.errors import StoreError
from cohelm.live.sessions import map_changes, report
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.files import make_private_folder
from cohelm.live.sessions.measuring import (
    MeasuringPostponed,
    measure_in_subprocess,
    read_head,
)
from cohelm.live.sessions.records import (
    OLDER,
    RIDE,
    SESSION,
    RideLog,
    RideSummary,
    SessionInfo,
    SessionSummary,
    now_utc,
    session_of,
    session_sort_key,
    stored_sessions,
    unknown_ride,
    unknown_session,
)
from cohelm.live.sessions.riders import RiderStore
from cohelm.live.sessions.timeline import Timeline
from cohelm.platforms import is_simulated
from cohelm.scenarios.build import RideSetup

RIDES = "rides"
"""Folder of the logs."""
LOST = "The navigator was lost; the last second of this ride may be missing."
INTERRUPTED = "The program was interrupted during this ride; its last second may be missing."
CLOSE_TIMEOUT = 4.0
"""Time for open measurements when the program ends, s; the rest is done at the next start."""
_log = logging.getLogger(__name__)
_T = TypeVar("_T")


class SessionStore:
    """Sessions and rides in a folder; a damaged ride is listed with its damage.

    Args:
        folder: Created if it is missing.

    Raises:
        StoreError: The folder cannot be created or written, or its database not be read.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = make_private_folder(folder)
        self.database = Database(folder)
        self.riders = RiderStore(self.database)
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._current: SessionInfo | None = None
        self._open: dict[str, SessionInfo] = {}
        """Rides of this program that go on, by id; of the current session or earlier ones."""
        self._kept: set[str] = set()
        """Ended rides, also of earlier programs, that are not deleted."""
        self._counts: dict[str, int] = {}
        """Session → number of its rides so far, also of deleted and earlier ones."""
        self._unwritten: dict[str, tuple[RideSummary, SessionInfo]] = {}
        """Ended rides that the disk did not take yet; of the writer thread."""
        self._ratings: dict[str, int] = {}
        """Ratings that the disk did not take yet, by ride."""
        self._retry: Future[Any] | None = None
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="sessions")
        self._measurer = ThreadPoolExecutor(1, thread_name_prefix="measuring")
        self.error = ""
        """Reason why something is not stored; empty if everything is."""
        self._finish_earlier()

    def begin(self, ride_setup: RideSetup, rider: str = "") -> SessionInfo:
        """Begin a session, to which all further rides belong; it is stored with its first ride.

        Args:
            ride_setup: World of its rides.
            rider: Id of the rider; empty: nobody was chosen.
        """
        info = SessionInfo(
            id="",
            started="",
            scene=ride_setup.scenario.name,
            robot=ride_setup.robot.name,
            simulation=is_simulated(ride_setup.scenario),
            rider=rider,
        )
        with self._lock:
            self._current = self._named(info)
            return self._current

    def begin_ride(self) -> tuple[str, SessionInfo, Path]:
        """Return the next ride's id, its session, and the file for its log.

        Raises:
            StoreError: No session has begun.
        """
        with self._lock:
            if self._current is None:
                raise StoreError("a ride needs a session; begin one first")
            self._counts[self._current.id] += 1
            ride = f"{self._current.id}-r{self._counts[self._current.id]}"
            self._open[ride] = self._current
            return ride, self._current, self.log_file(ride)

    def keep(self, summary: RideSummary, log: RideLog | None, ride_setup: RideSetup) -> None:
        """Store a ride that has ended; another process computes its measures and its map.

        A ride that was deleted meanwhile is not stored.

        Args:
            summary: Summary with an id of :meth:`begin_ride`.
            log: Answer of the navigator's process; None: it is lost.
            ride_setup: World of the ride.
        """
        error = LOST if log is None else ""
        if log is not None and log.lost_ticks:
            seconds = log.lost_ticks * ride_setup.world.control_step
            error = f"{log.lost_ticks} ticks of this ride, {seconds:.1f} s, are not stored."

        def write() -> None:
            if info is None:  # the log may have been created after the deletion
                _unlink(self.log_file(summary.id))
                return
            self._unwritten[summary.id] = summary.model_copy(update={"error": error}), info
            self._write_rides()
            if log is not None:
                grid, name = ride_setup.navigator.grid, ride_setup.scenario.name
                map_changes.keep_changes(self.database, grid, name, log.changes)

        with self._lock:  # a deletion comes before all of this, or after it
            info = self._open.pop(summary.id, None)
            if info is not None:
                self._kept.add(summary.id)
            self._write(write)

    def retry(self, further: Callable[[], None] = lambda: None) -> None:
        """Write again what could not be written, and run ``further``, in the writer thread."""
        if self._retry is not None and not self._retry.done():
            return

        def write() -> None:
            further()
            if self.error:
                self.database.set("tried", now_utc())
            self._write_rides()
            self._write_ratings()

        self._retry = self._write(write)

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating, 1 to 5; it replaces an earlier one.

        Raises:
            StoreError: There is no such ride.
        """
        if ride not in self._kept:
            raise StoreError("there is no such ride")
        self._ratings[ride] = rating
        self._write(self._write_ratings)

    def delete_all(self) -> int:
        """Delete all sessions, the current one included, and return their number.

        The current ride is not stored. The audit log, the riders and the settings stay.

        Raises:
            StoreError: Something could not be deleted; names it.
        """

        def delete() -> int:
            count = self._delete(None, going_on)
            map_changes.forget_changes(self.database)
            older = self._older()
            for folder in older:
                _unlink(folder)
            return count + len(older)

        with self._lock:
            going_on = self._forget(None)
            deletion = self._write(delete)
        return deletion.result()

    def delete_of(self, rider: str) -> int:
        """Delete the sessions of one rider, and return their number; errors as above."""
        with self._lock:
            going_on = self._forget(rider)
            deletion = self._write(lambda: self._delete(rider, going_on))
        return deletion.result()

    def list(self) -> tuple[SessionSummary, ...]:
        """Return all sessions with a ride, the newest first, and the names of older versions'.

        Raises:
            StoreError: The database cannot be read.
        """
        older = (SessionSummary(session=unknown_session(f.name, OLDER)) for f in self._older())
        found = [*stored_sessions(self.database), *older]
        found.sort(key=lambda each: session_sort_key(each.session.id), reverse=True)
        return tuple(found)

    def list_of(self, rider: str) -> tuple[SessionSummary, ...]:
        """Return the sessions of one rider, the newest first; errors as in :meth:`list`."""
        return tuple(each for each in self.list() if rider and each.session.rider == rider)

    def summary(self, session: str) -> SessionSummary:
        """Return one session.

        Raises:
            StoreError: There is no such session.
        """
        found = next((each for each in self.list() if each.session.id == session), None)
        if found is None:
            raise StoreError("there is no such session")
        return found

    def unreadable(self) -> int:
        """Return the number of sessions of which the rider cannot be read."""
        query = "SELECT DISTINCT session FROM ride WHERE rider IS NULL AND state != 'deleted'"
        return len(self.database.rows(query)) + len(self._older())

    def html(self, session: str) -> str:
        """Return the HTML report of a session; errors as in :meth:`summary`."""
        summary = self.summary(session)
        maps: dict[str, bytes] = {}
        timelines: dict[str, Timeline] = {}
        query = "SELECT id, png, timeline FROM ride WHERE session = ? AND state = 'measured'"
        for ride, png, timeline in self.database.rows(query, session):
            maps[ride] = png
            with contextlib.suppress(ValueError):  # of another version
                timelines[ride] = Timeline.model_validate_json(timeline)
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
        rides = [id_] if RIDE.fullmatch(id_) else [r.id for r in self.summary(id_).rides]
        for ride in reversed(rides):
            for (found,) in self.database.rows("SELECT png FROM ride WHERE id = ?", ride):
                if found:
                    return bytes(found)
        raise StoreError(f"there is no map of {id_}, or not yet")

    def timeline(self, ride: str) -> bytes:
        """Return the timeline of a ride as JSON, see :mod:`.timeline`.

        Raises:
            StoreError: There is no timeline, or not yet.
        """
        for (found,) in self.database.rows("SELECT timeline FROM ride WHERE id = ?", ride):
            if found:
                return bytes(found)
        raise StoreError(f"there is no timeline of {ride}, or not yet")

    def wait_until_idle(self, timeout: float = math.inf) -> None:
        """Wait for all pending writes and measurements, up to ``timeout``, s."""
        end = time.monotonic() + timeout
        for thread in (self._writer, self._measurer, self._writer):
            left = None if timeout == math.inf else max(end - time.monotonic(), 0.0)
            with contextlib.suppress(TimeoutError):
                thread.submit(lambda: None).result(left)

    def close(self) -> None:
        """Finish pending work for some seconds, then close.

        A ride that is not measured by then is measured at the next start.
        """
        if not self._closing.is_set():
            self.wait_until_idle(CLOSE_TIMEOUT)
        self._closing.set()
        self._measurer.shutdown()
        self._writer.shutdown()

    def _write(self, task: Callable[[], _T]) -> Future[_T]:
        """Run a task in the writer thread; a failure is logged, and stays in ``error``."""

        def run() -> _T:
            try:
                done = task()
            except StoreError as error:
                if not self.error:  # once, not at every attempt
                    _log.error("sessions: %s", error)
                self.error = error.problem
                raise
            self.error = "" if not (self._unwritten or self._ratings) else self.error
            return done

        return self._writer.submit(run)

    def _finish_earlier(self) -> None:
        """Finish the deletions, and continue with the rides, of earlier programs."""
        for (ride,) in self.database.rows("SELECT id FROM ride WHERE state = 'deleted'"):
            try:
                _unlink(self.log_file(ride))
                self.database.write("DELETE FROM ride WHERE id = ?", ride)
            except StoreError as error:  # it is tried again at the next start
                _log.error("sessions: %s", error)
        self._kept = {ride for (ride,) in self.database.rows("SELECT id FROM ride")}
        for file in sorted(self.folder.glob(f"{RIDES}/*.mcap")):
            if RIDE.fullmatch(file.stem) and file.stem not in self._kept:
                self._adopt(file)
                self._kept.add(file.stem)
        for ride in self._kept:
            number, session = int(ride.rpartition("-r")[2]), session_of(ride)
            self._counts[session] = max(self._counts.get(session, 0), number)
        self._counts.update((folder.name, 0) for folder in self._older())
        for (ride,) in self.database.rows("SELECT id FROM ride WHERE state IN ('ended', 'cut')"):
            self._measurer.submit(self._measure, ride)

    def _adopt(self, file: Path) -> None:
        """Enter a log that has no entry."""
        try:
            info, summary = read_head(file)
            changes = {"id": file.stem, "outcome": "cancelled", "error": INTERRUPTED}
            self._insert(summary.model_copy(update=changes), info, info.rider, "cut")
        except StoreError as error:
            _log.error("sessions: a ride is damaged: %s", error)
            session = session_of(file.stem)
            info = unknown_session(session, "unknown (the log cannot be read)")
            problem = f"The record of this ride ({file.name}) cannot be read."
            self._insert(unknown_ride(file.stem, problem), info, None, "unmeasured")

    def _insert(self, summary: RideSummary, info: SessionInfo, *more: str | None) -> None:
        """Enter a ride with its rider and its state."""
        texts = (info.model_dump_json(), summary.model_dump_json())
        self.database.write(
            "INSERT OR IGNORE INTO ride (id, session, info, summary, rider, state) "
            "VALUES (?, ?, ?, ?, ?, ?)",
            *(summary.id, session_of(summary.id), *texts, *more),
        )

    def _named(self, info: SessionInfo) -> SessionInfo:
        """Return a session with an id that was never used, from the local time."""
        stamp = datetime.now(UTC).astimezone().strftime("%Y%m%d-%H%M%S")
        names = itertools.chain([stamp], (f"{stamp}-{n}" for n in itertools.count(2)))
        id_ = next(each for each in names if each not in self._counts)
        self._counts[id_] = 0
        return info.model_copy(update={"id": id_, "started": now_utc()})

    def _write_rides(self) -> None:
        """Enter all rides that have ended, in the writer thread."""
        for ride, (summary, info) in list(self._unwritten.items()):
            self._insert(summary, info, info.rider, "ended")
            del self._unwritten[ride]
            if not self._closing.is_set():  # else it is measured at the next start
                self._measurer.submit(self._measure, ride)

    def _write_ratings(self) -> None:
        for ride, rating in list(self._ratings.items()):
            self._update(ride, {"rating": rating})
            del self._ratings[ride]

    def _update(self, ride: str, changes: Mapping[str, Any], *more: str | bytes) -> None:
        """Change the summary of a ride, and state, map and timeline, in the writer thread."""
        if ride in self._unwritten:
            summary, info = self._unwritten[ride]
            self._unwritten[ride] = summary.model_copy(update=changes), info
            return
        query = "SELECT summary FROM ride WHERE id = ? AND state != 'deleted'"
        for (text,) in self.database.rows(query, ride):
            new = RideSummary.model_validate_json(text).model_copy(update=changes)
            columns = ("summary", "state", "png", "timeline")[: 1 + len(more)]
            setting = ", ".join(f"{column} = ?" for column in columns)
            statement = f"UPDATE ride SET {setting} WHERE id = ?"
            self.database.write(statement, new.model_dump_json(), *more, ride)

    def _measure(self, ride: str) -> None:
        """Measure a ride, in the measuring thread."""
        if self._closing.is_set():
            return
        query = "SELECT summary, state FROM ride WHERE id = ? AND state IN ('ended', 'cut')"
        for text, state in self.database.rows(query, ride):
            more: tuple[str | bytes, ...] = ("unmeasured",)
            new: dict[str, Any]
            old = RideSummary.model_validate_json(text)
            try:
                found = measure_in_subprocess(self.log_file(ride), self._closing)
            except MeasuringPostponed:
                return
            except StoreError as error:
                new = {"error": f"{old.error} {error}".strip()}
            else:
                told = found.summary
                new = {"stops": told.stops, "nearest": told.nearest, "measures": told.measures}
                if state == "cut":
                    new = {k: v for k, v in told if k not in {"id", "session", "rating"}}
                    new["error"] = INTERRUPTED if found.damage else ""
                elif found.damage and not old.error:
                    new["error"] = f"The log is damaged: {found.damage}."
                more = ("measured", found.png, found.timeline)
            self._write(functools.partial(self._update, ride, new, *more))

    def _forget(self, rider: str | None) -> set[str]:
        """Return the rides of a rider, or all, that go on, and are not stored any more; locked."""
        gone = {r for r, info in self._open.items() if rider in {None, info.rider}}
        for ride in gone:
            del self._open[ride]
        return gone

    def _delete(self, rider: str | None, going_on: set[str]) -> int:
        """Delete the sessions of a rider, or all, in the writer thread; returns their number."""
        waiting = {r for r, (_, info) in self._unwritten.items() if rider in {None, info.rider}}
        query = "SELECT id FROM ride WHERE state != 'deleted' AND (?1 IS NULL OR rider = ?1)"
        stored = {ride for (ride,) in self.database.rows(query, rider)}
        gone = going_on | waiting | stored
        with self.database.transaction() as database:
            # Until the next start these entries keep a log that appears later from being adopted.
            database.executemany(
                "INSERT OR REPLACE INTO ride VALUES (?, ?, NULL, 'deleted', '', '', NULL, NULL)",
                [(ride, session_of(ride)) for ride in gone],
            )
        self._kept -= gone
        for ride in waiting:
            del self._unwritten[ride]
        with self._lock:
            if self._current is not None and self._current.id in set(map(session_of, gone)):
                self._current = self._named(self._current)
        self._unlink_deleted()
        return len(set(map(session_of, stored)))

    def _unlink_deleted(self) -> None:
        for (ride,) in self.database.rows("SELECT id FROM ride WHERE state = 'deleted'"):
            _unlink(self.log_file(ride))

    def _older(self) -> tuple[Path, ...]:
        """Folders of sessions of an older version."""
        return tuple(f for f in self.folder.iterdir() if SESSION.fullmatch(f.name))

    def log_file(self, ride: str) -> Path:
        """Return the file for the log of a ride."""
        return self.folder / RIDES / f"{ride}.mcap"


def _unlink(path: Path) -> None:
    """Remove a file or a folder, if it exists.

    Raises:
        StoreError: It cannot be removed.
    """
    try:
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except OSError as cause:
        problem = f"cannot be deleted ({cause.strerror or cause})"
        raise StoreError(problem, file=path) from None
