"""One ride of a sweep: what it is, and the row and the curves that are kept of it.

Whatever a ride bench compares (planners, riders, modes, widths) is a column that it names itself;
all else in the row is the same for every bench, so that results of different benches, planners and
days can be put side by side.
"""

from __future__ import annotations

import hashlib
import json
import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import version
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.episode import run
from cohelm.evaluation.metrics.table import MEASURES
from cohelm.evaluation.ride import Outcome, Ride
from cohelm.evaluation.scenario import PARTS, Scenario, load_scenario
from cohelm.evaluation.sweeps.tasks import Fault, Result

ERROR = "error"
"""The outcome of a ride that broke off: a fault of the program."""
SERIES = ("time", "x", "y", "heading", "v", "w", "gap", "eta")
"""Columns of the curve that is kept of a ride: s, m, m, rad, m/s, rad/s, m (+inf: nobody), 1."""
SERIES_STEP = 0.2
"""Between the rows of the curve, s."""
TIMINGS = ("solve_median_ms", "solve_p99_ms", "tick_median_ms")
"""Columns in which two runs of the same ride may differ."""

_ALONE = ("people.count=0",)


@dataclass(frozen=True)
class RideTask:
    """One ride; picklable, and the same on every machine."""

    columns: tuple[tuple[str, str], ...]
    """What the bench compares, by name: (("scene", "crossing"), ("planner", "dwa"), …)."""
    scenario: str
    """A name or a file."""
    settings: tuple[str, ...]
    """``dotted.key=value``, the later ones winning; the planner's, the rider's, the mode's too."""
    seed: int

    def load(self, more: tuple[str, ...] = ()) -> Scenario:
        """The scenario with all settings.

        Raises:
            ScenarioError, PluginError: see :func:`~cohelm.evaluation.scenario.load_scenario`.
        """
        return load_scenario(self.scenario, [*self.settings, *more])

    @property
    def replay(self) -> str:
        """The command that rides it again."""
        words = ["cohelm", "run", self.scenario, "--seed", str(self.seed)]
        for setting in self.settings:
            words += ["--set", setting]
        return shlex.join(words)


