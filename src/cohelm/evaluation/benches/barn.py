"""The BARN worlds in this simulator: success, collisions and score of local planners.

A two-dimensional port: the worlds, the start, the goal, the limits and the score are those of the
benchmark, the robot is this simulator's. Nothing of it is to be laid beside figures from Gazebo.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.evaluation.barn import BarnOutcome, barn_stage, read_barn, ride_barn, score
from cohelm.evaluation.benches.barn_report import make_report
from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Task,
    check_free,
    parted,
)
from cohelm.recordings.outside import outside_data

TITLE = "BARN worlds, a 2-D port (not to be compared with the original in Gazebo)"
SEEDS = 1
WORKERS = None

PLANNERS = ("ss_mpc_dcbf", "dwa")
WORLDS = 300


@dataclass(frozen=True)
class BarnBench:
    """The benchmark with some planners in some worlds."""

    planners: tuple[str, ...] = PLANNERS
    worlds: tuple[int, ...] = tuple(range(WORLDS))
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each world, planner and seed of the sensors' noise."""
        worlds = read_barn(outside_data())  # says at once where the worlds are not there
        with tempfile.TemporaryDirectory() as folder:  # and what of the settings is wrong
            for planner in self.planners if self.settings else ():
                barn_stage(worlds, self.worlds[0], planner, Path(folder), self.settings)
        return [
            (world, planner, seed, self.settings)
            for world in self.worlds
            for planner in self.planners
            for seed in seeds
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """One ride."""
        return [_ride(*task)]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A row for each planner, success by difficulty, a gallery."""
        return make_report(results, read_barn(outside_data()), folder)


def on(
    planners: str | None = None, worlds: str | None = None, settings: Sequence[str] = ()
) -> BarnBench:
    """The benchmark with other planners, in some worlds only, or with other settings.

    Args:
        planners: names of local planners, with commas; None: ``PLANNERS``.
        worlds: how many, spread evenly, or numbers 0…299 with commas; None: all.
        settings: ``dotted.key=value`` of the scenario that each ride is made from.

    Raises:
        ConfigError: if a planner or a world does not exist.
    """
    check_free(settings, LOCAL_PLANNERS)
    chosen = parted(planners, "--planners") or PLANNERS
    known = plugins.names("local_planners")
    for name in chosen:
        if name not in known:
            raise ConfigError(
                f"no local planner is called {name!r}{nearest(name, known)}", key="--planners"
            )
    return BarnBench(planners=chosen, worlds=_numbers(worlds), settings=tuple(settings))


def _numbers(text: str | None) -> tuple[int, ...]:
    """What ``--worlds`` asks for."""
    if text is None:
        return tuple(range(WORLDS))
    wrong = ConfigError(
        f"write a number of worlds or worlds with commas, each 0 to {WORLDS - 1}; not {text!r}",
        key="--worlds",
    )
    try:
        numbers = [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        raise wrong from None
    if not numbers:
        raise wrong
    if "," not in text:
        if not 1 <= numbers[0] <= WORLDS:
            raise wrong
        return tuple(range(0, WORLDS, WORLDS // numbers[0]))[: numbers[0]]
    if not all(0 <= number < WORLDS for number in numbers):
        raise wrong
    return tuple(dict.fromkeys(numbers))


def _ride(world: int, planner: str, seed: int, settings: tuple[str, ...]) -> Result:
    worlds = read_barn(outside_data())
    with tempfile.TemporaryDirectory() as folder:
        stage = barn_stage(worlds, world, planner, Path(folder), settings, seed=seed)
        ride = ride_barn(worlds, world, stage)
    optimal, took = worlds.optimal_time(world), float(ride.time[-1])
    success = ride.outcome is BarnOutcome.SUCCESS
    way = float(np.hypot(*np.diff(ride.pose[:, :2], axis=0).T).sum())
    row = {
        "world": world,
        "planner": planner,
        "seed": seed,
        "outcome": ride.outcome.value,
        "time": took,
        "optimal_time": optimal,
        "score": score(took, optimal) if success else 0.0,
        "score_until_2026": score(took, optimal, least=4.0) if success else 0.0,
        "length": way,
        "mean_speed": way / took if took > 0.0 else 0.0,
        "least_gap": max(ride.least_gap, 0.0),
        "held_time": ride.held_time,
        "replans": ride.replans,
        "tick_ms": 1e3 * float(np.median(ride.tick_time)),
        "control_ms": 1e3 * float(np.median(ride.control_time)),
        "control_p99_ms": 1e3 * float(np.percentile(ride.control_time[1:], 99)),
    }
    return Result(row=row, arrays={"track": ride.pose[:, :2]})
