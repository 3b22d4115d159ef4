"""Measures and map of a stored ride, computed in a process of its own at the lowest priority.

A long ride takes seconds; in a thread that work would delay the control loop.
"""

from __future__ import annotations

import math
import os
import pickle
import threading
import time
from multiprocessing.connection import Connection
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cohelm.errors import StoreError
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.metrics import measure
from cohelm.live.sessions.records import RideLog, RideSummary
from cohelm.live.sessions.ride_map import ride_map
from cohelm.live.sessions.ride_rows import ChairColumn, PersonColumn, read_rows
from cohelm.live.sessions.timeline import timeline_of
from cohelm.maps import OccupancyGrid
from cohelm.processes import end_with_owner, spawn, without_interrupts
from cohelm.robots import Robot
from cohelm.scenarios.scenario import Scenario

MEASURING_TIMEOUT = 60.0
"""Maximum time to measure a ride, s; then it is measured at the next start."""
_NEED_GOAL = frozenset({"success", "spl", "stalled_time"})
"""Measures that do not apply to a ride without a goal."""
_OUTCOMES = {
    "arrived": Outcome.REACHED,
    "collision": Outcome.COLLISION,
    "fell": Outcome.FELL,
    "cancelled": Outcome.STOPPED,
}


class MeasuringPostponed(Exception):
    """The program ends or is too busy; all inputs are on disk for the next start."""


def task_of(log: RideLog, scenario: Scenario, robot: Robot, grid: OccupancyGrid) -> bytes:
    """Return the pickled inputs of the measures besides the rows, for this program version.

    Args:
        log: Log of the ride.
        scenario, robot, grid: Those of the ride.
    """
    return pickle.dumps((log, scenario, robot, grid), protocol=5)


class Measured(NamedTuple):
    """Measures of a ride, its map and its timeline, beside its summary."""

    measures: dict[str, float]
    png: bytes
    """Map."""
    timeline: bytes
    """JSON, see :mod:`.timeline`."""


def measure_in_subprocess(task: Path, ends: threading.Event) -> Measured:
    """Return the measures, map and timeline of a ride.

    Args:
        task: File with the result of :func:`task_of`, in our own folder: it is unpickled.
        ends: Set when the program ends.

    Raises:
        MeasuringPostponed: The program ends, or it took too long.
        StoreError: The measures could not be computed.
    """
    answers, sender = spawn.Pipe(duplex=False)
    process = spawn.Process(target=_send_measured, args=(task, sender), daemon=True)
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


def log_without_navigator(record: RideSummary, file: Path, step: float) -> RideLog:
    """Return the log of a ride whose navigator was lost: only what its summary says.

    Args:
        record: Summary of the ride.
        file: Its rows, as far as they are on disk.
        step: Time between ticks, s.
    """
    return RideLog(
        ride=record.id,
        file=file,
        outcome=record.outcome,
        step=step,
        goal=np.full(2, np.nan),
        stops=(),
        path=None,
        prefer=np.empty((0, 2)),
    )


def ride_of(log: RideLog, scenario: Scenario, robot: Robot, grid: OccupancyGrid) -> Ride:
    """Return the ride in a log's rows.

    Raises:
        StoreError: The rows are missing, or none is complete.
    """
    chair, people = read_rows(log.file)
    k, n = people.shape[:2]
    return Ride(
        scenario=scenario,
        seed=scenario.seed,
        outcome=_OUTCOMES[log.outcome],
        robot=robot,
        grid=grid,
        world=grid,
        goal=log.goal,
        prefer=log.prefer,
        step=log.step,
        time=chair[:, ChairColumn.TIME],
        pose=chair[:, ChairColumn.POSE],
        twist=chair[:, ChairColumn.TWIST],
        gap_wall=chair[:, ChairColumn.GAP_WALL],
        hit_wall=chair[:, ChairColumn.HIT_WALL] > 0.0,
        command=chair[:, ChairColumn.COMMAND],
        requested=chair[:, ChairColumn.REQUESTED],
        stick=chair[:, ChairColumn.STICK],
        eta=chair[:, ChairColumn.ETA],
        gap_people=people[:, :, PersonColumn.GAP],
        hit_moving=people[:, :, PersonColumn.HIT_MOVING] > 0.0,
        hit_standing=people[:, :, PersonColumn.HIT_STANDING] > 0.0,
        people=people[:, :, PersonColumn.STATE],
        people_heading=people[:, :, PersonColumn.HEADING],
        people_target=people[:, :, PersonColumn.WAYPOINT].astype(np.int64),
        people_radius=people[-1, :, PersonColumn.RADIUS] if k else np.empty(n),
        path=log.path,
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


def _send_measured(task: Path, sender: Connection) -> None:
    """Main function of the measuring process."""
    end_with_owner()
    os.nice(19)
    answer: Measured | str
    try:
        log, scenario, robot, grid = pickle.loads(task.read_bytes())
        ride = ride_of(log, scenario, robot, grid)
        timeline = timeline_of(ride, log.stops).model_dump_json(exclude_none=False)
        answer = Measured(measures_of(ride), ride_map(ride), timeline.encode())
    except Exception as error:  # a task of another program version may fail in any way
        problem = f"{type(error).__name__} {error}".strip()
        answer = f"the ride was not measured: {problem}"
    sender.send(answer)
