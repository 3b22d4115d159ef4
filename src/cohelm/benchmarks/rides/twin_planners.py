"""Order of the local planners in the planar simulation and in the MuJoCo twin.

Every planner rides the scenes of ``rides`` on both platforms with equal seeds. Kendall's τ_b
compares both orders, measure by measure. Beside it stands τ_b between the planar rides of both
halves of the seeds: what chance alone leaves of the order.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from cohelm.benchmarks.bench import LOCAL_PLANNERS, BenchReport, Result, Sheet, Task, unset
from cohelm.benchmarks.rides import rides
from cohelm.benchmarks.rides.twin import PLATFORMS
from cohelm.evaluation.sweeps import RideTask, ride_row
from cohelm.platforms import is_simulated
from cohelm.platforms.twin import load_mujoco

TITLE = "Order of local planners in the planar simulation and in the MuJoCo twin"
MEASURES: Mapping[str, tuple[str, bool]] = {
    "arrivals": ("reached", True),
    "time": ("time", False),
    "least gap": ("min_distance", True),
    "jerk": ("jerk_rms", False),
}
"""Measure → (column, larger is better); arrivals is a share, all others are medians."""
ORDER = "arrivals, then time"
"""Name of the order that decides about places."""
Row = Mapping[str, Any]
Figures = Mapping[str, Mapping[str, float]]
"""Planner → measure → value."""


@dataclass(frozen=True)
class TwinPlannersBench:
    """The benchmark with some planners in some scenes."""

    planar: rides.RidesBench
    """Its rides are ridden on both platforms."""
    TITLE: str = TITLE
    SEEDS: int = 8
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed and scene, with the rides of all planners on both platforms."""
        return [
            tuple(_on(each, platform) for each in task for platform in PLATFORMS)
            for task in self.planar.tasks(seeds)
        ]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride with every planner on both platforms."""
        return [ride_row(each, empty_floor=False) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Figures and places of the planners, Kendall's τ_b, and planners that change place."""
        rows = [result.row for result in results]
        on = {platform: _figures(_of(rows, "platform", platform)) for platform in PLATFORMS}
        seeds = sorted({int(row["seed"]) for row in rows})
        halves = [
            _figures([row for row in _of(rows, "platform", PLATFORMS[0]) if row["seed"] in part])
            for part in (seeds[::2], seeds[1::2])
        ]
        pairs = [on[platform] for platform in PLATFORMS], halves
        taus = {
            name: (_tau(*pairs[0], name=name), _tau(*pairs[1], name=name))
            for name in (*MEASURES, ORDER)
        }
        places = {platform: _places(each) for platform, each in on.items()}
        sheets = (_figure_sheet(on, places), _tau_sheet(taus, on))
        summary = {
            "tau": {name: both[0] for name, both in taus.items()},
            "tau_of_halves": {name: both[1] for name, both in taus.items()},
            "places": places,
            "seeds": seeds,
        }
        return BenchReport(sheets, _notes(places, taus[ORDER][0]), summary)


def create(
    planners: str | None = None, scenes: str | None = None, settings: Sequence[str] = ()
) -> TwinPlannersBench:
    """Create the benchmark from its options; names are comma-separated.

    Raises:
        PlatformError: MuJoCo is not installed.
        ScenarioError, PluginError, ConfigError: if a scene, a planner or a setting does not exist.
    """
    load_mujoco()
    unset(settings, {**LOCAL_PLANNERS, "platform": "the benchmark, which rides on both"})
    bench = TwinPlannersBench(rides.create(planners, scenes, settings))
    for task in bench.tasks(range(1)):
        is_simulated(task[0].load())
    return bench


def _on(ride: RideTask, platform: str) -> RideTask:
    return replace(
        ride,
        columns=(*ride.columns, ("platform", platform)),
        settings=(f"platform.use={platform}", *ride.settings),
    )


def _of(rows: Sequence[Row], column: str, value: str) -> list[Row]:
    return [row for row in rows if row[column] == value]


