"""SocNavBench's episodes (Biswas et al. 2021): all local planners among recorded people.

People are replayed and do not react. The floor is open: there are no meshes of buildings.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from cohelm.benchmarks.bench import (
    LOCAL_PLANNERS,
    BenchReport,
    Result,
    chosen_names,
    missing_data,
    unset,
)  # fmt: skip
from cohelm.benchmarks.claims import NONE, Bound
from cohelm.benchmarks.options import Planners, Settings, Tuned, names
from cohelm.benchmarks.ride_claims import Requirement
from cohelm.benchmarks.rides.cases import installed, planners_of
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish, rides_by
from cohelm.benchmarks.study import Grid, Study, Variant, common
from cohelm.benchmarks.tables import figures, group_table, matrix_table
from cohelm.errors import ConfigError
from cohelm.evaluation.episode.ride import GOAL_RADIUS, Outcome, Ride
from cohelm.evaluation.metrics.motion import distance_to_goal, path_length
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.geometry import wrap_angle
from cohelm.recordings.outside_data import outside_file
from cohelm.recordings.pedestrians.socnavbench import episode_names, read_episode

TITLE = "SocNavBench's episodes on recorded people, who do not react"
RADIUS, MARGIN = 0.2, 12.0
"""Radius of a person in SocNavBench, and open floor around start and goal, m."""
MOST = 10.0
"""Cut-off of distances, m, and times to collision, s."""
MEASURES = (
    "reached", "person_collision", "standing_contact", "time", "time_ratio", "path_length_ratio",
    "path_irregularity", "goal_traversal_ratio", "motion_energy", "closest_pedestrian",
    "socnavbench_ttc",
)  # fmt: skip
SPEC = ReportSpec(
    title=TITLE,
    claims=(
        Requirement("reached", Bound(low=1.0), pooled="all episodes"),
        Requirement("person_collisions", NONE, pooled="all episodes"),
    ),
    page=MEASURES,
    limitations=(
        "The people are replayed and do not react; real people would give way. There are no meshes "
        "of buildings: where SocNavBench has walls, this floor is open.",
        "SocNavBench's robot is a disc of radius 0.24 m with at most 1.2 m/s and 1.1 rad/s; it "
        "arrives at 0.3 m and goes on after a collision. Here a chair rides and arrives at 0.2 m, "
        "and a collision in motion ends the ride.",
    ),
)


def socnavbench_columns(ride: Ride) -> Mapping[str, Any]:
    """Measures of SocNavBench (``metrics/cost_functions.py`` and ``metrics_sim_utils.py``).

    - ``path_length_ratio``: driven length over the straight line, of rides that arrived.
    - ``path_irregularity``: mean angle between heading and bearing of the goal, up to 0.2 m before
      it, rad; the program takes the vector from the origin for the heading.
    - ``goal_traversal_ratio``: distance from the goal at the end over that at the start.
    - ``motion_energy``: ∫ v² dt, m²/s; the program adds v² of each step.
    - ``closest_pedestrian``: distance of the centres, at most 10 m, mean over time, m.
    - ``socnavbench_ttc``: (distance of the centres − radius of the robot) over the closing speed
      along their line, smallest of all people, at most 10 s, mean over time, s.
    """
    to_goal = ride.goal - ride.pose[:, :2]
    straight = max(float(np.hypot(*to_goal[0])), 1e-9)
    error = wrap_angle(np.arctan2(to_goal[:, 1], to_goal[:, 0]) - ride.pose[:, 2])
    cos, sin = np.cos(ride.pose[:, 2]), np.sin(ride.pose[:, 2])
    v, w = ride.twist[:, 0], ride.twist[:, 1]
    velocity = np.column_stack([v * cos - w * sin, v * sin + w * cos])
    offset = ride.pose[:, None, :2] - ride.people[..., :2]
    away = np.hypot(offset[..., 0], offset[..., 1])
    closing = ((ride.people[..., 2:] - velocity[:, None]) * offset).sum(axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        times = (away - np.hypot(*ride.robot.outline.T).max()) * away / closing
    arrived = ride.outcome is Outcome.REACHED
    return {
        "path_length_ratio": path_length(ride) / straight if arrived else math.nan,
        "path_irregularity": float(np.abs(error[distance_to_goal(ride) > GOAL_RADIUS]).mean()),
        "goal_traversal_ratio": float(distance_to_goal(ride)[-1]) / straight,
        "motion_energy": float((velocity**2).sum() * ride.step),
        "closest_pedestrian": float(np.fmin(away, MOST).min(axis=1, initial=MOST).mean()),
        "socnavbench_ttc": float(
            np.where((times > 0.0) & (times < MOST), times, MOST).min(axis=1, initial=MOST).mean()
        ),
    }


def episode_settings(file: Path, name: str) -> tuple[str, ...]:
    """Settings of the scenario ``filmed`` for an episode, moved onto an open floor of its size.

    Raises:
        ConfigError, RecordingError: see :func:`read_episode`.
    """
    section = read_episode(file, name)[1]
    ends = np.array(section.robot_start_goal)[:, :2]
    move = np.round(MARGIN - ends.min(axis=0), 3)
    width, height = np.ceil(np.ptp(ends, axis=0) + 2.0 * MARGIN).tolist()
    start, goal = np.round(ends + move, 3).tolist()
    plaza = {"rect": [0.05, 0.05, width - 0.05, height - 0.05], "point": start}
    values = {
        "floor_plan": {"size": [width, height], "rooms": {"Plaza": plaza}},
        "people.model.file": str(file),
        "people.model.episode": name,
        "people.model.at": move.tolist(),
        "start": [*start, round(math.degrees(section.robot_start_goal[0][2]), 3)],
        "goal": goal,
        "time_limit": section.max_time,
        "standing_limit": section.max_time,
    }
    return tuple(f"{key}={json.dumps(each)}" for key, each in values.items())


def ride_episodes(task: Sequence[RideTask]) -> list[Result]:
    """Ride a task, with the measures of SocNavBench."""
    return [ride_row(each, more=socnavbench_columns) for each in task]


def episodes_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Outcomes by episode and planner, and all measures over all episodes."""
    rides = Rides([each.row for each in results], SPEC.by)
    planners, scenes = rides_by(rides, "planner"), rides_by(rides, "scene")
    matrices = (matrix_table(rides, name) for name in MEASURES[:4])
    sheets = (group_table("all episodes", planners, MEASURES), *matrices)
    found = Findings(sheets, (), {"planners": figures(planners, MEASURES)})
    groups = {name: rides_by(each, "planner") for name, each in scenes.items()}
    return finish(results, folder, SPEC, found, groups)


