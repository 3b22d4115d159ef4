"""All local planners across filmed crowds, which are replayed and do not react.

For each film a seed draws where and when the chair crosses its main flow, see ``crossings``; all
planners ride the same crossings on an open floor. Only the chair avoids. A person who would
enter the film within ``NEAR`` of the chair enters as soon as the chair is farther away, because a
person who appears in front of the wheels cannot be avoided.
"""

from __future__ import annotations

import math
from functools import lru_cache, partial
from pathlib import Path
from typing import Annotated

import numpy as np

from cohelm.benchmarks.bench import LOCAL_PLANNERS, chosen_names, unset
from cohelm.benchmarks.claims import Bound
from cohelm.benchmarks.options import Planners, Settings, TruePeople, names
from cohelm.benchmarks.ride_claims import Requirement
from cohelm.benchmarks.rides.cases import TRUE_PEOPLE, planners_of, rivals
from cohelm.benchmarks.rides.report import ReportSpec, ride_report
from cohelm.benchmarks.study import Grid, Study, Variant, common
from cohelm.errors import ConfigError, RecordingError
from cohelm.evaluation.external.crossings import NEAR, crossing
from cohelm.evaluation.metrics.measures import REPORTED
from cohelm.recordings import Trajectories, read_trajectories
from cohelm.recordings.outside_data import outside_data

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
    planners: Planners = None,
    films: Annotated[
        str | None,
        names("zara01, eth, or files of trajectories; default: both films."),
    ] = None,
    settings: Settings = (),
    *,
    true_people: TruePeople = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, RecordingError, ScenarioError: if a planner, a film or a setting
            does not exist.
    """
    unset(settings, LOCAL_PLANNERS)
    known = (TRUE_PEOPLE,) if true_people else ()
    names = chosen_names(films, "--films", FILMS)
    for film in names:
        _film(film)
    crossed = tuple(
        Variant(
            columns=(("scene", f"{Path(film).stem}, replayed"),),
            settings=known,
            scenario=SCENARIO,
            drawn=partial(crossing_settings, film),
        )
        for film in names
    )
    compared = planners_of(chosen_names(planners, "--planners", rivals()), tuned=True)
    plan = Grid((crossed, common(settings), compared))
    return Study(TITLE, plan, partial(ride_report, spec=SPEC)).checked()
