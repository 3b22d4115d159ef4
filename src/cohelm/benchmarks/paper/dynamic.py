"""Table 3 of Xu et al.: every local planner in the three dynamic scenes, beside the paper's rows.

All planners receive the true positions of people; ours also rides with its own sensors. The rides
are made at the speed that the paper's means imply, and again at the 1.2 m/s that its text names.
The turn of ``distracted`` is swept over the seeds, see ``rides.cases``.

The report judges what the paper concludes from its table, and our medians cell by cell. What the
paper leaves open is fixed here as in its scenes: distances are between surfaces, the time
is that of the first entry into 0.2 m of the goal, the length is extended to the goal point, and
the variances are those of the ride until that moment.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.benchmarks.bench import (
    LOCAL_PLANNERS,
    BenchReport,
    Result,
    Sheet,
    chosen_names,
    unset,
)
from cohelm.benchmarks.claims import (
    NONE,
    OURS,
    SOME,
    Bound,
    Verdict,
    bounded,
)
from cohelm.benchmarks.options import Planners, Settings
from cohelm.benchmarks.ride_claims import (
    Claim,
    Ordering,
    Requirement,
    between,
    within,
)
from cohelm.benchmarks.rides.cases import DYNAMIC, TRUE_PEOPLE, contender_of, rivals, scenes_of
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish
from cohelm.benchmarks.study import Grid, Study, Variant, common
from cohelm.benchmarks.tables import groups_of
from cohelm.config import read_yaml
from cohelm.evaluation.report import PaperTable
from cohelm.evaluation.report.rides import Rides, Row
from cohelm.evaluation.report.statistics import Estimate, bootstrap_median
from cohelm.scenarios.presets import as_settings, tuned_settings

SOURCE = "Xu et al., Table 3"
METHODS: Mapping[str, str] = {
    "mpc": "MPC",
    "mpc_dcbf": "MPC-DCBF",
    "social_mpc": "Socially-aware MPC",
    OURS: "SS-MPC-DCBF",
}
"""Our planner → the paper's method."""

TABLE3: Mapping[str, Mapping[str, tuple[float, float, float, float, float]]] = {
    "crossing": {
        "mpc": (0.0, 57.90, 12.147, 0.0585, 0.0852),
        "mpc_dcbf": (0.4898, 14.72, 10.171, 0.0627, 0.1799),
        "social_mpc": (0.8852, 15.53, 11.023, 0.0557, 0.2753),
        OURS: (0.2411, 16.89, 10.067, 0.0506, 0.0741),
    },
    "aggressive": {
        "mpc": (0.0, 32.90, 11.299, 0.0097, 0.1770),
        "mpc_dcbf": (0.5102, 14.84, 10.730, 0.0309, 0.3591),
        "social_mpc": (0.0, 19.76, 12.737, 0.0529, 0.9214),
        OURS: (0.5962, 15.05, 10.673, 0.0260, 0.2591),
    },
    "distracted": {
        "mpc": (0.0, 29.44, 10.698, 0.0079, 0.0752),
        "mpc_dcbf": (0.2857, 14.04, 10.122, 0.0298, 0.2369),
        "social_mpc": (0.2861, 15.88, 10.112, 0.0383, 0.1844),
        OURS: (0.3284, 13.755, 10.018, 0.0280, 0.0513),
    },
}
"""Scene → planner → printed figures in the order of ``COLUMNS``; a distance of 0 is a collision."""


@dataclass(frozen=True)
class PaperColumn:
    """A column of the table."""

    key: str
    """Column of a ride's row."""
    title: str
    unit: str
    digits: int
    better: int
    """1: more is better, −1: less."""

    @property
    def head(self) -> str:
        """Title with its unit."""
        return f"{self.title}, {self.unit}"

    def worst(self, values: Any) -> float:
        """Worst of values (k,); NaN where there are none."""
        there = values[np.isfinite(values)]
        if not len(there):
            return np.nan
        return float(there.min() if self.better > 0 else there.max())


