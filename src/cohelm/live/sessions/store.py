"""Storage of sessions in one folder, which one action deletes.

    DIR/                       0700, every file in it 0600
      settings.json            limits and the rider's settings, see ``control.limits``
      audit.jsonl              audit log; it stays when sessions are deleted
      20260131-142530/         a session
        session.json
        20260131-142530-r1.json   summary of a ride; .png its map; .rows and .task its log, until
                                  it is measured: now, or at the next start
      .deleted-…/              session being deleted, now or at the next start

Every method may be called from any thread. A writer thread keeps the order of all writes but those
of :meth:`SessionStore.begin`, which makes a folder with one small file and flushes both to disk in
the calling thread: some ms, once for each drive, and once more after its session was deleted. The
control loop calls it while the chair stands or begins to move. :attr:`SessionStore.error` holds the
last failure.
"""

from __future__ import annotations

import contextlib
import functools
import logging
import shutil
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from pathlib import Path
from typing import Any

from cohelm.errors import StoreError
from cohelm.live.sessions import report
from cohelm.live.sessions.files import make_private_folder, write_atomically
from cohelm.live.sessions.measuring import (
    MeasuringPostponed,
    log_without_navigator,
    measure_in_subprocess,
    task_of,
)
from cohelm.live.sessions.records import RideLog, RideSummary, SessionInfo, SessionSummary
from cohelm.live.sessions.session_files import (
    RIDE,
    SESSION,
    as_json,
    create_session_folder,
    mark_deleted,
    not_deleted,
    now_utc,
    read,
    remove_deleted,
    rides_in,
    session_of,
    session_sort_key,
    sweep,
)
from cohelm.platforms import is_simulated
from cohelm.scenarios.build import RideSetup

LOST = "The navigator was lost before it delivered stops, route and destination."
"""Error of a ride without a log."""
CLOSE_TIMEOUT = 4.0
"""Time for open measurements when the program ends, s; the rest is done at the next start."""
_log = logging.getLogger(__name__)


