"""Circuits of the SWADAPT trials with simulated riders: collisions and time with and without help.

The trials: Leblong et al. 2021 (SWADAPT1) and Fraudet et al. 2024 (SWADAPT2). A ride goes from stop
to stop, each within 0.2 m. After a collision it goes on from the track before it; a chair that does
not get to a stop is set there.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet, chosen_names, unset
from cohelm.benchmarks.claims import MET, MISSED, Verdict
from cohelm.benchmarks.options import Modes, Riders, Scenes, Settings
from cohelm.benchmarks.rides.modes import BY, known_riders, modes_of, riders_of
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish, rides_by
from cohelm.benchmarks.rides.sharing_families import beside_start
from cohelm.benchmarks.study import Grid, Study, Variant, common
from cohelm.benchmarks.tables import difference_table
from cohelm.evaluation.episode.episode import Episode
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.geometry import arc_length, wrap_angle
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import Scenario
from cohelm.simulation import Rider, RiderAct, RiderView
from cohelm.simulation.riders.rider_input import deflected

TITLE = "Circuits of the SWADAPT trials, with simulated riders"
CIRCUITS = ("swadapt-1", "swadapt-2", "swadapt-3")
MANUAL, HELP = "manual", ("assisted", "shared")
IN_REVERSE = {("swadapt-3", 2)}
"""Circuits and legs, from 0, that are driven in reverse: out of the lift."""
JUDGED, AIM = "swadapt-3", (-0.82, 0.05)
"""Circuit, and the aim there: change of collisions, and of the time."""
LEG_TIME, MOST_COLLISIONS = 90.0, 5
"""Longest time of a leg, s, and most collisions before the chair is set to the next stop."""
BACK, CLEAR_WALL, CLEAR_PEOPLE = 1.0, 0.1, 0.3
"""Way back along the track after a collision, and gaps there at least, m (assumed)."""
FIXED = ("goal", "prefer", "people_radius", "people_see")
"""Arrays of a ride without a row per tick."""
PAGE = ("reached", "collisions", "any_collision", "time")
TRIALS = (
    "trial, 18 drivers in difficulty (SWADAPT2): collisions 2.16 without and 0.36 with help on "
    "circuit 2 (-83 %), 7.3 and 1.33 on circuit 3 (-82 %)",
    "trial, 23 regular drivers (SWADAPT1): on circuit 3 61 % collided without and 39 % with help",
)
LIMITATIONS = (
    "A simulation: riders, chair and sensors are models; the trials were of people.",
    "Left out: slopes, an obstacle to drive over, the second task for the mind.",
    "A collision costs the way back only. Time is that of circuits without a chair set to a stop.",
)


class Backwards:
    """Rider in reverse, as if the rear were the front; straight behind nothing is in sight."""

    def __init__(self, rider: Rider) -> None:
        self.rider = rider

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        bearings = np.asarray(wrap_angle(view.bearings + math.pi))
        order = np.argsort(bearings)
        view = dataclasses.replace(
            view,
            pose=view.pose + np.array([0.0, 0.0, math.pi]),
            twist=view.twist * np.array([-1.0, -1.0, 1.0]),
            people=view.people * np.array([-1.0, -1.0, -1.0, -1.0, 1.0]),
            bearings=bearings[order],
            free=view.free[order],
            outline=-view.outline,
        )
        act = self.rider.act(view, memory, rng)
        stick = np.zeros(2) if act.command is None else act.command.deflection
        return deflected(view, stick * np.array([-1.0, 1.0]), act.memory)


def ride_circuit(scenario: Scenario, seed: int) -> Ride:
    """Ride a circuit from stop to stop; its outcome is ``reached`` if the chair got to all."""
    parts, outcome = [], Outcome.REACHED
    at = np.array(scenario.start, dtype=float) * [1.0, 1.0, math.pi / 180.0]
    past = scenario.rider_plan.past if scenario.rider_plan else ()
    for leg, stop in enumerate((*past, scenario.goal)):
        reverse = (scenario.name, leg) in IN_REVERSE
        for attempt in range(MOST_COLLISIONS):
            start = (*at[:2].tolist(), math.degrees(at[2]))
            leg_of = {"start": start, "goal": stop, "rider_plan": None, "time_limit": LEG_TIME}
            setup = build_scenario(scenario.model_copy(update=leg_of), seed + 1000 * attempt)
            if reverse:
                world = dataclasses.replace(setup.world, rider=Backwards(setup.world.rider))
                setup = dataclasses.replace(setup, world=world)
            parts.append(Episode(setup).run())
            if parts[-1].outcome is not Outcome.COLLISION:
                break
            at = before_collision(parts[-1])
        if parts[-1].outcome is Outcome.REACHED:
            at = parts[-1].pose[-1]
        else:
            outcome = Outcome.STOPPED
            along = setup.route.points[-1] - setup.route.points[-2]
            at = np.array([*stop, math.atan2(along[1], along[0]) + math.pi * reverse])
    return joined(parts, outcome)


def before_collision(ride: Ride) -> Floats:
    """Pose (3,) on the track at which a ride goes on after its collision."""
    driven = arc_length(ride.pose[:, :2])
    near = ride.gap_people.min(axis=1, initial=math.inf)
    free = (driven[-1] - driven >= BACK) & (ride.gap_wall >= CLEAR_WALL) & (near >= CLEAR_PEOPLE)
    return np.asarray(ride.pose[np.flatnonzero(free)[-1] if free.any() else 0])


def joined(parts: Sequence[Ride], outcome: Outcome) -> Ride:
    """One ride of several, one after the other."""
    last = parts[-1]
    changes: dict[str, Any] = {
        each.name: np.concatenate([getattr(part, each.name) for part in parts])
        for each in dataclasses.fields(Ride)
        if each.name not in FIXED and isinstance(getattr(last, each.name), np.ndarray)
    }
    changes["time"] = last.step * np.arange(len(changes["time"]))
    ticks = {"tick": np.concatenate([part.durations["tick"] for part in parts])}
    return dataclasses.replace(last, **changes, durations=ticks, outcome=outcome)


def circuit_columns(ride: Ride) -> Mapping[str, Any]:
    """Collisions with walls and people in motion, and time to the last stop, s; NaN if helped."""
    hit = (ride.hit_wall | ride.hit_moving.any(axis=1)).astype(int)
    time = float(ride.time[-1]) if ride.outcome is Outcome.REACHED else math.nan
    return {"collisions": int((np.diff(hit, prepend=0) == 1).sum()), "time": time}


def ride_circuits(task: Sequence[RideTask]) -> list[Result]:
    """Ride the circuits of a task."""
    ride = partial(ride_row, empty_floor=False, more=circuit_columns, drive=ride_circuit)
    return [ride(each) for each in task]


def circuits_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Collisions and time by circuit, hand and mode, beside the trials' figures."""
    rides = Rides([each.row for each in results], BY)
    circuits = {name: rides_by(each, "mode") for name, each in rides_by(rides, "scene").items()}
    rows, verdicts = [], []
    for circuit, each in rides_by(rides, "scene").items():
        for hand, ridden in {"all hands": each, **rides_by(each, "rider")}.items():
            by = rides_by(ridden, "mode")
            for mode, here in by.items():
                cells, fewer, longer = _compared(here, by.get(MANUAL, here))
                rows.append((circuit, hand, mode, *cells))
                if (circuit, hand) == (JUDGED, "all hands") and mode in HELP:
                    verdicts.append(_verdict(mode, fewer, longer))
    counts = ("completed", "collisions", "change, %", "with any, %", "time, s", "change, %")
    sheet = Sheet("means of the rides", ("circuit", "hand", "mode", *counts), tuple(rows))
    spec = ReportSpec(TITLE, page=PAGE, by=BY, base=MANUAL, limitations=LIMITATIONS)
    differences = (difference_table(n, by, MANUAL, PAGE, "mode") for n, by in circuits.items())
    found = Findings((sheet, *differences), TRIALS, verdicts=tuple(verdicts))
    return finish(results, folder, spec, found, circuits)