COLUMNS = (
    PaperColumn("min_distance", "min distance", "m", 3, 1),
    PaperColumn("time", "time", "s", 2, -1),
    PaperColumn("path_length", "length", "m", 3, -1),
    PaperColumn("linear_velocity_variance_underway", "var v", "m²/s²", 4, -1),
    PaperColumn("angular_velocity_variance_underway", "var ω", "rad²/s²", 4, -1),
)
"""Columns in the paper's order."""
CUT = tuple(
    replace(each, key="path_length_short", title="length to 0.3 m before the goal")
    if each.key == "path_length"
    else each
    for each in COLUMNS
)
"""Columns with the length ended 0.3 m before the goal: the paper does not define its end."""
WHOLE = tuple(
    replace(each, key=each.key.removesuffix("_underway"), title=f"{each.title}, whole ride")
    if each.key.endswith("_underway")
    else each
    for each in COLUMNS
)
"""Columns with the variances over the whole ride, until the chair stands at its goal."""
ENOUGH_CELLS = 13
"""Cells, of 15, in which our medians have to be better than the paper's."""


@dataclass(frozen=True)
class Cell:
    """One measure in one scene beside the paper's figure."""

    scene: str
    column: PaperColumn
    paper: float
    ours: Estimate
    """Median with its interval, over the rides that have the measure."""

    @property
    def won(self) -> bool:
        """True where our median is better; a missing one is not."""
        return bool(self.column.better * (self.ours.mean - self.paper) > 0.0)

    def __str__(self) -> str:
        ours = f"{self.ours.mean:.{self.column.digits}f}"
        return f"{self.scene}, {self.column.title} ({ours} against {self.paper:.5g})"


def arrived_only(row: Row) -> dict[str, Any]:
    """Row in which only a ride that arrived has time, length and variances; NaN otherwise.

    The minimum distance stays that of every ride, 0 at a collision with a person.
    """
    if row["outcome"] == "reached":
        return dict(row)
    keys = {column.key for column in (*COLUMNS, *CUT, *WHOLE)} - {"min_distance"}
    return {**row, **dict.fromkeys(keys & row.keys(), np.nan)}


def cells(
    rides: Mapping[str, Rides], columns: Sequence[PaperColumn] = COLUMNS, paper: str = OURS
) -> list[Cell]:
    """Every cell of the paper's table, scene by scene.

    Args:
        rides: scene → rides of one planner; scenes that the paper lacks are left out.
        columns: as many as the paper has, in its order.
        paper: row of the paper.
    """
    return [
        Cell(scene, column, figure, bootstrap_median(group.column(column.key)))
        for scene, group in rides.items()
        if scene in TABLE3
        for column, figure in zip(columns, TABLE3[scene][paper], strict=True)
    ]


_RIVALS = ("mpc", "mpc_dcbf", "social_mpc")
_AVOIDING = ("mpc_dcbf", "social_mpc")
_GAP, _TIME, _LENGTH, _VAR_V, _VAR_W = (column.key for column in COLUMNS)


def _touches(planner: str, scenes: tuple[str, ...], text: str, *, touches: bool) -> Requirement:
    bound = SOME if touches else NONE
    return Requirement("person_contacts", bound, scenes, planner, source=SOURCE, text=text)


