"""Log of a live ride: one MCAP file, on disk up to the last second at any time.

    /cohelm/ride      once         ``RideFacts``: scenario, robot and map, packed
    /cohelm/session   once         ``SessionInfo``, JSON
    /cohelm/summary   each second  ``RideSummary`` so far, JSON
    /cohelm/end       at the end   final ``RideSummary``, JSON; a ride without it was interrupted
    /cohelm/request   a change     ``Request``, packed
    /cohelm/path      once         first ``Path``, packed
    /cohelm/reason    a change     code of the reason at the wheels; empty: none
    /cohelm/row       every tick   numbers of :func:`row_of_tick`, float32

The navigator's process writes it in a thread of its own, so that no tick waits for the disk.
"""

from __future__ import annotations

import contextlib
import copy
import logging
import math
import os
import queue
import threading
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path as File
from typing import IO, Any, cast

import numpy as np

from cohelm.arrays import Floats32, replace
from cohelm.evaluation.episode.recorded import facts_of
from cohelm.evaluation.episode.ride_log import row_of, states_of
from cohelm.health import NO_CHANGES
from cohelm.live.sessions.files import unwritable
from cohelm.live.sessions.records import RideBegin, RideLog
from cohelm.messages import Path, Request
from cohelm.navigation import Tick
from cohelm.recordings.rides import ros_messages as ros
from cohelm.recordings.rides.exact import pack
from cohelm.recordings.rides.recorder import McapWriter
from cohelm.recordings.rides.ride import RIDE_TOPIC, RideFacts
from cohelm.scenarios.build import RideSetup
from cohelm.simulation import GroundTruth

SESSION, SUMMARY, END = (f"/cohelm/{name}" for name in ("session", "summary", "end"))
REQUEST, PATH, REASON, ROW = (f"/cohelm/{name}" for name in ("request", "path", "reason", "row"))
FLUSH = 1.0
"""Interval of writes to the disk, s."""
MAX_WAITING = 20_000
"""Number of messages that wait for the thread above which ticks are lost."""
MAX_UNWRITTEN = 50_000_000
"""Maximum size of what a full disk has rejected and is tried again, bytes: some hours."""
CHAIR_SIZE, PERSON_SIZE = 18, 10
_log = logging.getLogger(__name__)


class RideLogWriter:
    """Log of one ride after another, each between :meth:`begin` and :meth:`end`.

    Args:
        facts: Returns the facts of the rides; called once, in the thread.
    """

    def __init__(self, facts: Callable[[], RideFacts]) -> None:
        self._facts, self._packed = facts, b""
        self._ride = ""
        self._request: Request | None = None
        self._path: Path | None = None
        self._reason = ""
        self._begun = math.nan
        """Time of the first tick, s."""
        self._lost = 0
        """Ticks of this ride that the queue did not take."""
        self._changes = NO_CHANGES
        self._queue: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._finished: deque[RideLog] = deque()
        self._file: _RideFile | None = None
        """File of the ride; belongs to the thread."""
        self._thread: threading.Thread | None = None

    @property
    def error(self) -> str:
        """Reason why the log of this ride is not stored; empty if it is."""
        file = self._file
        return file.error if file is not None else ""

    def begin(self, begin: RideBegin) -> None:
        """Begin a ride with the next tick; an unfinished one keeps what it has."""
        if self._thread is None:
            self._thread = threading.Thread(target=self._run, name="ride-log", daemon=True)
            self._thread.start()
        self._ride, self._begun, self._lost = begin.ride, math.nan, 0
        self._request, self._path, self._reason = None, None, ""
        self._queue.put(partial(self._open, begin))

    def summarise(self, summary: str) -> None:
        """Add the summary so far, JSON."""
        if self._ride and summary:
            self._queue.put(partial(self._add, SUMMARY, summary, 0.0))

    def add(self, tick: Tick, truth: GroundTruth) -> None:
        """Add a tick to the current ride, if there is one."""
        if not self._ride:
            return
        if math.isnan(self._begun):
            self._begun = truth.time
        now = truth.time - self._begun
        code = "" if tick.decision.reason is None else tick.decision.reason.value
        if tick.request is not self._request:
            self._queue.put(partial(self._add, REQUEST, tick.request, now))
        if self._path is None and tick.path is not None:
            self._queue.put(partial(self._add, PATH, tick.path, now))
        if code != self._reason:
            self._queue.put(partial(self._add, REASON, code, now))
        self._request, self._path, self._reason = tick.request, self._path or tick.path, code
        if tick.memory.health is not None:
            self._changes = tick.memory.health.changes
        if self._queue.qsize() < MAX_WAITING:
            self._queue.put(partial(self._add, ROW, row_of_tick(tick, truth, now), now))
        else:  # the disk hangs
            self._lost += 1

    def end(self, summary: str) -> None:
        """End the ride; :meth:`finished` returns its log once the file is closed."""
        if self._ride:
            self._queue.put(partial(self._add, END, summary, 0.0))
            self._queue.put(partial(self._close, self._ride, self._changes, self._lost))
        self._ride = ""

    def finished(self) -> RideLog | None:
        """Return the log of a ride that has ended, each once; None: there is none yet."""
        return self._finished.popleft() if self._finished else None

    def close(self) -> None:
        """Write what waits, and end the thread."""
        if self._thread is not None:
            self._queue.put(None)
            self._thread.join()

    def _run(self) -> None:
        """Write, in the thread."""
        due = time.monotonic()
        while True:
            with contextlib.suppress(queue.Empty):
                task = self._queue.get(timeout=FLUSH)
                if task is None:
                    break
                try:
                    task()
                except Exception as error:  # this ride's log ends; the next one begins anew
                    _log.exception("the log of a ride has ended")
                    if self._file is not None:
                        self._file.error = str(error)
            if self._file is not None and time.monotonic() >= due:
                self._file.store()
                due = time.monotonic() + FLUSH
        if self._file is not None:
            self._file.close()

    def _open(self, begin: RideBegin) -> None:
        if self._file is not None:
            self._file.close()
        self._packed = self._packed or pack(self._facts())
        self._file = _RideFile(begin.file)
        self._add(RIDE_TOPIC, self._packed, 0.0)
        self._add(SESSION, begin.session, 0.0)
        self._add(SUMMARY, begin.summary, 0.0)
        self._file.store()

    def _add(self, topic: str, content: Any, now: float) -> None:
        if self._file is not None:
            self._file.add(topic, content, now)

    def _close(self, ride: str, changes: Any, lost: int) -> None:
        file, self._file = self._file, None
        if file is None:
            return
        lost += file.close()
        self._finished.append(RideLog(ride=ride, lost_ticks=lost, changes=changes))


