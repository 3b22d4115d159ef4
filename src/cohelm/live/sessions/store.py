"""Storage of sessions in one folder, which one action deletes.

    DIR/                       0700, every file in it 0600
      settings.json            limits and the rider's settings, see ``control.limits``
      map-changes.json         where the building differs from its map
      riders/                  who rides, see ``riders``; they stay when sessions are deleted
      audit.jsonl              audit log; it stays when sessions are deleted
      20260131-142530/         a session
        session.json
        20260131-142530-r1.json   summary of a ride; .png, .timeline; .begun: of one that goes
                                  on; .rows and .task: its log, until it is measured, if it can be
      .deleted-…/              session being deleted, now or at the next start

Every method may be called from any thread. A writer thread keeps the order of all writes but those
of :meth:`SessionStore.begin`, which makes a folder with one small file and flushes both to disk in
the calling thread, the control loop: some ms, once for each drive and rider, and once more after
its session was deleted. The chair stands then, or begins to move. :attr:`SessionStore.error` says
what could not be written; it is tried again with every further write, and by ``retry``.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import threading
from collections.abc import Callable, Iterable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

from cohelm.errors import StoreError
from cohelm.live.sessions import map_changes
from cohelm.live.sessions.archive import SessionArchive
from cohelm.live.sessions.files import check_writable, write_atomically
from cohelm.live.sessions.measuring import (
    MeasuringPostponed,
    log_without_navigator,
    measure_in_subprocess,
    task_of,
)
from cohelm.live.sessions.records import RideLog, RideSummary, SessionInfo
from cohelm.live.sessions.recovery import BEGUN, interrupted_ride, unfinished_rides
from cohelm.live.sessions.session_files import (
    RIDE,
    as_json,
    create_session,
    mark_deleted,
    not_deleted,
    now_utc,
    read,
    remove_deleted,
    remove_empty_session,
    remove_file,
    rides_in,
    session_info,
    session_of,
    sweep,
    text_of_lost_rows,
)
from cohelm.scenarios.build import RideSetup

_log = logging.getLogger(__name__)


class Background:
    """Tasks in two threads; every method may be called from any thread.

    Args:
        complete: Returns True if nothing waits for the disk; then a successful task clears
            :attr:`error`.
    """

    def __init__(self, complete: Callable[[], bool]) -> None:
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="sessions")
        self._measurer = ThreadPoolExecutor(1, thread_name_prefix="measuring")
        self._pending: set[Future[Any]] = set()
        self._lock = threading.Lock()
        self._complete = complete
        self.error = ""
        """Reason why something could not be written; empty if everything is."""

    def write(self, task: Callable[[], Any]) -> Future[Any]:
        """Run a task in the writer thread, after all earlier ones."""
        return self._submit(self._writer, task)

    def measure(self, task: Callable[[], Any]) -> None:
        """Run a task in the measuring thread, after all tasks so far."""
        with self._lock:
            before = set(self._pending)

        def run() -> None:
            wait(before)
            task()

        self._submit(self._measurer, run)

    def wait(self, timeout: float) -> None:
        """Wait for the tasks so far, up to ``timeout``, s."""
        with self._lock:
            pending = set(self._pending)
        wait(pending, timeout)

    def wait_until_idle(self) -> None:
        """Wait for all tasks, and for those that they add."""
        while True:
            with self._lock:
                pending = set(self._pending)
            if not pending:
                return
            wait(pending)

    def close(self) -> None:
        """End the threads."""
        self._measurer.shutdown()
        self._writer.shutdown()

    def _submit(self, executor: ThreadPoolExecutor, task: Callable[[], Any]) -> Future[Any]:
        """Run a task; a failure is logged, and stays in ``error``."""
        future = executor.submit(self._run, task)
        with self._lock:
            self._pending.add(future)
        future.add_done_callback(self._discard)
        return future

    def _discard(self, future: Future[Any]) -> None:
        with self._lock:
            self._pending.discard(future)

    def _run(self, task: Callable[[], Any]) -> Any:
        try:
            done = task()
        except StoreError as error:
            if not self.error:  # once, not at every attempt
                _log.error("sessions: %s", error)
            self.error = error.problem
            raise
        if self._complete():
            self.error = ""
        return done


FAILED = ".failed"
"""Suffix of a task that could not be measured."""
LOST = "The navigator was lost before it delivered stops, route and destination."
"""Error of a ride without a log."""
CLOSE_TIMEOUT = 4.0
"""Time for open measurements when the program ends, s; the rest is done at the next start."""


class SessionStore(SessionArchive):
    """Sessions and rides in a folder, to read and to write.

    Args:
        folder: Created if it is missing.

    Raises:
        StoreError: The folder cannot be created or written.
    """

    def __init__(self, folder: Path) -> None:
        super().__init__(folder)
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._current: SessionInfo | None = None
        self._stored_rides: set[str] = set()
        """Rides of this program that were given to the writer thread, and not deleted."""
        self._used_ids: set[str] = set()
        """Sessions that this program has begun, deleted ones included."""
        self._ride_count = 0
        """Rides of the current session so far."""
        self._background = Background(lambda: not self._unwritten)
        self._unwritten: dict[str, tuple[RideSummary, Callable[[], bytes]]] = {}
        """Ended rides that the disk did not take yet, with their tasks; of the writer thread."""
        self._checkpoint: Future[Any] | None = None
        self._retry: Future[Any] | None = None
        sweep(self.folder)
        for ride in unfinished_rides(self.folder):
            self._background.write(functools.partial(self._finish, ride))
        for task in sorted(self.folder.glob("*/*.task")):
            if RIDE.fullmatch(task.stem):
                self._measure_later(task.stem)

    def begin(self, ride_setup: RideSetup, rider: str = "") -> SessionInfo:
        """Begin a session, to which all further rides belong; one without a ride is removed.

        Args:
            ride_setup: World of its rides.
            rider: Id of the rider; empty: nobody was chosen.

        Raises:
            StoreError: The session cannot be written.
        """
        with self._lock:
            if self._current is not None and not self._ride_count:
                remove_empty_session(self.folder / self._current.id)
            self._current = self._open_session(session_info(ride_setup, rider))
            self._ride_count = 0
            return self._current

    def begin_ride(self) -> tuple[str, Path]:
        """Return the next ride's id and the file for its rows.

        Raises:
            StoreError: No session has begun, or its folder cannot be written.
        """
        with self._lock:
            if self._current is None:
                raise StoreError("a ride needs a session; begin one first")
            if not (self.folder / self._current.id).is_dir():  # it was deleted
                self._current = self._open_session(
                    self._current.model_copy(update={"started": now_utc()})
                )
                self._ride_count = 0
            self._ride_count += 1
            ride = f"{self._current.id}-r{self._ride_count}"
            return ride, self.folder / self._current.id / f"{ride}.rows"

    def checkpoint(self, record: RideSummary, ride_setup: RideSetup | None = None) -> None:
        """Store the summary so far of a ride that goes on, unless the last one still waits.

        Args:
            record: Summary with an id of :meth:`begin_ride`.
            ride_setup: World of the ride, in the first call; with it a ride can be measured whose
                program is killed.
        """
        waits = self._checkpoint is not None and not self._checkpoint.done()
        if waits and ride_setup is None:
            return
        begun = self._file(record.id, BEGUN)

        def write() -> None:
            if not begun.parent.is_dir():  # deleted while it went on
                return
            if ride_setup is not None:
                log = log_without_navigator(
                    record, self._file(record.id, ".rows"), ride_setup.world.control_step
                )
                task = task_of(log, ride_setup.scenario, ride_setup.robot, ride_setup.grid)
                write_atomically(begun.with_suffix(".task"), task)
            write_atomically(begun, as_json(record))

        self._checkpoint = self._background.write(write)

    def keep(self, record: RideSummary, log: RideLog | None, ride_setup: RideSetup) -> None:
        """Store a ride that has ended; another process computes its measures and its map.

        A ride whose session was deleted meanwhile is not stored.

        Args:
            record: Summary with an id of :meth:`begin_ride`.
            log: Log by the navigator's process; None: it is lost with stops, route and
                destination, and the measures come from the rows on disk.
            ride_setup: World of the ride.
        """
        error = LOST if log is None else text_of_lost_rows(log)
        session = session_of(record.id)
        record = record.model_copy(update={"session": session, "error": error})
        self._stored_rides.add(record.id)
        period = ride_setup.world.control_step
        kept = log or log_without_navigator(record, self._file(record.id, ".rows"), period)

        def task() -> bytes:
            return task_of(kept, ride_setup.scenario, ride_setup.robot, ride_setup.grid)

        def write() -> None:
            self._unwritten[record.id] = record, task
            self._write_rides()
            if log is not None and (self.folder / session).is_dir():  # else deleted meanwhile
                grid, name = ride_setup.navigator.grid, ride_setup.scenario.name
                map_changes.keep_changes(self.folder, grid, name, log.changes)

        self._background.write(write)

    def retry(self, further: Callable[[], None] = lambda: None) -> None:
        """Write again what could not be written, and run ``further``, in the writer thread."""
        if self._retry is not None and not self._retry.done():
            return

        def write() -> None:
            further()
            if self._background.error:
                check_writable(self.folder)
            self._write_rides()

        self._retry = self._background.write(write)

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating, 1 to 5; it replaces an earlier one.

        Raises:
            StoreError: There is no such ride.
        """
        if ride not in self._stored_rides:
            self._ride(ride)
        self._background.write(lambda: self._update_ride(ride, rating=rating))

    def delete_all(self) -> int:
        """Delete all sessions, the current one included, and return their number.

        The current ride is not stored. The audit log and the settings stay.

        Raises:
            StoreError: Something could not be deleted; names it.
        """
        return int(self._background.write(self._delete_all).result())

    def delete_of(self, rider: str) -> int:
        """Delete the sessions of one rider, and return their number; errors as above."""
        found = self.folders_of(rider)
        return int(self._background.write(lambda: self._delete(lambda: found)).result())

    def wait_until_idle(self) -> None:
        """Wait for all pending writes and measurements."""
        self._background.wait_until_idle()

    def close(self) -> None:
        """Finish pending work for some seconds, then close; remove a session without a ride.

        A ride that is not measured by then is measured at the next start.
        """
        self._background.wait(CLOSE_TIMEOUT)
        self._closing.set()
        self.wait_until_idle()
        self._background.close()
        if self._current is not None:
            remove_empty_session(self.folder / self._current.id)
        self._current = None

    @property
    def error(self) -> str:
        """Reason why something is not stored; empty if everything is."""
        return self._background.error

    def _open_session(self, info: SessionInfo) -> SessionInfo:
        """Give the session an id and a folder of its own."""
        opened = create_session(self.folder, self._used_ids, info)
        self._used_ids.add(opened.id)
        return opened

    def _write_rides(self) -> None:
        """Write all rides that have ended, in the writer thread."""
        for ride, (record, task) in list(self._unwritten.items()):
            self._write_ride(record, task)
            del self._unwritten[ride]
            self._measure_later(ride)

    def _write_ride(self, record: RideSummary, task: Callable[[], bytes]) -> None:
        file = self._file(record.id, ".json")
        if file.parent.is_dir():  # else deleted while it went on
            # The summary is last: it says that the ride has ended.
            write_atomically(file.with_suffix(".task"), task())
            write_atomically(file, as_json(record))
            with contextlib.suppress(OSError):
                file.with_suffix(BEGUN).unlink(missing_ok=True)

    def _finish(self, ride: str) -> None:
        """Finish a ride of a program that was killed, in the writer thread."""
        file = self._file(ride, ".json")
        write_atomically(file, as_json(interrupted_ride(self.folder, ride)))
        with contextlib.suppress(OSError):
            file.with_suffix(BEGUN).unlink(missing_ok=True)

    def _update_ride(self, ride: str, **changes: Any) -> bool:
        """Change a ride, in the writer thread; returns False if it is not stored, or deleted."""
        file = self._file(ride, ".json")
        stored = file.is_file()
        if stored:
            write_atomically(file, as_json(read(RideSummary, file).model_copy(update=changes)))
        return stored

    def _measure_later(self, ride: str) -> None:
        self._background.measure(lambda: self._measure(ride))

    def _measure(self, ride: str) -> None:
        """Measure a ride, in the measuring thread."""
        task, rows = self._file(ride, ".task"), self._file(ride, ".rows")
        if self._closing.is_set() or not (task.is_file() and rows.is_file()):
            return
        try:
            measured = measure_in_subprocess(task, self._closing)
            write_atomically(self._file(ride, ".png"), measured.png)
            write_atomically(self._file(ride, ".timeline"), measured.timeline)
        except MeasuringPostponed:
            return
        except (StoreError, OSError) as error:
            problem = f"{error}; its rows are kept in {rows.name}"
            self._background.write(lambda: self._set_aside(ride, problem))
            return
        self._background.write(lambda: self._store_measures(ride, measured.measures))

    def _store_measures(self, ride: str, measures: dict[str, float]) -> None:
        """Store the measures of a ride, in the writer thread; then its log is not needed."""
        if not self._update_ride(ride, measures=measures):
            return  # deleted, or the disk did not take it yet
        for done in (".task", ".rows"):
            self._file(ride, done).unlink(missing_ok=True)

    def _set_aside(self, ride: str, problem: str) -> None:
        """Keep the log of a ride that cannot be measured, and do not try again."""
        file = self._file(ride, ".json")
        before = read(RideSummary, file).error if file.is_file() else ""
        self._update_ride(ride, error=f"{before} {problem}".strip())
        task = self._file(ride, ".task")
        if task.is_file():
            task.replace(task.with_suffix(FAILED))

    def _delete_all(self) -> int:
        """Delete all sessions, in the writer thread."""
        count = self._delete(self._folders)
        remove_file(self.folder / map_changes.FILE)
        return count

    def _delete(self, which: Callable[[], Iterable[Path]]) -> int:
        """Delete sessions, in the writer thread; an open measurement finds its folder gone."""
        try:
            count = sum(any(rides_in(folder)) for folder in which())
            with self._lock:  # no session is created meanwhile
                gone = {folder.name: folder for folder in which()}
                stored = tuple(self._stored_rides)  # at once: the control thread adds to it
                self._stored_rides.difference_update(r for r in stored if session_of(r) in gone)
                mark_deleted(gone.values())
        except OSError as cause:
            raise not_deleted(self.folder, cause) from None
        remove_deleted(self.folder)
        return count
