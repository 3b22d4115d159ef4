"""What ``cohelm bench paper-dynamic`` says: three tables, 15 cells, and the paper's claims."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.benches.bench import Report, Result, Sheet
from cohelm.evaluation.benches.paper_claims import AGREES, Finding, in_words, judged
from cohelm.evaluation.benches.paper_table3 import (
    COLUMNS,
    CUT,
    ENOUGH_CELLS,
    METHODS,
    TABLE3,
    WHOLE,
    Cell,
    Column,
    cells,
    median,
    values_of,
)
from cohelm.evaluation.benches.rides_report import faults, groups_of, sources
from cohelm.evaluation.benches.rides_verdicts import ENOUGH, OURS, broken, few
from cohelm.evaluation.results import PaperTable, write_results
from cohelm.evaluation.results.rides import Rides

SLOW = "as the paper's means"
"""The pace of the first table: the one speed that is chosen for all scenes."""
SENSED = f"{OURS}, sensors"
"""Ours with people as its sensors find them."""

_DEFINITIONS = (
    "distances are from surface to surface; time to the first entry into 0.2 m of the goal; the "
    "length is counted on to the goal point; variances are of the ride until that entry",
    "medians with 95 % bootstrap intervals over the seeds, and the worst; the gap is that of all "
    "rides, the rest that of those that arrived; start and goal are 10.00 m apart",
    "the paper's rows are of scenes without coordinates: its chair, people, walls and "
    "definitions differ from ours, and our gate brakes for people whichever planner drives",
)

Groups = Mapping[str, Mapping[str, Rides]]


def make_report(results: Sequence[Result], folder: Path, title: str) -> Report:
    """Tables for each pace, the verdicts on ours, the claims at the chosen speed, and pictures."""
    rows = [result.row for result in results]
    by_pace = {
        pace: groups_of([row for row in rows if row["pace"] == pace])
        for pace in dict.fromkeys(row["pace"] for row in rows)
    }
    sheets = []
    for pace, groups in by_pace.items():
        sheets += [scene_sheet(f"{pace}, {scene}", scene, groups[scene]) for scene in groups]
    slow = by_pace.get(SLOW, {})
    if slow:
        sheets += [
            scene_sheet(f"{SLOW}, length cut, {scene}", scene, slow[scene], CUT) for scene in slow
        ]
        sheets += [cell_sheet(slow)]
    found = list(judged(slow)) if slow else []
    says = verdicts(by_pace)
    report = Report(
        sheets=tuple(sheets),
        notes=(
            *_DEFINITIONS,
            *sources(rows),
            *faults(rows),
            *_few(by_pace),
            *says,
            *(in_words(*each) for each in found),
            *_tally([finding for _, finding in found]),
        ),
        summary={
            "cells": {pace: _cells_of(groups) for pace, groups in by_pace.items()},
            "verdicts": says,
            "claims": [
                {"says": claim.says, "verdict": finding.verdict, "evidence": finding.evidence}
                for claim, finding in found
            ],
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
    )
    written = write_results(
        results,
        folder,
        by=("pace", "scene", "planner"),
        title=title,
        base=OURS if any(row["planner"] == OURS for row in rows) else None,
        measures=("reached", "hit_moving", "hit_wall", *(each.key for each in COLUMNS)),
        paper=_paper(by_pace),
        report=report,
        limitations=_DEFINITIONS,
    )
    return replace(report, files=written)


def _paper(paces: Iterable[str]) -> PaperTable:
    """The paper's rows, which are the same at every pace."""
    rows: dict[tuple[str, ...], dict[str, float]] = {
        (pace, scene, planner): dict(zip((each.key for each in COLUMNS), figures, strict=True))
        for pace in paces
        for scene, by_planner in TABLE3.items()
        for planner, figures in by_planner.items()
    }
    return PaperTable("Xu et al., Table 3", rows)


def scene_sheet(
    title: str, scene: str, by_planner: Mapping[str, Rides], columns: Sequence[Column] = COLUMNS
) -> Sheet:
    """A line for each planner, and the paper's below them."""
    rows = [
        (
            name,
            str(len(group)),
            str(int(group.reached.sum())),
            str(int(group.touched.sum())),
            *(_median_and_worst(group, column) for column in columns),
        )
        for name, group in by_planner.items()
    ]
    for name, figures in TABLE3.get(scene, {}).items():
        hit = "yes" if figures[0] == 0.0 else "no"
        printed = [f"{each:.5g}" for each in figures]
        rows.append((f"paper: {METHODS[name]}", "–", "–", hit, *printed))
    return Sheet(
        title=f"{title}: median [95 % interval]; worst",
        columns=("planner", "rides", "reached", "hit", *(each.head for each in columns)),
        rows=tuple(rows),
    )


