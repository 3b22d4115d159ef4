"""What is kept of sessions: in one folder of this machine, and gone by one action.

    DIR/                       0700, every file in it 0600
      settings.json            limits and the rider's settings, see ``limits``
      audit.jsonl              see ``audit``; deleting sessions leaves it
      20260131-142530/         a session
        session.json
        20260131-142530-r1.json   a ride's record; .png its map; .rows its log and .task what else
                                  is needed, until it is measured: now, or at the next start
      .deleted-…/              a session that is being deleted, now or at the next start

Every method may be called from any thread. Writing is done aside, in the order asked for, so that
nobody who drives waits for a disk; what goes wrong there stands in :attr:`Sessions.trouble`.
"""

from __future__ import annotations

import contextlib
import functools
import itertools
import logging
import shutil
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from cohelm.driving import report
from cohelm.driving.files import own_folder, write_whole
from cohelm.driving.measuring import Postponed, measured_aside, salvaged, task_of
from cohelm.driving.records import RideLog, RideRecord, SessionFacts, SessionSummary
from cohelm.driving.session_files import (
    DELETED,
    RIDE,
    SESSION,
    age,
    as_json,
    now_utc,
    read,
    rides_in,
    sweep,
)
from cohelm.errors import StoreError
from cohelm.evaluation.staging import Stage

LOST = "The navigator was lost before it had told of stops, route and destination."
"""Of a ride whose log is."""
CLOSING = 4.0
"""For what is being measured when the program ends, s; the rest is measured at the next start."""
_log = logging.getLogger(__name__)


