"""Measures, map and timeline of a ride from its log, computed in a process at the lowest priority.

A long ride takes seconds; in a thread that work would delay the control loop.
"""

from __future__ import annotations

import math
import os
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path as File
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import CohelmError, RecordingError, StoreError
from cohelm.evaluation.episode.ride import Outcome, Ride, StopEvent
from cohelm.evaluation.episode.ride_log import StopLog
from cohelm.evaluation.metrics import measure
from cohelm.live.messages import RideOutcome
from cohelm.live.sessions.database import OTHER_VERSION
from cohelm.live.sessions.records import RideStop, RideSummary, SessionInfo
from cohelm.live.sessions.ride_log import (
    CHAIR_SIZE,
    END,
    PATH,
    PERSON_SIZE,
    REASON,
    REQUEST,
    ROW,
    SESSION,
    SUMMARY,
)
from cohelm.live.sessions.ride_map import ride_map
from cohelm.live.sessions.timeline import timeline_of
from cohelm.messages import Path, Request
from cohelm.processes import end_with_owner, spawn, without_interrupts
from cohelm.reasons import Reason
from cohelm.recordings.bags.files import read_bag
from cohelm.recordings.bags.ros_messages import decode
from cohelm.recordings.rides.exact import unpack
from cohelm.recordings.rides.ride import FORMAT, RIDE_TOPIC, RideFacts
from cohelm.scenarios.scenario import Scenario

MEASURING_TIMEOUT = 60.0
"""Maximum time to measure a ride, s; then it is measured at the next start."""
MAX_STOPS = 500
"""Maximum number of stops of a ride; the longest ones are kept."""
_NEED_GOAL = frozenset({"success", "spl", "stalled_time"})
"""Measures that do not apply to a ride without a goal."""
_OUTCOMES = {
    "arrived": Outcome.REACHED,
    "collision": Outcome.COLLISION,
    "fell": Outcome.FELL,
    "cancelled": Outcome.STOPPED,
}
_REASONS = {each.value: each for each in Reason}


class MeasuringPostponed(Exception):
    """The program ends or is too busy; the log is on disk for the next start."""


class Measured(NamedTuple):
    """Result of reading a log."""

    summary: RideSummary
    """Last one in the log, with duration and length of its ticks, stops and measures."""
    png: bytes
    """Map."""
    timeline: bytes
    """JSON, see :mod:`.timeline`."""
    damage: str
    """Reason why the log was read up to some point only; empty: all of it was read."""


def measure_in_subprocess(file: File, ends: threading.Event) -> Measured:
    """Return the measures, map and timeline of a ride.

    Args:
        file: Log of the ride.
        ends: Set when the program ends.

    Raises:
        MeasuringPostponed: The program ends, or it took too long.
        StoreError: The log cannot be read, or not be measured.
    """
    answers, sender = spawn.Pipe(duplex=False)
    process = spawn.Process(target=_send_measured, args=(file, sender), daemon=True)
    with answers:
        with sender, without_interrupts():
            process.start()
        # Only the process has the sending end now: if it dies, the receiving end is readable.
        end = time.monotonic() + MEASURING_TIMEOUT
        while not answers.poll(0.1):
            if ends.is_set() or time.monotonic() > end:
                process.kill()
                process.join()
                raise MeasuringPostponed
        try:
            answer: Measured | str = answers.recv()
        except (EOFError, OSError):  # it died before its answer, or in the middle of it
            process.join()
            answer = f"the ride was not measured: exit code {process.exitcode}"
    process.join()
    if isinstance(answer, str):
        raise StoreError(answer)
    return answer


def read_head(file: File) -> tuple[SessionInfo, RideSummary]:
    """Return the session and the first summary of a log.

    Raises:
        StoreError: They cannot be read.
    """
    info: SessionInfo | None = None
    try:
        for message in read_bag([file], []):
            if message.topic == SESSION:
                info = SessionInfo.model_validate_json(decode(message).data)
            elif message.topic == SUMMARY and info is not None:
                return info, RideSummary.model_validate_json(decode(message).data)
    except (OSError, ValueError):
        pass
    raise StoreError("cannot be read", file=file)


def read_log(file: File) -> tuple[Ride, RideSummary, str]:
    """Return a ride as far as its log is sound, its last summary with stops, and the damage.

    Raises:
        StoreError: There is no tick, or the log is of another version.
    """
    log = _Log()
    damage: list[RecordingError] = []
    try:
        for message in read_bag([file], damage):
            log.add(message.topic, decode(message))
    except (OSError, ValueError, CohelmError) as cause:
        damage.append(RecordingError(str(cause), file=file))
    if log.facts is None or log.summary is None or not log.rows:
        problem = damage[0].problem if damage else "holds no tick"
        raise StoreError(f"cannot be read ({problem})", file=file)
    ride = log.ride(log.facts, log.summary.outcome)
    track = np.hypot(*np.diff(ride.pose[:, :2], axis=0).T)
    nearest = float(ride.nearest.min())
    summary = log.summary.model_copy(
        update={
            "duration": round(float(ride.time[-1]), 2),
            "length": round(float(track.sum()), 2),
            "stops": tuple(map(_ride_stop, _longest(log.stops.all))),
            "nearest": round(nearest, 3) if math.isfinite(nearest) else None,
        }
    )
    problem = damage[0].problem if damage else "" if log.ended else "its end is missing"
    return ride, summary, problem


