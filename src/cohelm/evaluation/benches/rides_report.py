"""What ``cohelm bench rides`` says: a table for each scene, differences ride by ride, a picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.evaluation.benches.bench import Report, Sheet
from cohelm.evaluation.benches.rides_verdicts import OURS, as_percent, verdicts
from cohelm.evaluation.bootstrap import Estimate, estimate, middle_of, share
from cohelm.pictures import Strip, StripPanel, draw_strips

Row = Mapping[str, Any]

COLUMNS = (
    "planner", "rides", "reached, %", "hit moving, %", "m/s", "wall/still", "time, s",
    "× alone", "gap, m", "ms, 99 %",
)  # fmt: skip
"""``m/s``: the fastest touch; then rides that hit a wall, or were walked into while the chair
stood; ``gap``: the least of a ride; ``ms``: a plan's thread CPU time."""
COMPARED = ("reached", "hit_moving", "time", "min_distance", "stalled_time")
"""What is compared ride by ride."""


class Group:
    """The rides of one planner in one scene, by seed.

    Args:
        rows: as ``ride_row`` gives them.
    """

    def __init__(self, rows: Sequence[Row]) -> None:
        self.rows = sorted(rows, key=lambda row: row["seed"])

    def __len__(self) -> int:
        return len(self.rows)

    def column(self, key: str) -> Floats:
        """(k,), NaN where a ride has none; ``reached`` and ``hit_moving`` as 0 or 1."""
        if key in {"reached", "hit_moving"}:
            found: Booleans = getattr(self, key)
            return found.astype(float)
        return np.array([row[key] for row in self.rows], dtype=float)

    @property
    def seeds(self) -> list[int]:
        """(k,)."""
        return [int(row["seed"]) for row in self.rows]

    @property
    def reached(self) -> Booleans:
        """(k,)."""
        return np.array([row["outcome"] == "reached" for row in self.rows], dtype=bool)

    @property
    def hit_moving(self) -> Booleans:
        """Rides in which the moving chair and a person touched, (k,)."""
        return self.column("collisions_person") > 0

    @property
    def touched(self) -> Booleans:
        """Rides in which the moving chair touched somebody, or it touched something, (k,)."""
        touched: Booleans = self.hit_moving | (self.column("collisions_wall") > 0)
        return touched

    @property
    def ratio(self) -> Floats:
        """Time over the time alone, (k,)."""
        return self.column("time") / self.column("time_alone")


def groups_of(rows: Sequence[Row]) -> dict[str, dict[str, Group]]:
    """Scene → planner → rides, in the order of the rows."""
    found: dict[str, dict[str, list[Row]]] = {}
    for row in rows:
        found.setdefault(row["scene"], {}).setdefault(row["planner"], []).append(row)
    return {
        scene: {planner: Group(rides) for planner, rides in each.items()}
        for scene, each in found.items()
    }


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


def scene_sheet(scene: str, by_planner: Mapping[str, Group]) -> Sheet:
    """A line for each planner: shares with score intervals, medians with bootstrap intervals."""
    return Sheet(
        title=f"{scene}: share or median [95 % interval]",
        columns=COLUMNS,
        rows=tuple((name, *_cells(group)) for name, group in by_planner.items()),
    )


def differences(scene: str, by_planner: Mapping[str, Group], base: str) -> Sheet:
    """Every other planner less ``base``, seed by seed: mean [95 % bootstrap interval]."""
    others = [name for name in by_planner if name != base] if base in by_planner else []
    return Sheet(
        title=f"{scene}: less {base}, on the same seeds (mean [95 % interval])",
        columns=("planner", "reached, %", "hit moving, %", "time, s", "gap, m", "stood, s"),
        rows=tuple((name, *_less(by_planner[name], by_planner[base])) for name in others),
    )


def paired(one: Group, other: Group, keys: Iterable[str] = COMPARED) -> dict[str, Floats]:
    """``one`` less ``other`` on the seeds that both rode, by measure; NaN where either has none."""
    mine = {seed: i for i, seed in enumerate(one.seeds)}
    both = [(mine[seed], j) for j, seed in enumerate(other.seeds) if seed in mine]
    i, j = (np.array([pair[k] for pair in both], dtype=int) for k in (0, 1))
    return {key: one.column(key)[i] - other.column(key)[j] for key in keys}


def signed(each: Estimate, factor: float = 1.0, digits: int = 2) -> str:
    """A difference with its sign, times a factor: ``+1.2 [0.3, 2.1]``."""
    if not each.count:
        return "–"
    mean, low, high = (factor * x + 0.0 for x in (each.mean, each.low, each.high))
    return f"{mean:+.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def _less(one: Group, other: Group) -> tuple[str, ...]:
    less = [estimate(each) for each in paired(one, other).values()]
    shares, rest = less[:2], less[2:]
    return (*(signed(each, 100.0, 1) for each in shares), *(signed(each) for each in rest))


def _cells(group: Group) -> tuple[str, ...]:
    def median(values: Floats, digits: int = 2) -> str:
        return f"{estimate(values, np.median):.{digits}f}"

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
        f"{middle_of(group.ratio):.2f}",
        median(group.column("min_distance")),
        f"{middle_of(solve):.1f}, {middle_of(p99):.1f}",
    )


def _figures(group: Group) -> dict[str, Any]:
    """The table's figures for programs."""
    keys = ("time", "min_distance", "stalled_time", "path_length", "proxemics_intimate")
    medians = {key: _as_dict(estimate(group.column(key), np.median)) for key in keys}
    speed = group.column("collision_speed")
    return {
        "rides": len(group),
        "reached": _as_dict(share(group.reached)),
        "hit_moving": _as_dict(share(group.hit_moving)),
        "collision_speed": float(np.nanmax(speed)) if np.isfinite(speed).any() else None,
        "hit_wall": int((group.column("collisions_wall") > 0).sum()),
        "hit_standing": int((group.column("standing_contacts") > 0).sum()),
        "ratio_to_alone": _as_dict(estimate(group.ratio, np.median)),
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


def picture(groups: Mapping[str, Mapping[str, Group]], file: Path) -> Path:
    """Gaps and times of every ride, a row of panels for each scene."""

    def panel(scene: str, key: str, axis: str) -> StripPanel:
        strips = {
            name: Strip(values=_shown(group, key), bad=~group.reached)
            for name, group in groups[scene].items()
        }
        return StripPanel(title=scene, axis=axis, strips=strips)

    shown = (("min_distance", "least gap to a person, m"), ("ratio", "time ÷ time alone"))
    draw_strips(
        [[panel(scene, *each) for each in shown] for scene in groups], file, "a ride not reached"
    )
    return file


def _shown(group: Group, key: str) -> Floats:
    return group.ratio if key == "ratio" else group.column(key)
