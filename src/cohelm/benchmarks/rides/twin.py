"""Rides in the planar simulation beside the same rides in the MuJoCo twin.

Scenario, seed, people and random streams are equal; the chair's mechanics, the height of its
scanner and what it touches differ. Forces are those of the twin, beside limits after
ISO/TS 15066; what they leave out stands in ``platforms/twin/body_regions.py``.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.benchmarks.bench import BenchReport, Result, Sheet, chosen_names, unset
from cohelm.benchmarks.options import Scenes, Settings
from cohelm.benchmarks.study import Grid, Study, Variant, axis, common
from cohelm.evaluation import Ride, run
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.navigation import Tick
from cohelm.platforms import is_simulated
from cohelm.platforms.twin import load_mujoco
from cohelm.platforms.twin.body_regions import REGIONS
from cohelm.simulation import GroundTruth, Touch

TITLE = "Planar simulation beside the MuJoCo twin"
PLATFORMS = ("planar", "twin")
SCENES = (
    *("hospital", "crossing", "aggressive", "distracted"),
    *("corridor-1", "corridor-2", "corridor-3", "corridor-4", "door-threshold", "ramp"),
)
FAST = 0.2
"""Speed of the chair above which a contact with a person counts as a fast collision, m/s."""
ARRIVALS = 0.95
"""Share of arrivals that is wanted in the twin."""


class _Watch:
    """Hardest contact of a ride with a person."""

    def __init__(self) -> None:
        self.hardest: Touch | None = None
        self.fastest = 0.0

    def __call__(self, tick: Tick, truth: GroundTruth) -> None:
        for touch in truth.touches:
            if touch.person < 0:
                continue
            self.fastest = max(self.fastest, touch.chair_speed)
            if self.hardest is None or touch.force > self.hardest.force:
                self.hardest = touch

    def columns(self, ride: Ride) -> Mapping[str, Any]:
        """Columns of the row."""
        hardest = self.hardest
        if hardest is None:
            return {"force": 0.0, "energy": 0.0, "part": "", "chair_speed": 0.0}
        return {
            "force": hardest.force,
            "energy": hardest.energy,
            "part": hardest.part,
            "chair_speed": self.fastest,
        }


def create(scenes: Scenes = None, settings: Settings = ()) -> Study:
    """Create the study from its options; names are comma-separated.

    Raises:
        PlatformError: MuJoCo is not installed.
        ConfigError, ScenarioError: if a scene or a setting does not exist.
    """
    load_mujoco()
    unset(settings, {"platform": "the benchmark, which rides on both"})
    ridden = tuple(
        Variant((("scene", Path(name).stem),), scenario=name)
        for name in chosen_names(scenes, "--scenes", SCENES)
    )
    both = axis("platform", {name: (f"platform.use={name}",) for name in PLATFORMS})
    study = Study(
        TITLE, Grid((ridden, both, common(settings)), compared=2), _report, _ride, SEEDS=10
    ).checked()
    for ride in study.tasks(range(1))[0]:
        is_simulated(ride.load())
    return study


def _ride(task: Sequence[RideTask]) -> list[Result]:
    """Ride on every platform, with the hardest contact."""
    out = []
    for each in task:
        watch = _Watch()
        drive = functools.partial(run, on_tick=watch)
        out.append(ride_row(each, empty_floor=False, more=watch.columns, drive=drive))
    return out


def _report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Rides of both platforms by scene, rides that were lost, and contacts."""
    rows = [result.row for result in results]
    groups: dict[tuple[str, str], list[Mapping[str, Any]]] = {}
    for row in rows:
        groups.setdefault((row["scene"], row["platform"]), []).append(row)
    by_platform = {p: [row for row in rows if row["platform"] == p] for p in PLATFORMS}
    lines = [_line(*key, each) for key, each in groups.items()]
    lines += [_line("all", p, each) for p, each in by_platform.items() if each]
    sheets = (
        Sheet(
            "Rides",
            (
                *("scene", "platform", "rides", "reached", "collisions", f"over {FAST:g} m/s"),
                *("least gap, m", "time, s", "jerk, m/s³"),
            ),
            tuple(lines),
        ),
        Sheet(
            "Rides that ended otherwise on one platform",
            ("scene", "seed", *PLATFORMS),
            tuple(_changed(rows)),
        ),
        Sheet(
            "Hardest contact of a ride with a person, in the twin",
            (
                *("scene", "seed", "part", "force, N", "limit, N", "energy, J", "limit, J"),
                "fastest chair, m/s",
            ),
            tuple(_contacts(by_platform["twin"])),
        ),
    )
    summary = {
        p: {
            "rides": len(each),
            "reached": sum(row["outcome"] == "reached" for row in each),
            "fast_collisions": sum(_is_fast(row) for row in each),
            "force": max((float(row.get("force") or 0.0) for row in each), default=0.0),
            "energy": max((float(row.get("energy") or 0.0) for row in each), default=0.0),
        }
        for p, each in by_platform.items()
    }
    return BenchReport(sheets, _notes(summary["twin"]), summary)