CLAIMS: tuple[Claim, ...] = (
    Ordering("SS-MPC-DCBF drives the shortest path in all three scenes",
             (_LENGTH,), -1, within(DYNAMIC, OURS, _RIVALS), SOURCE),
    Ordering("SS-MPC-DCBF's speed varies less than that of both others that avoid people",
             (_VAR_V,), -1, within(DYNAMIC, OURS, _AVOIDING), SOURCE),
    Ordering("SS-MPC-DCBF's turn rate varies less than that of both others that avoid people",
             (_VAR_W,), -1, within(DYNAMIC, OURS, _AVOIDING), SOURCE),
    _touches(OURS, DYNAMIC, "SS-MPC-DCBF never collides in all three scenes", touches=False),
    _touches("mpc", DYNAMIC, "MPC, which does not predict, collides in all three scenes",
             touches=True),
    _touches("mpc_dcbf", DYNAMIC, "MPC-DCBF never collides in all three scenes",
             touches=False),
    Ordering("MPC-DCBF, which knows no social space, passes aggressive and distracted people "
             "nearer than SS-MPC-DCBF", (_GAP,), -1,
             within(("aggressive", "distracted"), "mpc_dcbf", (OURS,)), SOURCE),
    Ordering("Socially-aware MPC keeps the largest distance in crossing",
             (_GAP,), 1, within(("crossing",), "social_mpc", ("mpc", "mpc_dcbf", OURS)), SOURCE),
    _touches("social_mpc", ("aggressive",), "Socially-aware MPC collides in aggressive",
             touches=True),
    Ordering("Socially-aware MPC is less smooth in crossing and aggressive than in distracted",
             (_VAR_V, _VAR_W), 1,
             between("social_mpc", ("crossing", "aggressive"), "distracted"), SOURCE),
    Ordering("MPC-DCBF is the fastest in crossing and aggressive", (_TIME,), -1,
             within(("crossing", "aggressive"), "mpc_dcbf", ("mpc", "social_mpc", OURS)), SOURCE),
    Ordering("SS-MPC-DCBF is the fastest in distracted", (_TIME,), -1,
             within(("distracted",), OURS, _RIVALS), SOURCE),
    Ordering("MPC is the slowest in all three scenes", (_TIME,), 1,
             within(DYNAMIC, "mpc", ("mpc_dcbf", "social_mpc", OURS)), SOURCE),
)  # fmt: skip
"""Everything that Table 3 and the sentences about it order."""


TITLE = "The paper's dynamic scenes, every local planner beside the paper's figures (Table 3)"
NAMED = 1.2
"""Preferred speed that the paper's text names, m/s."""
FEWER, LEAST = 0.25, 20
"""Share of the seeds that is ridden at it, and their minimum number."""
SLOW = "as the paper's means"
"""Pace of the first table: the one speed that is chosen for all scenes."""
SENSED = f"{OURS}, sensors"
"""Contender: ours, with people as its sensors detect them."""
LIMITATIONS = (
    "distances are from surface to surface; time to the first entry into 0.2 m of the goal; the "
    "length is extended to the goal point; variances are of the ride until that entry",
    "medians with 95 % bootstrap intervals over the seeds, and the worst ride; the distance is "
    "that of all rides, the rest that of those that arrived; start and goal are 10.00 m apart",
    "the paper's rows are of scenes without coordinates: its chair, people, walls and "
    "definitions differ from ours, and our gate brakes for people with every planner",
)

ByScene = Mapping[str, Mapping[str, Rides]]
"""Scene → contender → rides."""


