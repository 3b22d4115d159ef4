"""What is kept of sessions: in one folder of this machine, and gone by one action.

    DIR/                       0700, every file in it 0600
      settings.json            limits and the rider's settings, see ``limits``
      audit.jsonl              see ``audit``; deleting sessions leaves it
      20260131-142530/         a session
        session.json
        20260131-142530-r1.json   a ride's record; .png its map; .rows its log until it is measured

Every method may be called from any thread. Writing is done aside, in the order asked for, so that
nobody who drives waits for a disk; what goes wrong there stands in :attr:`Sessions.trouble`.
"""

from __future__ import annotations

import contextlib
import re
import shutil
import threading
import time as clock
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor, wait
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, TypeVar

from cohelm.driving import report
from cohelm.driving.files import own_folder, write_whole
from cohelm.driving.measuring import measured_aside, salvaged
from cohelm.driving.records import RideLog, RideRecord, SessionFacts, SessionSummary
from cohelm.errors import StoreError
from cohelm.evaluation.staging import Stage

LOST = "The navigator was lost before it had told of stops, route and destination."
"""Of a ride whose log is."""
_SESSION = re.compile(r"\d{8}-\d{6}(-\d+)?")
_RIDE = re.compile(r"(\d{8}-\d{6}(?:-\d+)?)-r\d+")
_T = TypeVar("_T", SessionFacts, RideRecord)
_DAY = 86_400.0


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
        self._lock = threading.Lock()
        self._facts: SessionFacts | None = None
        self._kept: set[str] = set()
        self._count = 0
        self._trouble = ""
        _sweep(self.folder)

    def begin(self, stage: Stage, *, simulation: bool = True) -> SessionFacts:
        """A session of its own for what is now driven; every further ride belongs to it.

        Raises:
            StoreError: if it cannot be written.
        """
        with self._lock:
            self._facts = self._opened(
                SessionFacts(
                    id="",
                    began=_now(),
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
                self._facts = self._opened(self._facts.model_copy(update={"began": _now()}))
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
        self._do(self._writer, lambda: self._put(record))
        rows = log or salvaged(record, self._file(record.id, ".rows"), stage.world.control_step)
        self._do(self._measurer, lambda: self._measure(record.id, rows, stage))

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
        folders = [f for f in self.folder.iterdir() if _SESSION.fullmatch(f.name)]
        folders.sort(key=lambda folder: _age(folder.name), reverse=True)
        found = []
        for each in folders:
            with contextlib.suppress(StoreError):  # deleted meanwhile, or damaged
                found.append(self.summary(each.name))
        return tuple(each for each in found if each.rides)

    def summary(self, session: str) -> SessionSummary:
        """One session.

        Raises:
            StoreError: if there is none of this id.
        """
        folder = self._session(session)
        facts = _read(SessionFacts, folder / "session.json")
        return SessionSummary(facts=facts, rides=tuple(_rides(folder)))

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
        if _RIDE.fullmatch(id_):
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
        """Settle, and write nothing more; a session without a ride leaves nothing behind."""
        self.settle()
        self._measurer.shutdown()
        self._writer.shutdown()
        facts, self._facts = self._facts, None
        if facts is not None and not any(_rides(self.folder / facts.id)):
            shutil.rmtree(self.folder / facts.id, ignore_errors=True)

    @property
    def trouble(self) -> str:
        """What could not be written last, in words; empty: nothing."""
        return self._trouble

    def _opened(self, facts: SessionFacts) -> SessionFacts:
        """The session with an id and a folder of its own."""
        stamp, number = datetime.now(UTC).astimezone().strftime("%Y%m%d-%H%M%S"), 1
        while True:
            id_ = stamp if number == 1 else f"{stamp}-{number}"
            try:
                (self.folder / id_).mkdir(mode=0o700)
            except FileExistsError:
                number += 1
                continue
            except OSError as cause:
                raise StoreError(f"cannot be made ({cause.strerror})", file=self.folder) from None
            opened = facts.model_copy(update={"id": id_})
            write_whole(self.folder / id_ / "session.json", _json(opened))
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
            self._trouble = str(fault)
            raise

    def _put(self, record: RideRecord) -> None:
        """Of the writer's thread."""
        file = self._file(record.id, ".json")
        if file.parent.is_dir():  # else deleted while it went on
            write_whole(file, _json(record))

    def _change(self, ride: str, **changes: Any) -> None:
        """Of the writer's thread; a ride that was deleted stays so."""
        file = self._file(ride, ".json")
        if file.is_file():
            write_whole(file, _json(_read(RideRecord, file).model_copy(update=changes)))

    def _measure(self, ride: str, log: RideLog, stage: Stage) -> None:
        """Of the measurer's thread."""
        if not log.file.is_file():
            return
        into = self._file(ride, ".measures.json")
        changes: dict[str, Any]
        try:
            measures = measured_aside(log, stage.scenario, stage.robot, stage.grid, into)
            into.with_suffix(".png").replace(self._file(ride, ".png"))
            changes = {"measures": measures}
        except (StoreError, OSError) as fault:
            changes = {"trouble": str(fault)}
        finally:
            log.file.unlink(missing_ok=True)
        self._do(self._writer, lambda: self._change(ride, **changes))

    def _delete_all(self) -> int:
        """Of the writer's thread."""
        folders = [f for f in self.folder.iterdir() if _SESSION.fullmatch(f.name)]
        count = sum(any(_rides(folder)) for folder in folders)
        for each in folders:
            try:
                shutil.rmtree(each)
            except OSError as cause:
                raise StoreError(f"is not deleted ({cause.strerror or cause})", file=each) from None
        self._kept.clear()
        return count

    def _session(self, session: str) -> Path:
        folder = self.folder / session
        if not _SESSION.fullmatch(session) or not folder.is_dir():
            raise StoreError("there is no such session")
        return folder

    def _ride(self, ride: str) -> Path:
        if not _RIDE.fullmatch(ride) or not self._file(ride, ".json").is_file():
            raise StoreError("there is no such ride")
        return self._file(ride, ".json")

    def _file(self, ride: str, suffix: str) -> Path:
        return self.folder / ride.rpartition("-r")[0] / f"{ride}{suffix}"


def _age(session: str) -> tuple[str, int]:
    """By which sessions are in order."""
    return session[:15], int(session[16:] or 1)


def _rides(folder: Path) -> Iterator[RideRecord]:
    """The rides of a session that can be read, the oldest first."""
    files = [f for f in folder.glob("*.json") if _RIDE.fullmatch(f.stem)]
    for file in sorted(files, key=lambda f: int(f.stem.rpartition("-r")[2])):
        with contextlib.suppress(StoreError):
            yield _read(RideRecord, file)


def _read(kind: type[_T], file: Path) -> _T:
    try:
        return kind.model_validate_json(file.read_bytes())
    except (OSError, ValueError):
        raise StoreError("does not read", file=file) from None


def _json(model: SessionFacts | RideRecord) -> bytes:
    return model.model_dump_json(indent=1).encode() + b"\n"


def _sweep(folder: Path) -> None:
    """Remove what a program that was killed left half done, once it is a day old."""
    for pattern in ("*/*.rows", "*/.*", "*/*.measures.*"):
        for file in folder.glob(pattern):
            with contextlib.suppress(OSError):
                if clock.time() - file.stat().st_mtime > _DAY:
                    file.unlink()


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")