class SessionStore:
    """Sessions and rides in a folder.

    Args:
        folder: Created if it is missing.

    Raises:
        StoreError: The folder cannot be created or written.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = make_private_folder(folder)
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="sessions")
        self._measurer = ThreadPoolExecutor(1, thread_name_prefix="measuring")
        self._pending: set[Future[Any]] = set()
        self._closing = threading.Event()
        self._lock = threading.Lock()
        self._current: SessionInfo | None = None
        self._stored_rides: set[str] = set()
        """Rides of this program that were given to the writer thread, and not deleted."""
        self._used_ids: set[str] = set()
        """Sessions that this program has begun, deleted ones included."""
        self._ride_count = 0
        """Rides of the current session so far."""
        self._error = ""
        sweep(self.folder)
        for task in sorted(self.folder.glob("*/*.task")):
            if RIDE.fullmatch(task.stem):
                self._submit(self._measurer, functools.partial(self._measure, task.stem))

    def begin(self, ride_setup: RideSetup) -> SessionInfo:
        """Begin a session, to which all further rides belong.

        Raises:
            StoreError: The session cannot be written.
        """
        with self._lock:
            self._current = self._open_session(
                SessionInfo(
                    id="",
                    started=now_utc(),
                    scene=ride_setup.scenario.name,
                    robot=ride_setup.robot.name,
                    simulation=is_simulated(ride_setup.scenario),
                )
            )
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

    def keep(self, record: RideSummary, log: RideLog | None, ride_setup: RideSetup) -> None:
        """Store a ride that has ended; another process computes its measures and its map.

        A ride whose session was deleted meanwhile is not stored.

        Args:
            record: Summary with an id of :meth:`begin_ride`.
            log: Log by the navigator's process; None: it is lost with stops, route and
                destination, and the measures come from the rows on disk.
            ride_setup: World of the ride.
        """
        error = "" if log is not None else LOST
        session = session_of(record.id)
        record = record.model_copy(update={"session": session, "error": error})
        self._stored_rides.add(record.id)
        period = ride_setup.world.control_step
        log = log or log_without_navigator(record, self._file(record.id, ".rows"), period)
        task = task_of(log, ride_setup.scenario, ride_setup.robot, ride_setup.grid)
        written = self._submit(self._writer, lambda: self._write_ride(record, task))

        def measure() -> None:
            wait([written])
            self._measure(record.id)

        self._submit(self._measurer, measure)

    def rate(self, ride: str, rating: int) -> None:
        """Store a rating, 1 to 5; it replaces an earlier one.

        Raises:
            StoreError: There is no such ride.
        """
        if ride not in self._stored_rides:
            self._ride(ride)
        self._submit(self._writer, lambda: self._update_ride(ride, rating=rating))

    def list(self) -> tuple[SessionSummary, ...]:
        """Return all sessions with a ride, the newest first."""
        found = []
        for each in sorted(self._folders(), key=lambda f: session_sort_key(f.name), reverse=True):
            with contextlib.suppress(StoreError):  # deleted meanwhile, or damaged
                found.append(self.summary(each.name))
        return tuple(each for each in found if each.rides)

    def summary(self, session: str) -> SessionSummary:
        """Return one session.

        Raises:
            StoreError: There is no such session.
        """
        folder = self._session(session)
        facts = read(SessionInfo, folder / "session.json")
        return SessionSummary(session=facts, rides=tuple(rides_in(folder)))

    def html(self, session: str) -> str:
        """Return the HTML report of a session; errors as in :meth:`summary`."""
        summary = self.summary(session)
        maps = {}
        for ride in summary.rides:
            with contextlib.suppress(StoreError):
                maps[ride.id] = self.png(ride.id)
        return report.session_html(summary, maps)

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

    def delete_all(self) -> int:
        """Delete all sessions, the current one included, and return their number.

        The current ride is not stored. The audit log and the settings stay.

        Raises:
            StoreError: Something could not be deleted; names it.
        """
        count: int = self._submit(self._writer, self._delete_all).result()
        return count

    def wait_until_idle(self) -> None:
        """Wait for all pending writes and measurements."""
        while True:
            with self._lock:
                pending = set(self._pending)
            if not pending:
                return
            wait(pending)

    def close(self) -> None:
        """Finish pending work for some seconds, then close; a session without a ride is removed.

        A ride that is not measured by then is measured at the next start.
        """
        with self._lock:
            pending = set(self._pending)
        wait(pending, CLOSE_TIMEOUT)
        self._closing.set()
        self.wait_until_idle()
        self._measurer.shutdown()
        self._writer.shutdown()
        facts, self._current = self._current, None
        if facts is not None and not any(rides_in(self.folder / facts.id)):
            shutil.rmtree(self.folder / facts.id, ignore_errors=True)

    @property
    def error(self) -> str:
        """Last failure of a write; empty if there was none."""
        return self._error

    def _open_session(self, info: SessionInfo) -> SessionInfo:
        """Give the session an id and a folder of its own."""
        id_ = create_session_folder(self.folder, self._used_ids)
        self._used_ids.add(id_)
        opened = info.model_copy(update={"id": id_})
        write_atomically(self.folder / id_ / "session.json", as_json(opened))
        return opened

    def _submit(self, executor: ThreadPoolExecutor, task: Callable[[], Any]) -> Future[Any]:
        """Run a task in another thread; a failure is logged, and stays in ``error``."""
        future = executor.submit(self._run_logged, task)
        with self._lock:
            self._pending.add(future)
        future.add_done_callback(self._pending.discard)
        return future

    def _run_logged(self, task: Callable[[], Any]) -> Any:
        try:
            return task()
        except StoreError as error:
            _log.error("sessions: %s", error)
            self._error = str(error)
            raise

    def _write_ride(self, record: RideSummary, task: bytes) -> None:
        """Write a ride, in the writer thread."""
        file = self._file(record.id, ".json")
        if file.parent.is_dir():  # else deleted while it went on
            write_atomically(file, as_json(record))
            write_atomically(file.with_suffix(".task"), task)

    def _update_ride(self, ride: str, **changes: Any) -> None:
        """Change a stored ride, in the writer thread; a deleted ride stays deleted."""
        file = self._file(ride, ".json")
        if file.is_file():
            write_atomically(file, as_json(read(RideSummary, file).model_copy(update=changes)))

    def _measure(self, ride: str) -> None:
        """Measure a ride, in the measuring thread."""
        task, rows = self._file(ride, ".task"), self._file(ride, ".rows")
        if self._closing.is_set() or not (task.is_file() and rows.is_file()):
            return
        into = self._file(ride, ".measures.json")
        changes: dict[str, Any]
        try:
            measures = measure_in_subprocess(task, into, self._closing)
            into.with_suffix(".png").replace(self._file(ride, ".png"))
            changes = {"measures": measures}
        except MeasuringPostponed:
            return
        except (StoreError, OSError) as error:
            changes = {"error": str(error)}
        self._submit(self._writer, lambda: self._store_measures(ride, **changes))

    def _store_measures(self, ride: str, **changes: Any) -> None:
        """Store the measures of a ride, in the writer thread."""
        self._update_ride(ride, **changes)
        for done in (".task", ".rows"):
            self._file(ride, done).unlink(missing_ok=True)

    def _delete_all(self) -> int:
        """Delete all sessions, in the writer thread; an open measurement finds its folder gone."""
        try:
            count = sum(any(rides_in(folder)) for folder in self._folders())
            with self._lock:  # no session is created meanwhile
                self._stored_rides.clear()
                mark_deleted(self._folders())
        except OSError as cause:
            raise not_deleted(self.folder, cause) from None
        remove_deleted(self.folder)
        return count

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