def preset() -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Settings of (all planners, ours) in the paper's scenes, from ``dynamic.yaml``.

    Raises:
        ConfigError: if the file does not hold a mapping.
    """
    found: dict[str, Any] = read_yaml(Path(str(files("cohelm.benchmarks.paper") / "dynamic.yaml")))
    common, ours = (
        tuple(
            setting
            for part, parameters in found[key].items()
            for setting in as_settings(parameters, part)
        )
        for key in ("everyone", "ours")
    )
    return common, ours


def create(planners: Planners = None, settings: Settings = ()) -> Study:
    """Create the study from its options; planners are comma-separated.

    Ours rides with the parameters of ``dynamic.yaml``, the others with those of the common search
    where there are any.

    Raises:
        PluginError, ConfigError, ScenarioError: if a planner or a setting does not exist.
    """
    fixed = {"profile.preferred_speed": "the pace of each table", "tracker": "the rows"}
    unset(settings, {**LOCAL_PLANNERS, **fixed})
    everyone, ours = preset()
    named = (f"profile.preferred_speed={NAMED}",)
    paces = tuple(
        Variant((("pace", pace),), settings, defaults=everyone)
        for pace, settings in ((SLOW, ()), (f"{NAMED:g} m/s", named))
    )
    compared = []
    for name in chosen_names(planners, "--planners", rivals()):
        own = ours if name == OURS else tuned_settings(name)
        compared.append(contender_of(name, settings=(TRUE_PEOPLE,), defaults=own))
        if name == OURS:
            compared.append(contender_of(SENSED, OURS, defaults=ours))
    plan = Grid(
        (
            paces,
            scenes_of(DYNAMIC),
            tuple(compared),
            common(settings),
        ),
        compared=2,
        keep=_is_ridden,
    )
    return Study(TITLE, plan, dynamic_report).checked()


def _is_ridden(columns: Mapping[str, str], seed: int, seeds: range) -> bool:
    """Check that a pace is ridden on a seed: the first one always, others on ``FEWER`` seeds."""
    return columns["pace"] == SLOW or seed in seeds[: max(math.ceil(FEWER * len(seeds)), LEAST)]


def dynamic_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Report of rides with columns ``pace``, ``scene`` and ``planner``."""
    rows = [arrived_only(result.row) for result in results]
    by_pace = {
        pace: groups_of([row for row in rows if row["pace"] == pace])
        for pace in dict.fromkeys(str(row["pace"]) for row in rows)
    }
    slow = by_pace.get(SLOW, {})
    sheets = [
        scene_sheet(f"{pace}, {scene}", scene, groups[scene], COLUMNS)
        for pace, groups in by_pace.items()
        for scene in groups
    ]
    if slow:
        sheets += [
            scene_sheet(f"{SLOW}, length cut, {scene}", scene, slow[scene], CUT) for scene in slow
        ]
        sheets.append(cell_sheet(slow))
    claims = [*(claim for pace in by_pace for claim in _requirements(pace)), *CLAIMS]
    spec = ReportSpec(
        title=TITLE,
        claims=tuple(claims),
        by=("pace", "scene", "planner"),
        page=("reached", "person_collision", "wall_collision", *(each.key for each in COLUMNS)),
        limitations=LIMITATIONS,
        paper=_paper_table(by_pace),
    )
    found = Findings(
        sheets=tuple(sheets),
        summary={"cells": {pace: _cells_of(groups) for pace, groups in by_pace.items()}},
        verdicts=tuple(cell_verdicts(by_pace)),
    )
    paced = {f"{pace}, {scene}": each for pace, g in by_pace.items() for scene, each in g.items()}
    return finish(results, folder, spec, found, {**paced, **slow})


def _requirements(pace: str) -> list[Requirement]:
    """Collisions of ours are judged at the first pace with true people, and counted elsewhere."""
    out = []
    for contender in (OURS, SENSED):
        judged = pace == SLOW and contender == OURS
        for figure, bound in (
            ("collisions", NONE if judged else Bound()),
            ("reached", Bound()),
            ("standing_contacts", Bound()),
        ):
            out.append(Requirement(figure, bound, (f"{pace}, *",), contender, pooled=pace))
    return out


def cell_verdicts(by_pace: Mapping[str, ByScene]) -> list[Verdict]:
    """Number of cells that ours wins, each lost one by its name."""
    out = []
    for pace, groups in by_pace.items():
        for contender in (OURS, SENSED):
            rides = _rides_of(groups, contender)
            if not rides:
                continue
            variants: dict[str, Sequence[PaperColumn]] = {"": COLUMNS}
            if pace == SLOW:
                variants |= {", length cut": CUT, ", variances of whole rides": WHOLE}
            for suffix, columns in variants.items():
                judged = pace == SLOW and contender == OURS and not suffix
                bound = Bound(low=ENOUGH_CELLS) if judged else Bound()
                subject = f"{pace}, {contender}{suffix}"
                out.append(_cells_won(subject, cells(rides, columns), bound))
    return out


