"""Measures and map of a stored ride, computed in a process of its own at the lowest priority.

A long ride takes seconds, and the control loop shares its interpreter with other threads.
"""

from __future__ import annotations

import json
import math
import os
import pickle
import sys
import threading
import time
from pathlib import Path

import numpy as np

from cohelm.arrays import Floats, Floats32
from cohelm.errors import StoreError
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.metrics import measure
from cohelm.live.sessions.files import write_whole
from cohelm.live.sessions.records import RideLog, RideSummary
from cohelm.live.sessions.ride_log import EACH, OWN
from cohelm.live.sessions.ride_map import ride_map
from cohelm.maps import OccupancyGrid
from cohelm.processes import end_with_owner, spawn, without_interrupts
from cohelm.robots import Robot
from cohelm.scenarios.scenario import Scenario

PATIENCE = 60.0
"""Maximum time to measure a ride, s; then it has no measures."""
_NOWHERE = frozenset({"success", "spl", "stalled_time"})
"""Measures that do not apply to a ride without a goal."""
_OUTCOMES = {
    "arrived": Outcome.REACHED,
    "collision": Outcome.COLLISION,
    "cancelled": Outcome.STOPPED,
}


class MeasuringPostponed(Exception):
    """The program ends; all inputs are on disk for the next start."""


def task_of(log: RideLog, scenario: Scenario, robot: Robot, grid: OccupancyGrid) -> bytes:
    """Return the pickled inputs of the measures besides the rows, for this program version.

    Args:
        log: Log of the ride.
        scenario, robot, grid: Those of the ride.
    """
    return pickle.dumps((log, scenario, robot, grid), protocol=5)


def measured_aside(task: Path, into: Path, ends: threading.Event) -> dict[str, float]:
    """Return the measures of a ride; its map is written as ``into`` with ``.png``.

    Args:
        task: File with the result of :func:`task_of`, in our own folder: it is unpickled.
        into: JSON file for the answer of the other process; removed afterwards.
        ends: Set when the program ends.

    Raises:
        MeasuringPostponed: The program ends.
        StoreError: The measures could not be computed.
    """
    process = spawn.Process(target=_write_measures, args=(task, into), daemon=True)
    with without_interrupts():
        process.start()
    end = time.monotonic() + PATIENCE
    while process.is_alive() and not ends.is_set() and time.monotonic() < end:
        process.join(0.1)
    if process.is_alive():
        process.kill()
        process.join()
        if ends.is_set():
            raise MeasuringPostponed
        raise StoreError(f"the ride was not measured within {PATIENCE:g} s")
    try:
        answer = json.loads(into.read_text(encoding="utf-8"))
        into.unlink()
    except (OSError, ValueError):
        raise StoreError(f"the ride was not measured: exit code {process.exitcode}") from None
    if isinstance(answer, str):
        raise StoreError(answer)
    return {name: float(number) for name, number in answer.items()}


def salvaged(record: RideSummary, file: Path, step: float) -> RideLog:
    """Return a log with the facts known without the navigator's process.

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
    own, people = _rows(log.file)
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
        time=own[:, 0],
        pose=own[:, 1:4],
        twist=own[:, 4:7],
        gap_wall=own[:, 7],
        hit_wall=own[:, 8] > 0.0,
        command=own[:, 9:12],
        requested=own[:, 12:15],
        stick=own[:, 15:17],
        eta=own[:, 17],
        gap_people=people[:, :, 0],
        hit_moving=people[:, :, 1] > 0.0,
        hit_standing=people[:, :, 2] > 0.0,
        people=people[:, :, 3:7],
        people_heading=people[:, :, 7],
        people_target=people[:, :, 8].astype(np.int64),
        people_radius=people[-1, :, 9] if k else np.empty(n),
        path=log.path,
        durations={},
    )


def measures_of(ride: Ride) -> dict[str, float]:
    """Return the measures that apply to this ride."""
    nowhere = _NOWHERE if np.isnan(ride.goal).any() else frozenset()
    return {
        name: float(number)
        for name, number in measure(ride).items()
        if math.isfinite(number) and name not in nowhere
    }


def _write_measures(task: Path, into: Path) -> None:
    """Main function of the measuring process."""
    end_with_owner()
    os.nice(19)
    answer: dict[str, float] | str
    try:
        ride = ride_of(*pickle.loads(task.read_bytes()))
        answer = measures_of(ride)
        write_whole(into.with_suffix(".png"), ride_map(ride))
    except Exception as fault:  # a task of another program version may fail in any way
        answer = f"the ride was not measured: {type(fault).__name__} {fault}".strip()
    try:
        write_whole(into, json.dumps(answer).encode())
    except StoreError:  # the session was deleted meanwhile
        sys.exit(1)


def _rows(file: Path) -> tuple[Floats, Floats]:
    """(k, OWN) for the chair, (k, n, EACH) for people; NaN before a person appeared."""
    try:
        numbers = np.fromfile(file, dtype=np.float32)
    except OSError as cause:
        raise StoreError(f"cannot be read ({cause.strerror or cause})", file=file) from None
    starts, counts = _starts(numbers)
    if not len(starts):
        raise StoreError("holds no tick", file=file)
    own = np.stack([numbers[s + 1 : s + 1 + OWN] for s in starts]).astype(np.float64)
    people = np.full((len(starts), max(counts), EACH), np.nan)
    people[:, :, 0] = np.inf
    people[:, :, [1, 2, 7, 8]] = 0.0
    for k, (s, n) in enumerate(zip(starts, counts, strict=True)):
        people[k, :n] = numbers[s + 1 + OWN : s + 1 + OWN + n * EACH].reshape(n, EACH)
    return own, people


def _starts(numbers: Floats32) -> tuple[list[int], list[int]]:
    """Start of each complete row, and its number of people; the last row may be incomplete."""
    starts, counts, at = [], [], 0
    while at < len(numbers):
        n = int(numbers[at])
        end = at + 1 + OWN + n * EACH
        if n < 0 or end > len(numbers):
            break
        starts.append(at)
        counts.append(n)
        at = end
    return starts, counts
