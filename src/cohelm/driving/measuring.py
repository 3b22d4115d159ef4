"""What a ride's rows come to: the measures of the evaluation, and a map of the ride.

It runs in a process of its own at the lowest priority: the chair's threads share an interpreter,
and a long ride takes seconds to be measured.
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
from cohelm.driving.files import write_whole
from cohelm.driving.logbook import EACH, OWN
from cohelm.driving.records import RideLog, RideRecord
from cohelm.driving.ride_map import ride_map
from cohelm.errors import StoreError
from cohelm.evaluation.metrics import measure
from cohelm.evaluation.processes import end_with_owner, spawn, without_interrupts
from cohelm.evaluation.ride import Outcome, Ride
from cohelm.evaluation.scenario import Scenario
from cohelm.maps import OccupancyGrid
from cohelm.robots import Robot

PATIENCE = 60.0
"""For a ride to be measured, s; then it has no measures."""
_NOWHERE = frozenset({"success", "spl", "stalled_time"})
"""Measures that have no meaning where the ride had no goal."""
_OUTCOMES = {
    "arrived": Outcome.REACHED,
    "collision": Outcome.COLLISION,
    "left": Outcome.STOPPED,
}


class Postponed(Exception):
    """There was no time for it now; all that it needs is on the disk."""


def task_of(log: RideLog, scenario: Scenario, robot: Robot, grid: OccupancyGrid) -> bytes:
    """All that a ride is measured from besides its rows, for this version of the program.

    Args:
        log: of the ride.
        scenario: that it was of.
        robot: that was driven.
        grid: the map that it was driven on.
    """
    return pickle.dumps((log, scenario, robot, grid), protocol=5)


def measured_aside(task: Path, into: Path, ends: threading.Event) -> dict[str, float]:
    """The measures of a ride; its map is written beside, as ``into`` with ``.png``.

    Args:
        task: holds what :func:`task_of` says; a file of our own folder, for it is unpickled.
        into: a JSON file through which the other process answers; gone afterwards.
        ends: set where there is no time for it any more.

    Raises:
        Postponed: if there was none.
        StoreError: if they could not be taken; says why.
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
            raise Postponed
        raise StoreError(f"the ride was not measured within {PATIENCE:g} s")
    try:
        answer = json.loads(into.read_text(encoding="utf-8"))
        into.unlink()
    except (OSError, ValueError):
        raise StoreError(f"the ride was not measured: exit code {process.exitcode}") from None
    if isinstance(answer, str):
        raise StoreError(answer)
    return {name: float(number) for name, number in answer.items()}


def salvaged(record: RideRecord, file: Path, step: float) -> RideLog:
    """A log of what is known without the navigator's process.

    Args:
        record: of the ride.
        file: its rows, as far as they came to the disk.
        step: between ticks, s.
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
    """The ride that a log's rows hold.

    Raises:
        StoreError: if the rows are not there, or none is whole.
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
        asked=own[:, 12:15],
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
    """The measures that have a meaning in this ride."""
    nowhere = _NOWHERE if np.isnan(ride.goal).any() else frozenset()
    return {
        name: float(number)
        for name, number in measure(ride).items()
        if math.isfinite(number) and name not in nowhere
    }


def _write_measures(task: Path, into: Path) -> None:
    """Of the process aside."""
    end_with_owner()
    os.nice(19)
    answer: dict[str, float] | str
    try:
        ride = ride_of(*pickle.loads(task.read_bytes()))
        answer = measures_of(ride)
        write_whole(into.with_suffix(".png"), ride_map(ride))
    except Exception as fault:  # a task of another version may fail in any way
        answer = f"the ride was not measured: {type(fault).__name__} {fault}".strip()
    try:
        write_whole(into, json.dumps(answer).encode())
    except StoreError:  # deleted meanwhile, and nobody waits for it
        sys.exit(1)


def _rows(file: Path) -> tuple[Floats, Floats]:
    """(k, OWN) about the chair and (k, n, EACH) about people; who came later is NaN before."""
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
    """Where each whole row begins, and its people; the last one may be torn."""
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
