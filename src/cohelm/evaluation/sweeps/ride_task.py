"""One ride of a sweep: its task, its row of results, and its curve.

A benchmark names the columns that it compares (planners, riders, modes, widths). All other columns
are the same in every benchmark, so that results can be compared across benchmarks.
"""

from __future__ import annotations

import hashlib
import json
import math
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.episode.episode import run
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.metrics.measures import RIDE_MEASURES, measure
from cohelm.evaluation.metrics.motion import time as time_to_goal
from cohelm.evaluation.sweeps.tasks import Result, TaskError
from cohelm.scenarios.scenario import PARTS, Scenario, load_scenario

ERROR = "error"
"""Outcome of a ride that a program error ended."""
SERIES = ("time", "x", "y", "heading", "v", "w", "gap", "eta")
"""Columns of the curve of a ride: s, m, m, rad, m/s, rad/s, m (+inf: without people), 1."""
SERIES_STEP = 0.2
"""Time between the rows of the curve, s."""
TIMINGS = ("solve_median_ms", "solve_p99_ms", "tick_median_ms")
"""Columns that differ between two runs of the same ride."""

_EMPTY_FLOOR = ("people.count=0",)


@dataclass(frozen=True)
class RideTask:
    """One ride; picklable, and equal on every machine."""

    columns: tuple[tuple[str, str], ...]
    """Compared columns: (("scene", "crossing"), ("planner", "dwa"), …)."""
    scenario: str
    """A name or a file."""
    settings: tuple[str, ...]
    """``dotted.key=value``, later ones win; also those of planner, rider and mode."""
    seed: int

    def load(self, more: tuple[str, ...] = ()) -> Scenario:
        """Load the scenario with all settings.

        Raises:
            ScenarioError, PluginError: see :func:`~cohelm.scenarios.scenario.load_scenario`.
        """
        return load_scenario(self.scenario, [*self.settings, *more])

    @property
    def replay(self) -> str:
        """Command that repeats the ride."""
        words = ["cohelm", "run", self.scenario, "--seed", str(self.seed)]
        for setting in self.settings:
            words += ["--set", setting]
        return shlex.join(words)

    def as_json(self) -> str:
        """Text of scenario, settings and seed for a row; see :meth:`from_row`."""
        return json.dumps([self.scenario, self.settings, self.seed])

    @classmethod
    def from_row(cls, row: Mapping[str, Any]) -> RideTask | None:
        """Task that is stored in a row of results; None where it has none."""
        try:
            scenario, settings, seed = json.loads(str(row.get("task") or ""))
        except ValueError:
            return None
        return cls(columns=(), scenario=scenario, settings=tuple(settings), seed=seed)


