"""What ``cohelm bench rides`` says: a table for each scene, differences ride by ride, a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.benches.bench import Report, Sheet
from cohelm.evaluation.benches.rides_verdicts import OURS, as_percent, verdicts
from cohelm.evaluation.bootstrap import Estimate, mean_of, median_of, middle_of, share
from cohelm.evaluation.results.rides import Rides, Row
from cohelm.pictures import Strip, StripPanel, draw_strips

COLUMNS = (
    "planner", "rides", "reached, %", "hit moving, %", "m/s", "wall/still", "time, s",
    "× alone", "gap, m", "ms, 99 %",
)  # fmt: skip
"""``m/s``: the fastest touch; then rides that hit a wall, or were walked into while the chair
stood; ``gap``: the least of a ride; ``ms``: a plan's thread CPU time."""
COMPARED = ("reached", "hit_moving", "time", "min_distance", "stalled_time")
"""What is compared ride by ride."""


def groups_of(rows: Sequence[Row]) -> dict[str, dict[str, Rides]]:
    """Scene → planner → rides, in the order of the rows."""
    scenes = Rides(rows, ("scene",)).together()
    return {scene: Rides(each.rows).together() for scene, each in scenes.items()}


def make_report(rows: Sequence[Row], folder: Path) -> Report:
    """Tables, sentences, a summary and the picture."""
    groups = groups_of(rows)
    says = verdicts(groups)
    sheets = []
    for scene, by_planner in groups.items():
        sheets += [scene_sheet(scene, by_planner), differences(scene, by_planner, OURS)]
    return Report(
        sheets=tuple(sheets),
        notes=(*sources(rows), *faults(rows), *says),
        summary={
            "verdicts": says,
            "scenes": {
                scene: {planner: _figures(group) for planner, group in by_planner.items()}
                for scene, by_planner in groups.items()
            },
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
        files=(picture(groups, folder / "rides.png"),),
    )


def scene_sheet(scene: str, by_planner: Mapping[str, Rides]) -> Sheet:
    """A line for each planner: shares with score intervals, medians with bootstrap intervals."""
    return Sheet(
        title=f"{scene}: share or median [95 % interval]",
        columns=COLUMNS,
        rows=tuple((name, *_cells(group)) for name, group in by_planner.items()),
    )


def differences(scene: str, by_planner: Mapping[str, Rides], base: str) -> Sheet:
    """Every other planner less ``base``, seed by seed: mean [95 % bootstrap interval]."""
    others = [name for name in by_planner if name != base] if base in by_planner else []
    return Sheet(
        title=f"{scene}: less {base}, on the same seeds (mean [95 % interval])",
        columns=("planner", "reached, %", "hit moving, %", "time, s", "gap, m", "stood, s"),
        rows=tuple((name, *_less(by_planner[name], by_planner[base])) for name in others),
    )


def signed(each: Estimate, factor: float = 1.0, digits: int = 2) -> str:
    """A difference with its sign, times a factor: ``+1.2 [0.3, 2.1]``."""
    if not each.count:
        return "–"
    mean, low, high = (factor * x + 0.0 for x in (each.mean, each.low, each.high))
    return f"{mean:+.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def _less(one: Rides, other: Rides) -> tuple[str, ...]:
    less = [mean_of(one.less(other, key)) for key in COMPARED]
    shares, rest = less[:2], less[2:]
    return (*(signed(each, 100.0, 1) for each in shares), *(signed(each) for each in rest))


def _cells(group: Rides) -> tuple[str, ...]:
    def median(values: Floats, digits: int = 2) -> str:
        return f"{median_of(values):.{digits}f}"

    speed = group.column("collision_speed")
    solve, p99 = group.column("solve_median_ms"), group.column("solve_p99_ms")
    return (
        str(len(group)),
        as_percent(share(group.reached)),
        as_percent(share(group.hit_moving)),
        f"{np.nanmax(speed):.2f}" if np.isfinite(speed).any() else "",
        f"{(group.column('collisions_wall') > 0).sum()} / "
        f"{(group.column('standing_contacts') > 0).sum()}",
        median(group.column("time"), 1),
        _figure(middle_of(group.column("time_ratio")), 2),
        median(group.column("min_distance")),
        ", ".join(_figure(middle_of(each), 1) for each in (solve, p99)),
    )


def _figure(number: float, digits: int) -> str:
    return f"{number:.{digits}f}" if np.isfinite(number) else "–"


def _figures(group: Rides) -> dict[str, Any]:
    """The table's figures for programs."""
    keys = ("time", "min_distance", "stalled_time", "path_length", "proxemics_intimate")
    medians = {key: _as_dict(median_of(group.column(key))) for key in keys}
    speed = group.column("collision_speed")
    return {
        "rides": len(group),
        "reached": _as_dict(share(group.reached)),
        "hit_moving": _as_dict(share(group.hit_moving)),
        "collision_speed": float(np.nanmax(speed)) if np.isfinite(speed).any() else None,
        "hit_wall": int((group.column("collisions_wall") > 0).sum()),
        "hit_standing": int((group.column("standing_contacts") > 0).sum()),
        "ratio_to_alone": _as_dict(median_of(group.column("time_ratio"))),
        "medians": medians,
    }


def _as_dict(each: Estimate) -> dict[str, float]:
    return {"value": each.mean, "low": each.low, "high": each.high, "count": each.count}


def sources(rows: Sequence[Row]) -> list[str]:
    """From where people were known."""
    told = sorted({row["people_from"] for row in rows if row["people_from"]})
    return [f"people as known from: {', '.join(told)}"] if told else []


def faults(rows: Sequence[Row]) -> list[str]:
    """Rides that broke off, each fault once."""
    found: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        if row["error"]:
            found.setdefault((row["planner"], row["error"]), []).append(int(row["seed"]))
    return [
        f"{planner} broke off in {len(seeds)} rides, first seed {min(seeds)}: {error}"
        for (planner, error), seeds in found.items()
    ]


def picture(groups: Mapping[str, Mapping[str, Rides]], file: Path) -> Path:
    """Gaps and times of every ride, a row of panels for each scene."""

    def panel(scene: str, key: str, axis: str) -> StripPanel:
        strips = {
            name: Strip(values=group.column(key), bad=~group.reached)
            for name, group in groups[scene].items()
        }
        return StripPanel(title=scene, axis=axis, strips=strips)

    shown = (("min_distance", "least gap to a person, m"), ("time_ratio", "time ÷ time alone"))
    draw_strips(
        [[panel(scene, *each) for each in shown] for scene in groups], file, "a ride not reached"
    )
    return file