class Sessions:
    """The store.

    Args:
        folder: where; made where it is missing.

    Raises:
        StoreError: if it cannot be made or written to.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = own_folder(folder)
        self._writer = ThreadPoolExecutor(1, thread_name_prefix="sessions")
        self._measurer = ThreadPoolExecutor(1, thread_name_prefix="measuring")
        self._pending: set[Future[Any]] = set()
        self._ends = threading.Event()
        self._lock = threading.Lock()
        self._facts: SessionFacts | None = None
        self._kept: set[str] = set()
        self._given: set[str] = set()
        self._count = 0
        self._trouble = ""
        sweep(self.folder)
        for task in sorted(self.folder.glob("*/*.task")):
            if RIDE.fullmatch(task.stem):
                self._do(self._measurer, functools.partial(self._measure, task.stem))

    def begin(self, stage: Stage, *, simulation: bool = True) -> SessionFacts:
        """A session of its own for what is now driven; every further ride belongs to it.

        Raises:
            StoreError: if it cannot be written.
        """
        with self._lock:
            self._facts = self._opened(
                SessionFacts(
                    id="",
                    began=now_utc(),
                    scene=stage.scenario.name,
                    robot=stage.robot.name,
                    simulation=simulation,
                )
            )
            self._count = 0
            return self._facts

    def begin_ride(self) -> tuple[str, Path]:
        """The next ride's id, and the file in which the navigator's process keeps its rows.

        Raises:
            StoreError: if no session has begun, or its folder cannot be written.
        """
        with self._lock:
            if self._facts is None:
                raise StoreError("a ride belongs to a session; begin one first")
            if not (self.folder / self._facts.id).is_dir():  # it was deleted
                self._facts = self._opened(self._facts.model_copy(update={"began": now_utc()}))
                self._count = 0
            self._count += 1
            ride = f"{self._facts.id}-r{self._count}"
            return ride, self.folder / self._facts.id / f"{ride}.rows"

    def keep(self, record: RideRecord, log: RideLog | None, stage: Stage) -> None:
        """Keep a ride that has ended; its measures and its map are made aside.

        A ride whose session was deleted while it went on is not kept.

        Args:
            record: with an id of :meth:`begin_ride`.
            log: of the navigator's process; None: it is lost, and with it stops, route and
                destination; what is measured then comes of the rows that are on the disk.
            stage: that was driven in.
        """
        trouble = "" if log is not None else LOST
        session = self._file(record.id, "").parent.name
        record = record.model_copy(update={"session": session, "trouble": trouble})
        self._kept.add(record.id)
        rows = log or salvaged(record, self._file(record.id, ".rows"), stage.world.control_step)
        task = task_of(rows, stage.scenario, stage.robot, stage.grid)
        kept = self._do(self._writer, lambda: self._put(record, task))

        def measure() -> None:
            wait([kept])
            self._measure(record.id)

        self._do(self._measurer, measure)

    def rate(self, ride: str, rating: int) -> None:
        """How a ride was, 1 to 5; another time overwrites.

        Raises:
            StoreError: if there is no such ride.
        """
        if ride not in self._kept:
            self._ride(ride)
        self._do(self._writer, lambda: self._change(ride, rating=rating))

    def list(self) -> tuple[SessionSummary, ...]:
        """All sessions that have a ride, the newest first."""
        found = []
        for each in sorted(self._folders(), key=lambda f: age(f.name), reverse=True):
            with contextlib.suppress(StoreError):  # deleted meanwhile, or damaged
                found.append(self.summary(each.name))
        return tuple(each for each in found if each.rides)

    def summary(self, session: str) -> SessionSummary:
        """One session.

        Raises:
            StoreError: if there is none of this id.
        """
        folder = self._session(session)
        facts = read(SessionFacts, folder / "session.json")
        return SessionSummary(facts=facts, rides=tuple(rides_in(folder)))

    def html(self, session: str) -> str:
        """The session as a page that needs nothing else and can be printed; see ``summary``."""
        summary = self.summary(session)
        maps = {}
        for ride in summary.rides:
            with contextlib.suppress(StoreError):
                maps[ride.id] = self.png(ride.id)
        return report.session_html(summary, maps)

    def csv(self, session: str) -> str:
        """A row for each ride; see ``summary``."""
        return report.session_csv(self.summary(session))

    def png(self, id_: str) -> bytes:
        """The map of a ride, or of a session's last one that has one; see ``summary``.

        Raises:
            StoreError: if there is none, or not yet.
        """
        if RIDE.fullmatch(id_):
            file = self._file(id_, ".png")
        else:
            maps = [self._file(ride.id, ".png") for ride in self.summary(id_).rides]
            file = next((each for each in reversed(maps) if each.is_file()), None) or maps[-1]
        try:
            return file.read_bytes()
        except OSError:
            raise StoreError(f"there is no map of {id_}, or it is still being made") from None

    def delete_all(self) -> int:
        """Delete every session there is, the one going on too; how many they were.

        A ride that is going on is not kept. The audit log and the settings stay.

        Raises:
            StoreError: if something could not be deleted; names it.
        """
        count: int = self._do(self._writer, self._delete_all).result()
        return count

    def settle(self) -> None:
        """Wait until all that was to be written and measured is."""
        while True:
            with self._lock:
                left = set(self._pending)
            if not left:
                return
            wait(left)

    def close(self) -> None:
        """Write nothing more, after some seconds; a session without a ride leaves nothing behind.

        A ride that is not measured by then is at the next start.
        """
        with self._lock:
            left = set(self._pending)
        wait(left, CLOSING)
        self._ends.set()
        self.settle()
        self._measurer.shutdown()
        self._writer.shutdown()
        facts, self._facts = self._facts, None
        if facts is not None and not any(rides_in(self.folder / facts.id)):
            shutil.rmtree(self.folder / facts.id, ignore_errors=True)

    @property
    def trouble(self) -> str:
        """What could not be written last, in words; empty: nothing."""
        return self._trouble

    def _opened(self, facts: SessionFacts) -> SessionFacts:
        """The session with an id and a folder of its own."""
        stamp = datetime.now(UTC).astimezone().strftime("%Y%m%d-%H%M%S")
        numbers = itertools.count(1)
        while True:
            id_ = stamp if (number := next(numbers)) == 1 else f"{stamp}-{number}"
            if id_ in self._given:  # and deleted since: its last ride may still be written of
                continue
            try:
                (self.folder / id_).mkdir(mode=0o700)
            except FileExistsError:
                continue
            except OSError as cause:
                raise StoreError(f"cannot be made ({cause.strerror})", file=self.folder) from None
            self._given.add(id_)
            opened = facts.model_copy(update={"id": id_})
            write_whole(self.folder / id_ / "session.json", as_json(opened))
            return opened

    def _do(self, where: ThreadPoolExecutor, what: Callable[[], Any]) -> Future[Any]:
        """Have something done aside; what goes wrong is remembered."""
        future = where.submit(self._tried, what)
        with self._lock:
            self._pending.add(future)
        future.add_done_callback(self._pending.discard)
        return future

    def _tried(self, what: Callable[[], Any]) -> Any:
        try:
            return what()
        except StoreError as fault:
            _log.error("sessions: %s", fault)
            self._trouble = str(fault)
            raise

    def _put(self, record: RideRecord, task: bytes) -> None:
        """Of the writer's thread."""
        file = self._file(record.id, ".json")
        if file.parent.is_dir():  # else deleted while it went on
            write_whole(file, as_json(record))
            write_whole(file.with_suffix(".task"), task)

    def _change(self, ride: str, **changes: Any) -> None:
        """Of the writer's thread; a ride that was deleted stays so."""
        file = self._file(ride, ".json")
        if file.is_file():
            write_whole(file, as_json(read(RideRecord, file).model_copy(update=changes)))

    def _measure(self, ride: str) -> None:
        """Of the measurer's thread."""
        task, rows = self._file(ride, ".task"), self._file(ride, ".rows")
        if self._ends.is_set() or not (task.is_file() and rows.is_file()):
            return
        into = self._file(ride, ".measures.json")
        changes: dict[str, Any]
        try:
            measures = measured_aside(task, into, self._ends)
            into.with_suffix(".png").replace(self._file(ride, ".png"))
            changes = {"measures": measures}
        except Postponed:
            return
        except (StoreError, OSError) as fault:
            changes = {"trouble": str(fault)}
        self._do(self._writer, lambda: self._measured(ride, **changes))

    def _measured(self, ride: str, **changes: Any) -> None:
        """Of the writer's thread."""
        self._change(ride, **changes)
        for done in (".task", ".rows"):
            self._file(ride, done).unlink(missing_ok=True)

    def _delete_all(self) -> int:
        """Of the writer's thread; what is being measured meanwhile finds its folder gone."""
        at, number = self.folder, time.time_ns()  # a name of its own each time
        try:
            count = sum(any(rides_in(folder)) for folder in self._folders())
            with self._lock:  # a session is there whole, or not yet
                self._kept.clear()
                for at in self._folders():
                    at.rename(at.with_name(f"{DELETED}{number}-{at.name}"))
            for at in self.folder.glob(f"{DELETED}*"):  # and what was left of earlier times
                shutil.rmtree(at)
        except OSError as cause:
            raise StoreError(f"is not deleted ({cause.strerror or cause})", file=at) from None
        return count

    def _folders(self) -> tuple[Path, ...]:
        """Of all sessions, in no order."""
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
        return self.folder / ride.rpartition("-r")[0] / f"{ride}{suffix}"