def config_hash(scenario: Scenario) -> str:
    """Hash of everything that defines the ride except its seed."""
    text = json.dumps(scenario.model_dump(mode="json"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def ride_row(
    task: RideTask,
    *,
    empty_floor: bool = True,
    more: Callable[[Ride], Mapping[str, Any]] | None = None,
    drive: Callable[[Scenario, int], Ride] | None = None,
) -> Result:
    """Ride once; equal tasks give equal rows and curves, except for ``TIMINGS``.

    An exception gives a row with its traceback and the command that repeats the ride. With
    ``empty_floor`` the ride is repeated without people, for the column ``time_empty_floor``.
    ``more`` gives columns of one benchmark; ``drive`` rides in its own way.
    """
    row = _empty(task)
    try:
        scenario = task.load()
        row["config"] = config_hash(scenario)
        ride = (drive or run)(scenario, task.seed)
        row |= ride_figures(ride)
        row |= more(ride) if more is not None else {}
        if empty_floor:
            row["time_empty_floor"] = time_empty_floor(task)
    except Exception as failure:  # the other rides go on
        return Result({**row, **_columns(TaskError.of(failure))})
    return Result(row, {"series": series_of(ride)})


def check_rides(tasks: Iterable[Sequence[RideTask]], key: str) -> None:
    """Check without riding that every scenario loads and its part ``key`` can be built.

    Args:
        tasks: rides.
        key: compared key of ``scenario.PARTS``.

    Raises:
        ScenarioError, PluginError, ConfigError: if one does not exist or does not fit.
    """
    for task in tasks:
        for ride in task:
            plugins.build(PARTS[key][0], getattr(ride.load(), key), key=key)


def failed_rides(task: Sequence[Any], error: TaskError) -> Sequence[Result]:
    """Rows of a failed task of rides, as where its process died; empty for other tasks."""
    rides = [each for each in task if isinstance(each, RideTask)]
    return [Result({**_empty(each), **_columns(error)}) for each in rides]


def rides_in(task: Sequence[Any]) -> int:
    """Number of rides of a task."""
    return sum(isinstance(each, RideTask) for each in task)


def _columns(error: TaskError) -> Mapping[str, str]:
    return {"error": error.error, "traceback": error.traceback}


def _empty(task: RideTask) -> dict[str, Any]:
    """Row of a ride without results."""
    return {
        **dict(task.columns),
        "seed": task.seed,
        "outcome": ERROR,
        "time_empty_floor": math.nan,
        "collision_speed": math.nan,
        "collision_speed_wall": math.nan,
        **dict.fromkeys(RIDE_MEASURES, math.nan),
        **dict.fromkeys(TIMINGS, math.nan),
        "people_source": "",
        "reacting_share": math.nan,
        "replan_count": math.nan,
        "config": "",
        "version": version("cohelm"),
        "error": "",
        "traceback": "",
        "replay": task.replay,
        "task": task.as_json(),
    }


def ride_figures(ride: Ride) -> Mapping[str, Any]:
    """Columns of a ride; ``time`` is NaN unless the goal was reached."""
    measures: dict[str, Any] = {name: float(each) for name, each in measure(ride).items()}
    if ride.outcome is not Outcome.REACHED:
        measures["time"] = math.nan
    solve, tick = 1e3 * solve_times(ride), 1e3 * ride.durations["tick"][1:]
    return {
        "outcome": ride.outcome.value,
        "collision_speed": collision_speed(ride),
        "collision_speed_wall": speed_where(ride, ride.hit_wall),
        **measures,
        "solve_median_ms": float(np.median(solve)),
        "solve_p99_ms": float(np.percentile(solve, 99.0)),
        "tick_median_ms": float(np.median(tick)) if len(tick) else math.nan,
        "people_source": ride.ticks[-1].people.source if ride.ticks else "",
        "reacting_share": reacting_share(ride),
        "replan_count": len(ride.replans),
    }


def reacting_share(ride: Ride) -> float:
    """Share of the people who may react to the chair; NaN without people."""
    see = ride.people_see
    return float(see.mean()) if see is not None and len(see) else math.nan


def series_of(ride: Ride) -> Floats:
    """Curve of a ride, (k, 8), a row every 0.2 s; columns as ``SERIES``."""
    every = max(1, round(SERIES_STEP / ride.step))
    gap = ride.gap_people.min(axis=1, initial=math.inf)
    columns = [ride.time, *ride.pose.T, ride.twist[:, 0], ride.twist[:, 2], gap, ride.eta]
    return np.column_stack(columns)[::every]


def collision_speed(ride: Ride) -> float:
    """Largest speed of the chair at a collision with a person, m/s; NaN without one."""
    return speed_where(ride, np.asarray(ride.hit_moving.any(axis=1)))


def speed_where(ride: Ride, touched: Booleans) -> float:
    """Largest speed of the chair at some ticks (k,), m/s; NaN of none.

    A contact lies between two ticks: the larger speed of both counts.
    """
    at = np.flatnonzero(touched)
    if not len(at):
        return math.nan
    speed = np.hypot(ride.twist[:, 0], ride.twist[:, 1])
    return float(np.maximum(speed[at], speed[np.maximum(at - 1, 0)]).max())


def solve_times(ride: Ride) -> Floats:
    """Thread CPU time of the local planner at ticks where it ran, s, without the first tick."""
    times = ride.durations.get("control", np.zeros(1))
    ran = times[1:][times[1:] > 0.0]
    return ran if len(ran) else times[:1]


def time_empty_floor(task: RideTask) -> float:
    """Time to goal of the ride without people, s; NaN if it is not reached.

    Rides that differ only in their people share it; it is computed once in each process.
    """
    settings = tuple(each for each in task.settings if not each.startswith("people."))
    return _time_empty_floor(task.scenario, settings)


@lru_cache(maxsize=512)
def _time_empty_floor(scenario: str, settings: tuple[str, ...]) -> float:
    ride = run(load_scenario(scenario, [*settings, *_EMPTY_FLOOR]), 0)
    return time_to_goal(ride) if ride.outcome is Outcome.REACHED else math.nan