class _Log:
    """Content of a log, collected message by message."""

    def __init__(self) -> None:
        self.facts: RideFacts | None = None
        self.summary: RideSummary | None = None
        self.ended = False
        self.rows: list[Floats] = []
        self.stops = StopLog()
        self._request: Request | None = None
        self._path: Path | None = None
        self._prefer: tuple[Floats, ...] = ()
        self._reason: Reason | None = None

    def add(self, topic: str, message: Any) -> None:
        if topic == ROW:
            self.rows.append(message.data)
            self.stops.add_reason(float(message.data[0]), self._reason)
        elif topic in {SUMMARY, END}:
            self.ended = topic == END
            self.summary = RideSummary.model_validate_json(message.data)
        elif topic == REASON:
            self._reason = _REASONS.get(message.data)
        elif topic == REQUEST:
            # The ride ends with a request for the next destination, or for none.
            if self._request is None or np.isnan(self._request.goal).any():
                self._request = unpack(bytes(message.data), Request)
        elif topic == PATH:
            self._path = unpack(bytes(message.data), Path)
            wishes = self._request.wishes if self._request is not None else ()
            self._prefer = tuple(each.points for each in wishes if each.kind == "attract")
        elif topic == RIDE_TOPIC:
            self.facts = unpack(bytes(message.data), RideFacts)
            if self.facts.format != FORMAT:
                raise ValueError(OTHER_VERSION)

    def ride(self, facts: RideFacts, outcome: RideOutcome) -> Ride:
        """Return the arrays of the ride; people are absent before they appeared."""
        k, n = len(self.rows), max((len(row) - CHAIR_SIZE) // PERSON_SIZE for row in self.rows)
        chair = np.stack([row[:CHAIR_SIZE] for row in self.rows]).astype(np.float64)
        absent = [np.inf, 0.0, 0.0, *[np.nan] * 4, 0.0, 0.0, np.nan]
        people = np.tile(np.array(absent), (k, n, 1))
        for tick, row in zip(people, self.rows, strict=True):
            there = row[CHAIR_SIZE:].reshape(-1, PERSON_SIZE)
            tick[: len(there)] = there
        return Ride(
            scenario=Scenario.model_validate(facts.scenario),
            seed=facts.seed,
            outcome=_OUTCOMES[outcome],
            robot=facts.robot,
            grid=facts.grid,
            world=facts.grid,
            goal=np.full(2, np.nan) if self._request is None else self._request.goal,
            prefer=np.vstack([np.empty((0, 2)), *self._prefer]),
            step=float(chair[-1, 0] - chair[0, 0]) / max(k - 1, 1),
            time=chair[:, 0],
            pose=chair[:, 1:4],
            twist=chair[:, 4:7],
            gap_wall=chair[:, 7],
            hit_wall=chair[:, 8] > 0.0,
            command=chair[:, 9:12],
            requested=chair[:, 12:15],
            stick=chair[:, 15:17],
            eta=chair[:, 17],
            gap_people=people[:, :, 0],
            hit_moving=people[:, :, 1] > 0.0,
            hit_standing=people[:, :, 2] > 0.0,
            people=people[:, :, 3:7],
            people_heading=people[:, :, 7],
            people_target=people[:, :, 8].astype(np.int64),
            people_radius=people[-1, :, 9],
            path=self._path,
            durations={},
        )


def measures_of(ride: Ride) -> dict[str, float]:
    """Return the measures that apply to this ride."""
    skipped = _NEED_GOAL if np.isnan(ride.goal).any() else frozenset()
    return {
        name: float(number)
        for name, number in measure(ride).items()
        if math.isfinite(number) and name not in skipped
    }


def _longest(stops: list[StopEvent]) -> list[StopEvent]:
    """Return the longest stops, in order of time."""
    kept = sorted(stops, key=lambda stop: stop.duration, reverse=True)[:MAX_STOPS]
    return sorted(kept, key=lambda stop: stop.time)


def _ride_stop(stop: StopEvent) -> RideStop:
    """Convert a stop without its detail, which has coordinates."""
    code, text = stop.reason.value, stop.reason.sentence
    return RideStop(time=stop.time, duration=stop.duration, code=code, text=text)


def _send_measured(file: File, sender: Connection) -> None:
    """Main function of the measuring process."""
    end_with_owner()
    os.nice(19)
    answer: Measured | str
    try:
        ride, summary, damage = read_log(file)
        timeline = timeline_of(ride, summary.stops).model_dump_json(exclude_none=False)
        measured = summary.model_copy(update={"measures": measures_of(ride)})
        answer = Measured(measured, ride_map(ride), timeline.encode(), damage)
    except Exception as error:  # a log of another version may fail in any way
        problem = str(error) if isinstance(error, StoreError) else f"{type(error).__name__} {error}"
        answer = f"the ride was not measured: {problem}".strip()
    sender.send(answer)
