"""Report of a benchmark of rides: tables, differences on equal seeds, verdicts, the HTML page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cohelm.benchmarks.bench import BenchReport, Result, Sheet
from cohelm.benchmarks.claims import (
    OURS,
    Verdict,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.ride_claims import (
    Claim,
    Groups,
    Requirement,
    few_rides,
    judge,
)
from cohelm.benchmarks.tables import difference_table, figures, group_table, groups_of
from cohelm.errors import ConfigError
from cohelm.evaluation.metrics.measures import REPORTED
from cohelm.evaluation.report import PaperTable, write_results
from cohelm.evaluation.report.rides import Rides, Row
from cohelm.plotting import Strip, StripPanel, draw_strips

CASE = "case"
"""Column of the compared columns but the last, joined."""
MEASURES = (
    "reached", "person_collision", "collision_speed", "wall_collision", "standing_contact",
    "time", "time_ratio", "min_distance", "solve_median_ms", "solve_p99_ms",
)  # fmt: skip
COMPARED = ("reached", "person_collision", "time", "min_distance", "stalled_time")


@dataclass(frozen=True)
class ReportSpec:
    """Contents of a report."""

    title: str
    claims: tuple[Claim, ...] = ()
    measures: tuple[str, ...] = MEASURES
    """Columns of the tables."""
    compared: tuple[str, ...] = COMPARED
    """Columns of the differences from the base."""
    page: tuple[str, ...] = REPORTED
    """Columns of the HTML page."""
    by: tuple[str, ...] = ("scene", "planner")
    """Columns that distinguish rides; the last one is compared."""
    base: str = OURS
    limitations: tuple[str, ...] = ()
    """Sentences about what the figures do not show."""
    picture: str = ""
    """File for a picture of every ride; empty: none."""
    paper: PaperTable | None = None


@dataclass(frozen=True)
class Findings:
    """Parts of a report that are particular to a benchmark."""

    sheets: tuple[Sheet, ...]
    notes: tuple[str, ...] = ()
    summary: Mapping[str, Any] | None = None
    verdicts: tuple[Verdict, ...] = ()
    """Beside those on the claims."""


def ride_report(results: Sequence[Result], folder: Path, spec: ReportSpec) -> BenchReport:
    """Tables and differences scene by scene, the verdicts, and the files of all benchmarks."""
    cases = [
        {**each.row, CASE: ", ".join(str(each.row[column]) for column in spec.by[:-1])}
        for each in results
    ]
    groups = groups_of(cases, CASE, spec.by[-1])
    sheets: list[Sheet] = []
    for scene, by_planner in groups.items():
        sheets += [
            group_table(scene, by_planner, spec.measures, spec.by[-1]),
            difference_table(scene, by_planner, spec.base, spec.compared, spec.by[-1]),
        ]
    scenes = {scene: figures(each, spec.measures) for scene, each in groups.items()}
    found = Findings(tuple(sheets), summary={"scenes": scenes})
    return finish(results, folder, spec, found, groups)


def finish(
    results: Sequence[Result], folder: Path, spec: ReportSpec, found: Findings, groups: Groups
) -> BenchReport:
    """Complete a report by verdicts, notes on the data, pictures and the HTML page.

    Args:
        results: one per ride.
        folder: to write to.
        spec: contents.
        found: tables and sentences of the benchmark.
        groups: rides on which the claims are judged, and which the picture shows.
    """
    rows = [result.row for result in results]
    check_apart(rows, spec.by)
    verdicts = [*found.verdicts, *judge(spec.claims, groups)]
    report = BenchReport(
        sheets=(*found.sheets, *([verdict_sheet(verdicts)] if verdicts else [])),
        notes=(
            *sources(rows),
            *faults(rows, spec.by),
            *(few_rides(groups) if spec.claims else ()),
            *not_ridden(spec.claims, groups),
            *found.notes,
            *verdict_notes(verdicts),
        ),
        summary={
            **(found.summary or {}),
            "verdicts": verdict_summary(verdicts),
            "seeds": sorted({int(row["seed"]) for row in rows}),
        },
    )
    files = [picture(groups, folder / spec.picture)] if spec.picture else []
    written = write_results(
        results, folder, by=spec.by, title=spec.title, base=spec.base, measures=spec.page,
        paper=spec.paper, report=report, limitations=spec.limitations,
    )  # fmt: skip
    return BenchReport(report.sheets, report.notes, report.summary, (*files, *written))


def check_apart(rows: Sequence[Row], by: Sequence[str]) -> None:
    """Check that the compared columns and the seed tell all rides apart.

    Raises:
        ConfigError: if not: differences would take one of them for all.
    """
    seen: set[tuple[Any, ...]] = set()
    for row in rows:
        ride = (*(row[column] for column in by), row["seed"])
        if ride in seen:
            raise ConfigError(
                f"two rides are {', '.join(map(str, ride[:-1]))}, seed {ride[-1]}",
                key="ReportSpec.by",
            )
        seen.add(ride)


def not_ridden(claims: Sequence[Claim], groups: Groups) -> tuple[str, ...]:
    """Sentence on claims about contenders that did not ride; statements of papers say so alone."""
    ridden = {name for case in groups.values() for name in case}
    missing = [
        each.contender
        for each in claims
        if isinstance(each, Requirement) and not each.source and each.contender not in ridden
    ]
    names = ", ".join(dict.fromkeys(missing))
    return (f"{len(missing)} claims are not judged: {names} did not ride",) if missing else ()


def sources(rows: Sequence[Row]) -> tuple[str, ...]:
    """Source of the people in the rides: sensors or simulation."""
    known = sorted({row["people_source"] for row in rows if row["people_source"]})
    return (f"people known from: {', '.join(known)}",) if known else ()


def faults(rows: Sequence[Row], by: Sequence[str]) -> tuple[str, ...]:
    """Rides that a program error ended, each error once."""
    found: dict[tuple[str, str], list[int]] = {}
    for row in rows:
        if row["error"]:
            name = ", ".join(str(row[key]) for key in by[1:])
            found.setdefault((name, row["error"]), []).append(int(row["seed"]))
    return tuple(
        f"{name} ended by an error in {len(seeds)} rides, first seed {min(seeds)}: {error}"
        for (name, error), seeds in found.items()
    )


def picture(groups: Groups, file: Path) -> Path:
    """Draw minimum distance and time ratio of every ride, one row of panels per scene."""

    def panel(scene: str, key: str, axis: str) -> StripPanel:
        strips = {
            name: Strip(values=rides.column(key), bad=~rides.reached)
            for name, rides in groups[scene].items()
        }
        return StripPanel(title=scene, axis=axis, strips=strips)

    shown = (
        ("min_distance", "minimum distance to a person, m"),
        ("time_ratio", "time ratio to empty floor"),
    )
    draw_strips(
        [[panel(scene, *each) for each in shown] for scene in groups], file, "goal not reached"
    )
    return file


def rides_by(rides: Rides, key: str) -> dict[str, Rides]:
    """Value of a column → its rides, in the order of the rows."""
    return {name: rides.only(**{key: name}) for name in dict.fromkeys(r[key] for r in rides.rows)}
