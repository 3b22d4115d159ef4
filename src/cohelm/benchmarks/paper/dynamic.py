"""Table 3 of Xu et al.: every local planner in the three dynamic scenes, beside the paper's rows.

All planners receive the true positions of people; ours also rides with its own sensors. The rides
are made at the speed that the paper's means imply, and again at the 1.2 m/s that its text names.
The turn of ``distracted`` is swept over the seeds, see ``rides.cases``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

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
    NONE,
    OURS,
    Bound,
    Verdict,
    bounded,
)
from cohelm.benchmarks.paper.table3 import (
    CLAIMS,
    COLUMNS,
    CUT,
    ENOUGH_CELLS,
    METHODS,
    SOURCE,
    TABLE3,
    WHOLE,
    Cell,
    PaperColumn,
    arrived_only,
    cells,
)
from cohelm.benchmarks.ride_claims import (
    Requirement,
)
from cohelm.benchmarks.rides.cases import DYNAMIC, BenchScene, Contender, rivals
from cohelm.benchmarks.rides.report import Findings, ReportSpec, finish
from cohelm.benchmarks.tables import groups_of
from cohelm.config import read_yaml
from cohelm.evaluation.report import PaperTable
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.statistics import bootstrap_median
from cohelm.evaluation.sweeps import RideTask, check_rides, ride_row
from cohelm.scenarios.presets import as_settings, tuned_settings

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


@dataclass(frozen=True)
class PaperDynamicBench:
    """The benchmark with some planners."""

    contenders: tuple[Contender, ...]
    """``SENSED`` rides with its own sensors, all others with the true positions of people."""
    paces: Mapping[str, tuple[str, ...]]
    """Pace → settings of all rides at it."""
    settings: tuple[str, ...] = ()
    """Settings of every ride, after all others."""
    TITLE: str = TITLE
    SEEDS: int = 20
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per seed, pace and scene, with the rides of all contenders.

        Only the first pace, which is judged, is ridden on all seeds; the others on the first
        ``FEWER`` of them.
        """
        some = seeds[: max(math.ceil(FEWER * len(seeds)), LEAST)]
        return [
            tuple(self.ride(contender, pace, scene, seed) for contender in self.contenders)
            for seed in seeds
            for pace in list(self.paces)[: None if seed in some else 1]
            for scene in DYNAMIC
        ]

    def ride(self, contender: Contender, pace: str, scene: str, seed: int) -> RideTask:
        """One ride."""
        where = BenchScene(scene, true_people=contender.name != SENSED, settings=self.paces[pace])
        return RideTask(
            columns=(("pace", pace), ("scene", scene), ("planner", contender.name)),
            scenario=scene,
            settings=(
                f"local_planner.use={contender.planner}",
                *where.settings_for(contender, seed),
                *self.settings,
            ),
            seed=seed,
        )

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride with every contender."""
        return [ride_row(each) for each in task]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Tables per pace, the fifteen cells, the paper's statements."""
        return dynamic_report(results, folder)


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


def create(planners: str | None = None, settings: Sequence[str] = ()) -> PaperDynamicBench:
    """Create the benchmark from its options; planners are comma-separated.

    Ours rides with the parameters of ``dynamic.yaml``, the others with those of the common search
    where there are any.

    Raises:
        PluginError, ConfigError, ScenarioError: if a planner or a setting does not exist.
    """
    fixed = {"profile.preferred_speed": "the pace of each table", "tracker": "the rows"}
    unset(settings, {**LOCAL_PLANNERS, **fixed})
    everyone, ours = preset()
    names = split_names(planners, "--planners") or rivals()
    contenders = [
        Contender(name, name, ours if name == OURS else tuned_settings(name)) for name in names
    ]
    if OURS in names:
        contenders.insert(list(names).index(OURS) + 1, Contender(SENSED, OURS, ours))
    bench = PaperDynamicBench(
        contenders=tuple(contenders),
        paces={SLOW: everyone, f"{NAMED:g} m/s": (*everyone, f"profile.preferred_speed={NAMED}")},
        settings=tuple(settings),
    )
    check_rides(bench.tasks(range(1)), "local_planner")
    return bench


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