def _verdict(mode: str, *changes: float) -> Verdict:
    met = [change <= aim for change, aim in zip(changes, AIM, strict=True)]
    found, aim = (f"{100.0 * x:+.0f} %, {100.0 * y:+.0f} %" for x, y in (changes, AIM))
    claim = "change of collisions and of time against manual, at most"
    return Verdict(f"{JUDGED}, {mode}", claim, found, aim, MET if all(met) else MISSED)


def _compared(rides: Rides, manual: Rides) -> tuple[tuple[str, ...], float, float]:
    """Cells of a line, and the changes of collisions and of time against equal rides by hand."""
    hits, time = rides.column("collisions"), rides.column("time")
    i, j = rides.pairs(manual)
    before, earlier = manual.column("collisions")[j], manual.column("time")[j]
    both = np.isfinite(time[i] - earlier)
    with np.errstate(divide="ignore", invalid="ignore"):
        fewer = float(np.nansum(hits[i]) / np.nansum(before) - 1.0)
        longer = float(time[i][both].sum() / earlier[both].sum() - 1.0)
        mean = float(np.nansum(time) / np.isfinite(time).sum())
    numbers = (np.nanmean(hits), 100 * fewer, 100 * (hits > 0).mean(), mean, 100 * longer)
    texts = (f"{x:.2f}" if math.isfinite(x) else "–" for x in numbers)
    return (f"{int(rides.reached.sum())} of {len(rides)}", *texts), fewer, longer


def create(
    riders: Riders = None, modes: Modes = None, scenes: Scenes = None, settings: Settings = ()
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, ScenarioError: if a name or a setting does not exist.
    """
    unset(settings, {"rider": "--riders", "mode": "--modes", "start": "the seed"})
    circuits = tuple(
        Variant((("scene", name),), scenario=name, drawn=partial(beside_start, name))
        for name in chosen_names(scenes, "--scenes", CIRCUITS)
    )
    hands = riders_of(chosen_names(riders, "--riders", known_riders()))
    driven = modes_of(modes or ",".join((MANUAL, "stop_only", *HELP)))
    plan = Grid((circuits, common(settings), hands, driven))
    return Study(TITLE, plan, circuits_report, ride_circuits).checked("rider")
