"""How many times faster than the clock a ride is simulated, perceived and planned, on one core.

What is measured is everything that a ride of a sweep takes: setting the stage, the people, the
drive, the sensors, the navigator with all its stages, the referee's look at contact. It is the
thread CPU time of a process that has ridden the same before, so that nothing is compiled meanwhile.
Three cases: a planar scanner of 360 beams, a LiDAR of 16 × 360 rays instead of it, both at 10 Hz,
and people known as they truly are.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from cohelm.evaluation.benches.bench import (
    LOCAL_PLANNERS,
    Report,
    Result,
    Sheet,
    Task,
    check_free,
    parted,
)
from cohelm.evaluation.benches.rides import installed
from cohelm.evaluation.benches.rides_verdicts import OURS
from cohelm.evaluation.episode import Episode
from cohelm.evaluation.scenario import Scenario, load_scenario
from cohelm.evaluation.staging import set_stage
from cohelm.robots import load_robot

TITLE = "Simulation, perception and planning against the clock, one core"
SEEDS = 2
WORKERS = 1

SCENES = ("crossing",)
"""Five people and the chair meet in a hall."""
STAGES = ("perception", "social", "walls", "sharing", "planning", "control", "safety")
ROBOT, RINGS, AZIMUTHS = "quantum_q6_edge_lidar", 16, 360


@dataclass(frozen=True)
class Case:
    """What the chair knows of the people, and by what."""

    name: str
    least: float
    """Times faster than the clock that is asked for."""
    settings: tuple[str, ...] = ()
    lidar: bool = False
    """A LiDAR of 16 × 360 rays instead of the scanner."""


CASES = (
    Case("2-D scanner, 360 beams", 10.0),
    Case("LiDAR, 16 × 360 rays", 2.0, lidar=True),
    Case("true people", 20.0, settings=("tracker.use=given",)),
)


@dataclass(frozen=True)
class SpeedBench:
    """The benchmark with some planners in some scenes."""

    planners: tuple[str, ...]
    scenes: tuple[str, ...]
    settings: tuple[str, ...] = ()
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each scene, case and planner, with all seeds: the first ride is not counted."""
        return [
            (tuple(seeds), scene, case, planner)
            for scene in self.scenes
            for case in range(len(CASES))
            for planner in self.planners
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """A row for each seed."""
        seeds, scene, case, planner = task
        scenario = self._scenario(scene, CASES[case], planner, folder)
        _ridden(scenario, seeds[0])
        columns = {"scene": scene, "case": CASES[case].name, "planner": planner}
        return [Result({**columns, "seed": seed, **_ridden(scenario, seed)}) for seed in seeds]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """How fast, what is asked, and where the time goes."""
        return _report([result.row for result in results])

    def _scenario(self, scene: str, case: Case, planner: str, folder: Path) -> Scenario:
        settings = [*case.settings, f"local_planner.use={planner}"]
        if case.lidar:
            settings.append(f"robot={_lidar(folder).resolve()}")
        return load_scenario(scene, [*settings, *self.settings])


def on(
    planners: str | None = None, scenes: str | None = None, settings: Sequence[str] = ()
) -> SpeedBench:
    """The benchmark as options ask for it; names are parted by commas.

    Raises:
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist.
    """
    check_free(settings, {**LOCAL_PLANNERS, "tracker": "the cases", "robot": "the cases"})
    chosen = parted(planners, "--planners") or installed()
    where = parted(scenes, "--scenes") or SCENES
    for scene in where:
        for name in chosen:
            set_stage(load_scenario(scene, [f"local_planner.use={name}", *settings]), 0)
    return SpeedBench(planners=chosen, scenes=where, settings=tuple(settings))


def _lidar(folder: Path) -> Path:
    """The file of a chair whose only sensor is a LiDAR of 16 × 360 rays."""
    robot = load_robot(ROBOT)
    lidar = robot.lidars[0].model_copy(update={"rings": RINGS, "azimuths": AZIMUTHS})
    only = robot.model_copy(update={"lidars": (lidar,), "depth_cameras": ()})
    file = folder / "chair.yaml"
    folder.mkdir(parents=True, exist_ok=True)
    file.write_text(yaml.safe_dump(only.model_dump(mode="json")), encoding="utf-8")
    return file


def _ridden(scenario: Scenario, seed: int) -> Mapping[str, Any]:
    """One ride's times; ms a tick by stage, ``world`` being all that the navigator does not do."""
    begin = time.thread_time()
    stage = set_stage(scenario, seed)
    staged = time.thread_time()
    ride = Episode(stage).run()
    end = time.thread_time()
    ticks, simulated = len(ride.time), float(ride.time[-1])
    spent = {name: float(ride.durations.get(name, np.zeros(1)).sum()) for name in STAGES}
    world = end - staged - float(ride.durations["tick"].sum())
    return {
        "outcome": ride.outcome.value,
        "people": len(ride.people_radius),
        "simulated": simulated,
        "cpu": end - begin,
        "factor": simulated / (end - begin),
        "staging_ms": 1e3 * (staged - begin),
        "world_ms": 1e3 * world / ticks,
        **{f"{name}_ms": 1e3 * each / ticks for name, each in spent.items()},
    }


def _report(rows: Sequence[Mapping[str, Any]]) -> Report:
    """Two tables, and a sentence for each case of whether it is as fast as is asked."""
    groups: dict[tuple[str, str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["scene"], row["case"], row["planner"]), []).append(row)
    fast = {key: float(np.median([r["factor"] for r in each])) for key, each in groups.items()}
    asked = {case.name: case.least for case in CASES}
    sheets = (
        Sheet(
            "Times faster than the clock, the median ride",
            ("scene", "case", "planner", "people", "rides", "times", "slowest", "asked"),
            tuple(
                (
                    *key,
                    f"{each[0]['people']}",
                    f"{len(each)}",
                    f"{fast[key]:.1f}",
                    f"{min(r['factor'] for r in each):.1f}",
                    f"{asked[key[1]]:g}",
                )
                for key, each in groups.items()
            ),
        ),
        Sheet(
            "Thread CPU time a tick of 50 ms, ms",
            ("scene", "case", "planner", *STAGES, "world"),
            tuple(
                (*key, *(f"{_mean(each, f'{name}_ms'):.2f}" for name in (*STAGES, "world")))
                for key, each in groups.items()
            ),
        ),
    )
    notes = [
        f"{scene}, {case}, {planner}: {times:.1f} times faster than the clock; "
        f"asked: {asked[case]:g}: {'met' if times >= asked[case] else 'MISSED'}"
        for (scene, case, planner), times in fast.items()
        if planner == OURS or OURS not in {key[2] for key in fast}
    ]
    summary = {"factors": {" / ".join(key): times for key, times in fast.items()}}
    return Report(sheets=sheets, notes=tuple(notes), summary=summary)


def _mean(rows: Sequence[Mapping[str, Any]], column: str) -> float:
    return float(np.mean([row[column] for row in rows]))
