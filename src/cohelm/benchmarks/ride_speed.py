"""Real-time factor of rides: simulation, perception and planning on one core.

The time covers everything in a ride of a sweep: building the scenario, people, drive, sensors, the
navigator with all its stages, contact checks. It is the thread CPU time of a process that has
ridden the same before, so that no compilation is included. Three cases: a planar scanner of 360
beams, a LiDAR of 16 × 360 rays instead of it, both at 10 Hz, and true positions of people.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cohelm.benchmarks.bench import (
    LOCAL_PLANNERS,
    BenchReport,
    Result,
    Sheet,
    Task,
    split_names,
    unset,
)
from cohelm.benchmarks.claims import (
    OURS,
    Bound,
    bounded,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.options import Planners, Scenes, Settings
from cohelm.benchmarks.rides.cases import installed
from cohelm.evaluation.episode.episode import Episode
from cohelm.robots import load_robot
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import Scenario, load_scenario
from cohelm.stopwatch import Stopwatch

TITLE = "Real-time factor of simulation, perception and planning, one core"

SCENES = ("crossing",)
"""Five people and the chair meet in a hall."""
STAGES = (
    *("health", "perception", "social", "ground", "walls"),
    *("sharing", "planning", "control", "safety"),
)
ROBOT, RINGS, AZIMUTHS = "quantum_q6_edge_lidar", 16, 360


@dataclass(frozen=True)
class SensingCase:
    """Source of the chair's knowledge of people."""

    name: str
    required: Bound
    """Real-time factor."""
    settings: tuple[str, ...] = ()
    lidar: bool = False
    """A LiDAR of 16 × 360 rays instead of the scanner."""


CASES = (
    SensingCase("2-D scanner, 360 beams", Bound(low=10.0)),
    SensingCase("LiDAR, 16 × 360 rays", Bound(low=2.0), lidar=True),
    SensingCase("true people", Bound(low=20.0), settings=("tracker.use=given",)),
)


@dataclass(frozen=True)
class SpeedBench:
    """The benchmark with some planners in some scenes."""

    planners: tuple[str, ...]
    scenes: tuple[str, ...]
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = 2
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per scene, case and planner, with all seeds: the first ride is not counted."""
        return [
            (tuple(seeds), scene, case, planner)
            for scene in self.scenes
            for case in range(len(CASES))
            for planner in self.planners
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """One row per seed."""
        seeds, scene, case, planner = task
        scenario = self._scenario(scene, CASES[case], planner, folder)
        _timed_ride(scenario, seeds[0])
        columns = {"scene": scene, "case": CASES[case].name, "planner": planner}
        return [Result({**columns, "seed": seed, **_timed_ride(scenario, seed)}) for seed in seeds]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Real-time factors, time by stage, verdicts."""
        return _report([result.row for result in results])

    def _scenario(self, scene: str, case: SensingCase, planner: str, folder: Path) -> Scenario:
        settings = [*case.settings, f"local_planner.use={planner}"]
        if case.lidar:
            settings.append(f"robot={_lidar(folder).resolve()}")
        return load_scenario(scene, [*settings, *self.settings])


def create(planners: Planners = None, scenes: Scenes = None, settings: Settings = ()) -> SpeedBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist.
    """
    unset(settings, {**LOCAL_PLANNERS, "tracker": "the cases", "robot": "the cases"})
    chosen = split_names(planners, "--planners") or installed()
    where = split_names(scenes, "--scenes") or SCENES
    for scene in where:
        for name in chosen:
            build_scenario(load_scenario(scene, [f"local_planner.use={name}", *settings]), 0)
    return SpeedBench(planners=chosen, scenes=where, settings=tuple(settings))


def _lidar(folder: Path) -> Path:
    """Write the file of a chair whose only sensor is a LiDAR of 16 × 360 rays."""
    robot = load_robot(ROBOT)
    lidar = robot.lidars[0].model_copy(update={"rings": RINGS, "azimuths": AZIMUTHS})
    only = robot.model_copy(update={"lidars": (lidar,), "depth_cameras": ()})
    file = folder / "chair.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(only.model_dump(mode="json")), encoding="utf-8")
    return file


def _timed_ride(scenario: Scenario, seed: int) -> Mapping[str, Any]:
    """Times of one ride; ms per tick by stage, ``world`` being everything but the navigator."""
    watch = Stopwatch()
    built = build_scenario(scenario, seed)
    build_time = watch.elapsed()
    ride = Episode(built).run()
    total = watch.elapsed()
    ticks, simulated = len(ride.time), float(ride.time[-1])
    spent = {name: float(ride.durations.get(name, np.zeros(1)).sum()) for name in STAGES}
    world = total - build_time - float(ride.durations["tick"].sum())
    return {
        "outcome": ride.outcome.value,
        "people": len(ride.people_radius),
        "simulated": simulated,
        "cpu": total,
        "factor": simulated / total,
        "build_ms": 1e3 * build_time,
        "world_ms": 1e3 * world / ticks,
        **{f"{name}_ms": 1e3 * each / ticks for name, each in spent.items()},
    }


def _report(rows: Sequence[Mapping[str, Any]]) -> BenchReport:
    """Two tables, and a verdict per case."""
    groups: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["scene"], row["case"], row["planner"]), []).append(row)
    fast = {key: float(np.median([r["factor"] for r in each])) for key, each in groups.items()}
    required = {case.name: case.required for case in CASES}
    sheets = (
        Sheet(
            "Real-time factor",
            ("scene", "case", "planner", "people", "rides", "median", "slowest", "required"),
            tuple(
                (
                    *key,
                    f"{each[0]['people']}",
                    f"{len(each)}",
                    f"{fast[key]:.1f}",
                    f"{min(r['factor'] for r in each):.1f}",
                    required[key[1]].text(),
                )
                for key, each in groups.items()
            ),
        ),
        Sheet(
            "Thread CPU time per tick of 50 ms, ms",
            ("scene", "case", "planner", *STAGES, "world"),
            tuple(
                (*key, *(f"{_mean(each, f'{name}_ms'):.2f}" for name in (*STAGES, "world")))
                for key, each in groups.items()
            ),
        ),
    )
    planners = {key[2] for key in fast}
    verdicts = [
        bounded(", ".join(key), "real-time factor", factor, required[key[1]], f"{factor:.1f}")
        for key, factor in fast.items()
        if key[2] == OURS or OURS not in planners
    ]
    summary = {
        "factors": {" / ".join(key): factor for key, factor in fast.items()},
        "verdicts": verdict_summary(verdicts),
    }
    return BenchReport((*sheets, verdict_sheet(verdicts)), verdict_notes(verdicts), summary)


def _mean(rows: Sequence[Mapping[str, Any]], column: str) -> float:
    return float(np.mean([row[column] for row in rows]))