def create(
    planners: Planners = None,
    episodes: Annotated[str | None, names("Episodes of the file; default: all.")] = None,
    file: Annotated[
        str | None, typer.Option(metavar="INI", help="Episodes; default: those in COHELM_DATA.")
    ] = None,
    settings: Settings = (),
    *,
    tuned: Tuned = False,
) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        ConfigError, PluginError, RecordingError, ScenarioError: if a planner, an episode, a
            recording or a setting does not exist or is damaged.
    """
    unset(settings, {**LOCAL_PLANNERS, "start": "the episode", "goal": "the episode"})
    ini = Path(file).resolve() if file else outside_file("socnavbench", "episodes.ini")
    if ini is None:
        raise ConfigError(missing_data("socnavbench", "episodes.ini"), key="--file")
    known, bodies = episode_names(ini), (f"people.model.radius={RADIUS}",)
    scenes = tuple(
        Variant((("scene", name),), episode_settings(ini, name), bodies, scenario="filmed")
        for name in chosen_names(episodes, "--episodes", known, kind="episode", known=known)
    )
    compared = planners_of(chosen_names(planners, "--planners", installed()), tuned=tuned)
    plan = Grid((scenes, common(settings), compared))
    return Study(TITLE, plan, episodes_report, ride_episodes, SEEDS=1).checked()