def _cells_won(subject: str, found: Sequence[Cell], bound: Bound) -> Verdict:
    lost = [str(cell) for cell in found if not cell.won]
    won = len(found) - len(lost)
    claim, text = "cells better than the paper's own row", f"{won} of {len(found)}"
    remark = f"lost: {'; '.join(lost) or 'none'}"
    if bound == Bound():
        return Verdict(subject, claim, text, remark=remark)
    return bounded(subject, claim, won, bound, text, remark)


def scene_sheet(
    title: str, scene: str, by_planner: Mapping[str, Rides], columns: Sequence[PaperColumn]
) -> Sheet:
    """One line per planner, and the paper's below them."""
    rows = [
        (
            name,
            str(len(rides)),
            str(int(rides.reached.sum())),
            str(int(rides.any_collision.sum())),
            *(_median_and_worst(rides, column) for column in columns),
        )
        for name, rides in by_planner.items()
    ]
    for name, printed in TABLE3.get(scene, {}).items():
        hit = "yes" if printed[0] == 0.0 else "no"
        rows.append((f"paper: {METHODS[name]}", "–", "–", hit, *(f"{x:.5g}" for x in printed)))
    return Sheet(
        title=f"{title}: median [95 % interval]; worst",
        columns=("planner", "rides", "reached", "collided", *(each.head for each in columns)),
        rows=tuple(rows),
    )


def cell_sheet(groups: ByScene) -> Sheet:
    """Ours beside the paper's own row, cell by cell, with true and with detected people."""
    true, sensed = (cells(_rides_of(groups, name)) for name in (OURS, SENSED))
    by_cell = {(cell.scene, cell.column.key): cell for cell in sensed}

    def texts(cell: Cell | None) -> tuple[str, str]:
        if cell is None:
            return "–", "–"
        return f"{cell.ours:.{cell.column.digits}f}", "better" if cell.won else "LOST"

    rows = (
        (f"{cell.scene}, {cell.column.head}", f"{cell.paper:.5g}", *texts(cell),
         *texts(by_cell.get((cell.scene, cell.column.key))))
        for cell in true
    )  # fmt: skip
    return Sheet(
        title=f"{SLOW}: {OURS} beside the paper's own row",
        columns=("cell", "paper", "true people", "", "sensors", ""),
        rows=tuple(rows),
    )


def _paper_table(paces: Mapping[str, Any]) -> PaperTable:
    """The paper's rows, which are equal at every pace."""
    rows: dict[tuple[str, ...], dict[str, float]] = {
        (pace, scene, planner): dict(zip((each.key for each in COLUMNS), printed, strict=True))
        for pace in paces
        for scene, by_planner in TABLE3.items()
        for planner, printed in by_planner.items()
    }
    return PaperTable(SOURCE, rows)


def _cells_of(groups: ByScene) -> dict[str, list[dict[str, Any]]]:
    return {
        name: [
            {
                "scene": cell.scene,
                "measure": cell.column.key,
                "paper": cell.paper,
                "ours": cell.ours.mean,
                "low": cell.ours.low,
                "high": cell.ours.high,
                "won": cell.won,
            }
            for cell in cells(_rides_of(groups, name))
        ]
        for name in (OURS, SENSED)
    }


def _rides_of(groups: ByScene, name: str) -> dict[str, Rides]:
    return {scene: each[name] for scene, each in groups.items() if name in each}


def _median_and_worst(rides: Rides, column: PaperColumn) -> str:
    values = rides.column(column.key)
    found = bootstrap_median(values)
    if not found.count:
        return "–"
    return f"{found:.{column.digits}f}; {column.worst(values):.{column.digits}f}"
