"""All local planners across filmed crowds, which are replayed and do not react.

For each film a seed draws where and when the chair crosses its main flow, see ``crossings``; all
planners ride the same crossings on an open floor. Only the chair avoids. A person who would
enter the film within ``NEAR`` of the chair enters as soon as the chair is farther away, because a
person who appears in front of the wheels cannot be avoided.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

import numpy as np

from cohelm.benchmarks.bench import LOCAL_PLANNERS, BenchReport, Result, Task, split_names, unset
from cohelm.benchmarks.claims import Bound
from cohelm.benchmarks.ride_claims import (
    Requirement,
)
from cohelm.benchmarks.rides.cases import OWN_SETTINGS, Contender, rivals
from cohelm.benchmarks.rides.report import ReportSpec, ride_report
from cohelm.errors import ConfigError, RecordingError
from cohelm.evaluation.external.crossings import NEAR, crossing
from cohelm.evaluation.metrics.measures import REPORTED
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.recordings import Trajectories, read_trajectories
from cohelm.recordings.outside_data import outside_data
from cohelm.scenarios.presets import tuned_settings

TITLE = "Local planners across filmed crowds, which do not react"
SCENARIO = "filmed"
FILMS = ("zara01", "eth")
"""Films of UCY and ETH, in ``pedestrians/`` of the folder that COHELM_DATA names."""
MIDDLE = np.array([16.0, 16.0])
"""Point of the scenario's floor on which the middle of the crossing lies, m."""
SPEC = ReportSpec(
    title=TITLE,
    claims=(
        Requirement("reached", Bound(low=0.95)),
        Requirement("person_collisions", Bound(high=0.01)),
    ),
    measures=(
        "reached", "person_collision", "collision_speed", "standing_contact", "time", "delay",
        "social_space_intrusion", "social_space_intrusion_share", "group_space_intrusion",
        "min_distance", "stalled_time",
    ),
    page=(*REPORTED, "social_space_intrusion", "group_space_intrusion", "stalled_time"),
    limitations=(
        "The people are replayed: they walk as filmed and do not react to the chair. Only the "
        "chair avoids, so no person is delayed; real people would give way.",
        "People who walk into the standing chair are counted separately: it can do no more.",
        "Positions are known every 0.4 s; in between people follow a smooth curve.",
        f"A person who would enter the film within {NEAR:g} m of the chair enters once it is no "
        "nearer.",
    ),
)  # fmt: skip


@dataclass(frozen=True)
class CrowdsBench:
    """The benchmark with some planners and films."""

    contenders: tuple[Contender, ...]
    films: tuple[str, ...]
    """Names or files."""
    true_people: bool = False
    """The chair receives the true positions of people instead of detecting them."""
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = 20
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed and film, with the rides of all planners."""
        return [
            tuple(self.ride(contender, film, seed) for contender in self.contenders)
            for seed in seeds
            for film in self.films
        ]

    def ride(self, contender: Contender, film: str, seed: int) -> RideTask:
        """One ride."""
        given = ("tracker.use=given",) if self.true_people else ()
        return RideTask(
            columns=(("scene", f"{Path(film).stem}, replayed"), ("planner", contender.name)),
            scenario=SCENARIO,
            settings=(
                f"local_planner.use={contender.planner}",
                *OWN_SETTINGS.get(contender.planner, ()),
                *crossing_settings(film, seed),
                *given,
                *self.settings,
                *contender.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride with every planner."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per film, paired differences, verdicts."""
        return ride_report(results, folder, SPEC)


def crossing_settings(film: str, seed: int) -> tuple[str, ...]:
    """Settings of the scenario for the crossing that a seed draws.

    Raises:
        ConfigError: if there is no such film.
        RecordingError: if the file is no film or cannot be crossed.
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
    """File of a film below COHELM_DATA, or the file that is named."""
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


def create(
    planners: str | None = None,
    films: str | None = None,
    settings: Sequence[str] = (),
    *,
    true_people: bool = False,
) -> CrowdsBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, RecordingError, ScenarioError: if a planner, a film or a setting
            does not exist.
    """
    unset(settings, LOCAL_PLANNERS)
    names = split_names(planners, "--planners") or rivals()
    bench = CrowdsBench(
        contenders=tuple(Contender(name, name, tuned_settings(name)) for name in names),
        films=split_names(films, "--films") or FILMS,
        true_people=true_people,
        settings=tuple(settings),
    )
    for film in bench.films:
        _film(film)
    check_rides(bench.tasks(range(1))[:1], "local_planner")
    return bench
