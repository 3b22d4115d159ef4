"""Every local planner across filmed crowds, who walk as they walked and react to nobody.

A seed draws for each film where and when the chair crosses its main flow, see ``crossings``; all
planners ride the same crossings on an open floor. All the avoiding is the chair's. Whoever would
come into the picture within ``NEAR`` of the chair comes once it is no nearer: nobody can be avoided
who comes out of nothing in front of the wheels.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from cohelm import plugins
from cohelm.errors import ConfigError, RecordingError
from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Task,
    check_free,
    parted,
)
from cohelm.evaluation.benches.crowds_report import make_report
from cohelm.evaluation.benches.rides import installed
from cohelm.evaluation.benches.rides_scenes import OWN_SETTINGS, Contender
from cohelm.evaluation.crossings import NEAR, crossing
from cohelm.evaluation.presets import tuned_settings
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.recordings import Trajectories, read_trajectories
from cohelm.recordings.outside import outside_data

TITLE = "Local planners across filmed crowds, who do not react"
SEEDS = 20
WORKERS = None
SCENARIO = "filmed"
FILMS = ("zara01", "eth")
"""UCY's and ETH's, in ``pedestrians/`` of the folder that COHELM_DATA names."""
MIDDLE = np.array([16.0, 16.0])
"""Of the scenario's floor; the middle of the crossing lies there, m."""


@dataclass(frozen=True)
class CrowdsBench:
    """The benchmark with some planners and films."""

    contenders: tuple[Contender, ...]
    films: tuple[str, ...]
    """By name, or files."""
    true_people: bool = False
    """The chair is told where people truly are, instead of its sensors' word."""
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """The same crossing by every planner, so that an interrupt leaves whole comparisons."""
        return [
            tuple(self.ride(who, film, seed) for who in self.contenders)
            for seed in seeds
            for film in self.films
        ]

    def ride(self, who: Contender, film: str, seed: int) -> RideTask:
        """One ride."""
        told = ("tracker.use=given",) if self.true_people else ()
        return RideTask(
            columns=(("scene", f"{Path(film).stem}, replayed"), ("planner", who.name)),
            scenario=SCENARIO,
            settings=(
                f"local_planner.use={who.planner}",
                *OWN_SETTINGS.get(who.planner, ()),
                *crossing_settings(film, seed),
                *told,
                *self.settings,
                *who.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """The rides of a task."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A table for each film, paired differences, and what was asked for."""
        return make_report(results, folder, TITLE)


def crossing_settings(film: str, seed: int) -> tuple[str, ...]:
    """The crossing of a film that a seed draws, as settings of the scenario.

    Raises:
        ConfigError: if there is no such film.
        RecordingError: if it is none, or cannot be crossed.
    """
    drawn = crossing(_film(film), seed)
    move = np.round(MIDDLE - 0.5 * (drawn.start[:2] + drawn.goal), 3)
    start, goal = drawn.start[:2] + move, drawn.goal + move
    heading = math.degrees(drawn.start[2])
    return (
        f"people.model.file={film_file(film)}",
        f"people.model.begin={drawn.begin:.3f}",
        f"people.model.clear={NEAR}",
        f"people.model.at=[{move[0]:.3f}, {move[1]:.3f}]",
        f"start=[{start[0]:.3f}, {start[1]:.3f}, {heading:.1f}]",
        f"goal=[{goal[0]:.3f}, {goal[1]:.3f}]",
    )


def film_file(film: str) -> str:
    """The file of a film by its name, for COHELM_DATA, or the file that is named."""
    return f"pedestrians/{film}_obsmat.txt" if film in FILMS else film


@lru_cache(maxsize=8)
def _film(film: str) -> Trajectories:
    file = Path(film_file(film))
    if film in FILMS and not file.is_file():
        folder = outside_data()
        if folder is None:
            raise ConfigError(
                f"{film} is outside data, and COHELM_DATA is not set (or name a file)",
                key="--films",
            )
        file = folder / file
    try:
        return read_trajectories(file)
    except RecordingError as cause:
        raise ConfigError(cause.problem, file=file, key="--films") from None


def on(
    planners: str | None = None,
    films: str | None = None,
    settings: Sequence[str] = (),
    *,
    true_people: bool = False,
) -> CrowdsBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ConfigError, PluginError, RecordingError, ScenarioError: if a planner, a film or a setting
            does not exist, before anything is ridden.
    """
    check_free(settings, LOCAL_PLANNERS)
    names = parted(planners, "--planners") or [n for n in installed() if n not in OWN_SETTINGS]
    bench = CrowdsBench(
        contenders=tuple(Contender(name, name, tuned_settings(name)) for name in names),
        films=parted(films, "--films") or FILMS,
        true_people=true_people,
        settings=tuple(settings),
    )
    for who in bench.contenders:
        scenario = bench.ride(who, bench.films[0], 0).load()
        plugins.build("local_planners", scenario.local_planner, key="local_planner")
    for film in bench.films:
        _film(film)
    return bench