def config_hash(scenario: Scenario) -> str:
    """Of everything that makes the ride but its seed: equal hashes are the same experiment."""
    text = json.dumps(scenario.model_dump(mode="json"), sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def ride_row(task: RideTask) -> Result:
    """Ride once; the same task gives the same row and curve, ``TIMINGS`` apart.

    A ride that raises gives a row that says so, with its traceback and the command that rides it
    again: one fault is not to end a night's sweep.
    """
    row = _empty(task)
    try:
        scenario = task.load()
        row["config"] = config_hash(scenario)
        ride = run(scenario, task.seed)
        row |= ride_figures(ride)
        row["time_alone"] = time_alone(task)
    except Exception as failure:  # whatever it is, the row says it and the others go on
        return Result({**row, **_said(Fault.of(failure))})
    return Result(row, {"series": series_of(ride)})


def check_rides(tasks: Iterable[Sequence[RideTask]], key: str) -> None:
    """Try all that can be tried without riding: every scenario, and its part ``key``.

    Args:
        tasks: rides.
        key: of a scenario, as in ``scenario.PARTS``: what the bench compares.

    Raises:
        ScenarioError, PluginError, ConfigError: if something does not exist or does not fit.
    """
    for task in tasks:
        for ride in task:
            plugins.build(PARTS[key][0], getattr(ride.load(), key), key=key)


def failed_rides(task: Sequence[Any], fault: Fault) -> Sequence[Result]:
    """The rows of a task of rides of which nothing came, as where its process died; else none."""
    rides = [each for each in task if isinstance(each, RideTask)]
    return [Result({**_empty(each), **_said(fault)}) for each in rides]


def rides_in(task: Sequence[Any]) -> int:
    """How many rides a task has."""
    return sum(isinstance(each, RideTask) for each in task)


def _said(fault: Fault) -> Mapping[str, str]:
    """A fault as columns of a row."""
    return {"error": fault.error, "traceback": fault.traceback}


def _empty(task: RideTask) -> dict[str, Any]:
    """The row of a ride of which nothing is known."""
    return {
        **dict(task.columns),
        "seed": task.seed,
        "outcome": ERROR,
        "time_alone": math.nan,
        "collision_speed": math.nan,
        "collision_speed_wall": math.nan,
        "stops": math.nan,
        **dict.fromkeys(MEASURES, math.nan),
        **dict.fromkeys(TIMINGS, math.nan),
        "people_from": "",
        "people_react": math.nan,
        "replan_count": math.nan,
        "config": "",
        "version": version("cohelm"),
        "error": "",
        "traceback": "",
        "replay": task.replay,
    }


def ride_figures(ride: Ride) -> Mapping[str, Any]:
    """What a row says of a ride; ``time`` is that of a ride that reached its goal, else NaN."""
    measures: dict[str, Any] = {name: float(each(ride)) for name, each in MEASURES.items()}
    if ride.outcome is not Outcome.REACHED:
        measures["time"] = math.nan
    solve, tick = 1e3 * solve_times(ride), 1e3 * ride.durations["tick"][1:]
    return {
        "outcome": ride.outcome.value,
        "collision_speed": speed_at_touch(ride),
        "collision_speed_wall": speed_where(ride, ride.hit_wall),
        "stops": len(ride.stops),
        **measures,
        "solve_median_ms": float(np.median(solve)),
        "solve_p99_ms": float(np.percentile(solve, 99.0)),
        "tick_median_ms": float(np.median(tick)) if len(tick) else math.nan,
        "people_from": ride.ticks[-1].people.source if ride.ticks else "",
        "people_react": react_share(ride),
        "replan_count": len(ride.replans),
    }


def react_share(ride: Ride) -> float:
    """Share of the people who may react to the chair; 0: replayed or blind ones, NaN: nobody."""
    see = ride.people_see
    return float(see.mean()) if see is not None and len(see) else math.nan


def series_of(ride: Ride) -> Floats:
    """The ride as a curve, (k, 8), a row each 0.2 s; columns as ``SERIES``."""
    every = max(1, round(SERIES_STEP / ride.step))
    gap = ride.gap_people.min(axis=1, initial=math.inf)
    columns = [ride.time, *ride.pose.T, ride.twist[:, 0], ride.twist[:, 2], gap, ride.eta]
    return np.column_stack(columns)[::every]


def speed_at_touch(ride: Ride) -> float:
    """How fast the chair moved when it touched a person, the worst, m/s; NaN: it never did."""
    return speed_where(ride, np.asarray(ride.hit_moving.any(axis=1)))


def speed_where(ride: Ride, touched: Booleans) -> float:
    """How fast the chair moved at some ticks (k,), the worst, m/s; NaN of none.

    A touch lies between two ticks: the greater speed of both.
    """
    at = np.flatnonzero(touched)
    if not len(at):
        return math.nan
    speed = np.hypot(ride.twist[:, 0], ride.twist[:, 1])
    return float(np.maximum(speed[at], speed[np.maximum(at - 1, 0)]).max())


def solve_times(ride: Ride) -> Floats:
    """Thread CPU time of the local planner, tick by tick where it ran, s; the first left out."""
    times = ride.durations.get("control", np.zeros(1))
    ran = times[1:][times[1:] > 0.0]
    return ran if len(ran) else times[:1]


def time_alone(task: RideTask) -> float:
    """The same ride with nobody there, once for each process, s; NaN where it is not reached.

    Rides that differ in their people alone, as in when somebody turns, have it in common.
    """
    mine = tuple(each for each in task.settings if not each.startswith("people."))
    return _time_alone(task.scenario, mine)


@lru_cache(maxsize=512)
def _time_alone(scenario: str, settings: tuple[str, ...]) -> float:
    ride = run(load_scenario(scenario, [*settings, *_ALONE]), 0)
    return MEASURES["time"](ride) if ride.outcome is Outcome.REACHED else math.nan