def cell_sheet(groups: Groups) -> Sheet:
    """Ours beside the paper's own row, cell by cell, with people known either way."""
    rows = []
    mine = {name: _rides_of(groups, name) for name in (OURS, SENSED)}
    told, sensed = (cells(mine[name]) for name in (OURS, SENSED))
    by_sense = {(cell.scene, cell.column.key): cell for cell in sensed}
    for cell in told:
        digits = cell.column.digits
        other = by_sense.get((cell.scene, cell.column.key))
        rows.append(
            (
                f"{cell.scene}, {cell.column.head}",
                f"{cell.paper:.5g}",
                f"{cell.ours:.{digits}f}",
                "better" if cell.won else "LOST",
                f"{other.ours:.{digits}f}" if other else "–",
                ("better" if other.won else "LOST") if other else "–",
            )
        )
    return Sheet(
        title=f"{SLOW}: {OURS} beside the paper's own row",
        columns=("cell", "paper", "true people", "", "sensors", ""),
        rows=tuple(rows),
    )


def verdicts(by_pace: Mapping[str, Groups]) -> list[str]:
    """Of ours: collisions, arrivals, cells won, each lost one by its name."""
    out = []
    for pace, groups in by_pace.items():
        for name in (OURS, SENSED):
            rides = _rides_of(groups, name)
            if not rides:
                continue
            where = f"{pace}, {name}"
            judged_here = pace == SLOW and name == OURS
            out += _safety(where, list(rides.values()), judge=judged_here)
            out.append(_won(where, cells(rides), judge=judged_here))
            if pace == SLOW:
                for columns, change in ((CUT, "length cut"), (WHOLE, "variances of whole rides")):
                    out.append(_won(f"{where}, {change}", cells(rides, columns), judge=False))
    return out


def _safety(where: str, groups: Sequence[Rides], *, judge: bool) -> list[str]:
    hits = np.concatenate([group.touched for group in groups])
    reached = np.concatenate([group.reached for group in groups])
    standing = sum(int((group.column("standing_contacts") > 0).sum()) for group in groups)
    missed = hits.any() or any(group.broke_off.any() for group in groups)
    text = f"{where}: collisions in {int(hits.sum())} of {len(hits)} rides{broken(*groups)}"
    said = text + (f", none asked: {'MISSED' if missed else 'met'}" if judge else "")
    return [
        said,
        f"{where}: {int(reached.sum())} of {len(reached)} reached; people walked into the standing "
        f"chair in {standing}",
    ]


def _won(where: str, found: Sequence[Cell], *, judge: bool) -> str:
    lost = [str(cell) for cell in found if not cell.won]
    won = len(found) - len(lost)
    text = f"{where}: better than the paper's own row in {won} of {len(found)} cells"
    if judge:
        text += f", {ENOUGH_CELLS} of 15 asked: {'met' if won >= ENOUGH_CELLS else 'MISSED'}"
    return f"{text}; lost: {'; '.join(lost) or 'none'}"


def _few(by_pace: Mapping[str, Groups]) -> list[str]:
    counts = [
        len(g) for groups in by_pace.values() for each in groups.values() for g in each.values()
    ]
    fewest = min(counts, default=0)
    return [] if fewest >= ENOUGH else [f"{few(fewest)}: what follows is no finding"]


def _tally(found: Sequence[Finding]) -> list[str]:
    if not found:
        return []
    agree = sum(finding.verdict == AGREES for finding in found)
    return [f"of {len(found)} claims of the paper, {agree} are so here"]


def _cells_of(groups: Groups) -> dict[str, list[dict[str, Any]]]:
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


def _rides_of(groups: Groups, name: str) -> dict[str, Rides]:
    return {scene: each[name] for scene, each in groups.items() if name in each}


def _median_and_worst(group: Rides, column: Column) -> str:
    found = median(group, column)
    if not found.count:
        return "–"
    worst = column.worst(values_of(group, column))
    return f"{found:.{column.digits}f}; {worst:.{column.digits}f}"