class _RideFile:
    """MCAP file that takes what a full disk has rejected once there is space."""

    def __init__(self, file: File) -> None:
        self._disk = _Disk(file)
        self._writer = McapWriter(file, cast("IO[bytes]", self._disk))
        self.error = ""
        self._unwritten = self._lost = 0
        """Ticks that are not on disk yet, and that are given up."""

    def add(self, topic: str, content: Any, now: float) -> None:
        if len(self._disk.waiting) > MAX_UNWRITTEN:
            self._lost += topic == ROW
            return
        if isinstance(content, str):
            message = ros.of("std_msgs/msg/String")(data=content)
        elif isinstance(content, np.ndarray):
            layout = ros.of("std_msgs/msg/MultiArrayLayout")(dim=[], data_offset=0)
            message = ros.of("std_msgs/msg/Float32MultiArray")(layout=layout, data=content)
        else:
            message = ros.octets(content if isinstance(content, bytes) else pack(content))
        self._writer.write(topic, message, now)
        self._unwritten += topic == ROW

    def store(self) -> None:
        """Put everything on disk; after a failure all of it is tried again."""
        self._writer.flush()
        try:
            self._disk.store()
        except OSError as cause:
            error = unwritable(self._disk.file, cause)
            if not self.error:  # once, not at every attempt
                _log.error("a ride is not stored: %s", error)
            self.error = error.problem
        else:
            self.error, self._unwritten = "", 0

    def close(self) -> int:
        """Write the rest and the index; returns the number of ticks that are lost."""
        self.store()
        unwritten, self._unwritten = self._unwritten, 0
        self._writer.close()
        if not unwritten:
            self.store()
        self._disk.end()
        return self._lost + unwritten


class _Disk:
    """Stream in memory that :meth:`store` puts on disk: all that waits, or nothing of it."""

    def __init__(self, file: File) -> None:
        self.file, self.waiting = file, bytearray()
        self._handle: int | None = None
        self._size = 0

    def write(self, data: bytes) -> int:
        self.waiting += data
        return len(data)

    def tell(self) -> int:
        return self._size + len(self.waiting)

    def flush(self) -> None:
        """Do nothing: see :meth:`store`."""

    close = flush

    def store(self) -> None:
        if self._handle is None:
            flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
            self.file.parent.mkdir(mode=0o700, exist_ok=True)
            self._handle = os.open(self.file, flags, 0o600)
        try:
            done = 0
            while done < len(self.waiting):
                done += os.pwrite(self._handle, self.waiting[done:], self._size + done)
            os.fsync(self._handle)
        except OSError:
            with contextlib.suppress(OSError):
                os.ftruncate(self._handle, self._size)
            raise
        self._size += done
        self.waiting.clear()

    def end(self) -> None:
        handle, self._handle = self._handle, None
        if handle is not None:
            with contextlib.suppress(OSError):  # all is flushed
                os.close(handle)


def facts_of_log(ride_setup: RideSetup) -> RideFacts:
    """Return the facts of a ride for its log, without the habits learned from other rides."""
    facts = facts_of(ride_setup)
    scenario = copy.deepcopy(dict(facts.scenario))
    scenario["destinations"]["inference"]["habits"] = {}
    return replace(facts, scenario=scenario, grid=ride_setup.grid, filters=(), heat=None)


def row_of_tick(tick: Tick, truth: GroundTruth, now: float) -> Floats32:
    """Return the numbers of a tick, (CHAIR_SIZE + n · PERSON_SIZE,).

    Of the chair: time since the first tick, s, pose 3, twist 3, gap to the wall, m, contact with
    it, command 3, requested 3, stick 2, η. Of each person: gap, m, contact while the chair moved,
    and while it stood, (x, y, v_x, v_y), heading, index of the waypoint, radius, m.

    Args:
        tick: Tick of the navigator.
        truth: Ground truth at the same time.
        now: Time since the first tick, s.
    """
    crowd = truth.crowd
    chair = np.concatenate(
        [[now], truth.pose, truth.twist, [truth.gap_wall, truth.hit_wall], row_of(tick)]
    )
    people = np.column_stack(
        [
            truth.gap_people, truth.hit_moving, truth.hit_standing, states_of(crowd),
            crowd.heading, crowd.target, crowd.radius,
        ]
    )  # fmt: skip
    return np.concatenate([chair, people.ravel()]).astype(np.float32)
