"""One ride as a row: how it ended, how long it took beside the ride alone, how near it came."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.rides_scenes import Contender, Scene, replay_of, scenario_of
from cohelm.evaluation.episode import run
from cohelm.evaluation.metrics.table import MEASURES
from cohelm.evaluation.ride import Outcome, Ride

ERROR = "error"
"""The outcome of a ride that broke off: a fault of the program."""
TAKEN = (
    "path_length",
    "min_distance",
    "collisions_person",
    "collisions_wall",
    "standing_contacts",
    "proxemics_intimate",
    "social_space_intrusion",
    "stalled_time",
    "heading_change",
    "linear_velocity_variance",
    "angular_velocity_variance",
    "jerk_rms",
)
"""Of the measures of a ride, those in its row; see ``docs/measures.md``."""
_ALONE = ("people.count=0",)


def row_of(scene: Scene, contender: Contender, seed: int) -> dict[str, Any]:
    """Ride once; the same arguments give the same row, solve times apart.

    A ride that raises gives a row that says so: one fault is not to end a night's sweep.
    """
    row: dict[str, Any] = {
        "scene": scene.label,
        "planner": contender.name,
        "seed": seed,
        "turn": scene.turn(seed),
        "outcome": ERROR,
        "time": math.nan,
        "time_alone": math.nan,
        "collision_speed": math.nan,
        "stops": math.nan,
        **dict.fromkeys(TAKEN, math.nan),
        "solve_median_ms": math.nan,
        "solve_p99_ms": math.nan,
        "people_from": "",
        "error": "",
        "replay": replay_of(scene, contender, seed),
    }
    try:
        ride = run(scenario_of(scene, contender, seed), seed)
        return {**row, **measured(ride), "time_alone": time_alone(scene, contender)}
    except Exception as failure:  # whatever it is, the row says it and the others go on
        return {**row, "error": f"{type(failure).__name__}: {failure}".splitlines()[0][:200]}


def measured(ride: Ride) -> Mapping[str, Any]:
    """What a row says of a ride; time is that of a ride that reached its goal, else NaN."""
    reached = ride.outcome is Outcome.REACHED
    solve = 1e3 * solve_times(ride)
    return {
        "outcome": ride.outcome.value,
        "time": MEASURES["time"](ride) if reached else math.nan,
        "collision_speed": speed_at_touch(ride),
        "stops": len(ride.stops),
        **{name: MEASURES[name](ride) for name in TAKEN},
        "solve_median_ms": float(np.median(solve)),
        "solve_p99_ms": float(np.percentile(solve, 99.0)),
        "people_from": ride.ticks[-1].people.source if ride.ticks else "",
    }


def speed_at_touch(ride: Ride) -> float:
    """How fast the chair moved when it touched a person, the worst, m/s; NaN: it never did.

    The touch lies between two ticks: the greater speed of both.
    """
    touched = np.flatnonzero(ride.hit_moving.any(axis=1))
    if not len(touched):
        return math.nan
    speed = np.hypot(ride.twist[:, 0], ride.twist[:, 1])
    return float(np.maximum(speed[touched], speed[np.maximum(touched - 1, 0)]).max())


def solve_times(ride: Ride) -> Floats:
    """Thread CPU time of the local planner, tick by tick where it ran, s; the first left out."""
    times = ride.durations.get("control", np.zeros(1))
    ran = times[1:][times[1:] > 0.0]
    return ran if len(ran) else times[:1]


@lru_cache(maxsize=256)
def time_alone(scene: Scene, contender: Contender) -> float:
    """The same ride with nobody there, once for each process, s; NaN where it is not reached."""
    ride = run(scenario_of(scene, contender, 0, _ALONE), 0)
    return MEASURES["time"](ride) if ride.outcome is Outcome.REACHED else math.nan