def _figures(rows: Sequence[Row]) -> dict[str, dict[str, float]]:
    """Planner → measure → value over the rides of all scenes; NaN where no ride arrived."""
    out = {}
    for planner in dict.fromkeys(str(row["planner"]) for row in rows):
        own = _of(rows, "planner", planner)
        reached = _of(own, "outcome", "reached")
        out[planner] = {
            "arrivals": len(reached) / len(own),
            "time": _median(reached, "time"),
            "least gap": _median(own, "min_distance"),
            "jerk": _median(reached, "jerk_rms"),
        }
    return out


def _median(rows: Sequence[Row], column: str) -> float:
    values = np.array([float(row[column]) for row in rows if row[column] not in {None, ""}])
    values = values[np.isfinite(values)]
    return float(np.median(values)) if len(values) else math.nan


def _key(figures: Mapping[str, float], name: str) -> tuple[float, ...]:
    """Sorting key of a planner; the smallest is the best."""
    if name == ORDER:
        return (*_key(figures, "arrivals"), *_key(figures, "time"))
    value, larger = figures[name], MEASURES[name][1]
    if math.isnan(value):
        return (math.inf,)
    return (-value if larger else value,)


def _places(figures: Figures, name: str = ORDER) -> dict[str, int]:
    """Place of each planner from 1 on; equal planners share the better place."""
    keys = {planner: _key(each, name) for planner, each in figures.items()}
    return {
        planner: 1 + sum(other < key for other in keys.values()) for planner, key in keys.items()
    }


def _tau(one: Figures, other: Figures, *, name: str) -> float:
    """Kendall's τ_b between two orders of the planners that both have; NaN if one is all equal."""
    both = [planner for planner in one if planner in other]
    if len(both) < 2:
        return math.nan
    places = [_places({planner: each[planner] for planner in both}, name) for each in (one, other)]
    return float(stats.kendalltau(*([each[p] for p in both] for each in places)).statistic)


def _figure_sheet(on: Mapping[str, Figures], places: Mapping[str, Mapping[str, int]]) -> Sheet:
    planar, twin = (on[platform] for platform in PLATFORMS)
    order = sorted(planar, key=lambda planner: places[PLATFORMS[0]][planner])
    lines = []
    for planner in order:
        both = (planar[planner], twin.get(planner, dict.fromkeys(MEASURES, math.nan)))
        lines.append(
            (
                planner,
                *(f"{places[p].get(planner, '–')}" for p in PLATFORMS),
                *(f"{each['arrivals']:.0%}" for each in both),
                *(f"{each['time']:.1f}" for each in both),
                *(f"{each['least gap']:.2f}" for each in both),
                *(f"{each['jerk']:.2f}" for each in both),
            )
        )
    heads = ("place", "arrivals", "time, s", "least gap, m", "jerk, m/s³")
    columns = ("planner", *(f"{head}, {p}" for head in heads for p in PLATFORMS))
    return Sheet("Planners, over all scenes", columns, tuple(lines))


def _tau_sheet(taus: Mapping[str, tuple[float, float]], on: Mapping[str, Figures]) -> Sheet:
    lines = []
    for name, (tau, chance) in taus.items():
        before, after = (_places(on[p], name) for p in PLATFORMS)
        moved = [f"{p} {before[p]} → {after[p]}" for p in before if before[p] != after.get(p)]
        lines.append((name, f"{tau:.2f}", f"{chance:.2f}", ", ".join(moved) or "–"))
    return Sheet(
        "Kendall's τ_b between the orders on both platforms",
        ("measure", "τ_b", "τ_b of halves of the seeds, planar", "change of place, planar → twin"),
        tuple(lines),
    )


def _notes(places: Mapping[str, Mapping[str, int]], tau: float) -> tuple[str, ...]:
    before, after = (places[platform] for platform in PLATFORMS)
    moved = [planner for planner in before if before[planner] != after.get(planner)]
    return (
        f"order by {ORDER}: τ_b {tau:.2f}; {len(moved)} of {len(before)} planners change place"
        f"{': ' + ', '.join(moved) if moved else ''}",
    )