def _line(scene: str, platform: str, rows: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    reached = [row for row in rows if row["outcome"] == "reached"]
    gaps = _numbers(rows, "min_distance")
    return (
        scene,
        platform,
        f"{len(rows)}",
        f"{len(reached)}",
        f"{sum(row['outcome'] == 'collision' for row in rows)}",
        f"{sum(_is_fast(row) for row in rows)}",
        f"{gaps.min():.2f}" if len(gaps) else "–",
        _median(reached, "time", 1),
        _median(reached, "jerk_rms", 2),
    )


def _is_fast(row: Mapping[str, Any]) -> bool:
    """Check for a collision, with a person or a wall, above the speed limit of contacts."""
    speeds = [row.get("collision_speed"), row.get("collision_speed_wall")]
    return row["outcome"] == "collision" and any(_number(each) > FAST for each in speeds)


def _changed(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    found: dict[tuple[str, int], dict[str, str]] = {}
    for row in rows:
        found.setdefault((row["scene"], row["seed"]), {})[row["platform"]] = row["outcome"]
    return [
        (scene, f"{seed}", *(each.get(p, "–") for p in PLATFORMS))
        for (scene, seed), each in found.items()
        if len(set(each.values())) > 1
    ]


def _contacts(rows: Sequence[Mapping[str, Any]]) -> list[tuple[str, ...]]:
    touched = [row for row in rows if _number(row.get("force")) > 0.0]
    out: list[tuple[str, ...]] = []
    for row in sorted(touched, key=lambda row: -float(row["force"])):
        region = REGIONS[str(row["part"])]
        out.append(
            (
                str(row["scene"]),
                f"{row['seed']}",
                str(row["part"]),
                f"{float(row['force']):.0f}",
                f"{region.transient_force:.0f}",
                f"{float(row['energy']):.2f}",
                f"{region.transient_energy:.2f}",
                f"{float(row['chair_speed']):.2f}",
            )
        )
    return out


def _notes(twin: Mapping[str, Any]) -> tuple[str, ...]:
    rides = max(int(twin["rides"]), 1)
    arrived = twin["reached"] / rides >= ARRIVALS
    clean = twin["fast_collisions"] == 0
    return (
        f"arrivals in the twin, at least {ARRIVALS:.0%}: {'met' if arrived else 'MISSED'}; "
        f"{twin['reached']} of {twin['rides']}",
        f"collisions over {FAST:g} m/s in the twin, none: {'met' if clean else 'MISSED'}; "
        f"{twin['fast_collisions']}",
    )


def _median(rows: Sequence[Mapping[str, Any]], column: str, digits: int) -> str:
    values = _numbers(rows, column)
    return f"{np.median(values):.{digits}f}" if len(values) else "–"


def _numbers(rows: Sequence[Mapping[str, Any]], column: str) -> Any:
    values = np.array([_number(row.get(column)) for row in rows])
    return values[np.isfinite(values)]


def _number(given: Any) -> float:
    return math.nan if given in {None, ""} else float(given)
