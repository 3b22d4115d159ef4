"""Files that every benchmark of rides writes, in the same form."""

from __future__ import annotations

import logging
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from cohelm.errors import ConfigError
from cohelm.evaluation.metrics.measures import REPORTED
from cohelm.evaluation.report.figures import draw
from cohelm.evaluation.report.html import Table, render
from cohelm.evaluation.report.ratings import read_ratings, with_ratings
from cohelm.evaluation.report.rides import Rides
from cohelm.evaluation.report.store import has_arrow, part_of, write_episodes
from cohelm.evaluation.report.summary import baseline, write_summary
from cohelm.evaluation.report.tables import PaperTable, all_tables, proxies, ratings
from cohelm.evaluation.sweeps.store import EPISODES
from cohelm.evaluation.sweeps.tasks import Result

_LOG = logging.getLogger("cohelm.results")
SUMMARY, PAGE = "summary.csv", "report.html"
LIMITATIONS = (
    "These are simulated rides: no person was carried, and people are simulated pedestrians.",
    "Times, lengths and heading changes are of rides that reached the goal; where groups differ in "
    "their share of such rides, differences are of the pairs in which both did.",
    "A p-value is the probability of such a difference by chance; it does not say that the "
    "difference matters. Tables of different cases are corrected separately.",
)
"""Limitations of every comparison of simulated rides."""
_VERDICT = re.compile(r"(?<=: )(met|MISSED|agrees|does not agree)(?=;|$)")
_GOOD = frozenset({"met", "agrees"})


@dataclass(frozen=True)
class Sheet:
    """Table of a benchmark for people."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]

    @property
    def table(self) -> Table:
        """Table for an HTML report."""
        return Table(self.columns, self.rows)


@dataclass(frozen=True)
class BenchReport:
    """Results of a benchmark in tables, sentences and plain data."""

    sheets: tuple[Sheet, ...]
    notes: tuple[str, ...]
    """Sentences: claims that were met or missed, and what could not be run."""
    summary: Mapping[str, Any]
    """The same as plain data."""
    files: tuple[Path, ...] = ()
    """Files that were written besides the rows."""


class ReportNote(NamedTuple):
    """Sentence of a report with its verdict."""

    before: str
    verdict: str = ""
    after: str = ""

    @property
    def css(self) -> str:
        """Class of the verdict."""
        return "good" if self.verdict in _GOOD else "bad"


class ProgramErrors(NamedTuple):
    """Rides that ended with the same program error."""

    title: str
    command: str
    traceback: str


def write_results(
    results: Sequence[Result],
    folder: Path,
    *,
    by: Sequence[str] = ("scene", "planner"),
    title: str = "",
    base: str | None = None,
    measures: Sequence[str] = REPORTED,
    paper: PaperTable | None = None,
    report: BenchReport | None = None,
    limitations: Sequence[str] = (),
    panels: bool = True,
    say: Callable[[str], None] = _LOG.info,
) -> tuple[Path, ...]:
    """Write ``episodes.parquet``, ``summary.csv`` and ``report.html`` of any number of rides.

    Args:
        results: rows of :func:`~cohelm.evaluation.sweeps.ride_task.ride_row` in order, with the
            curve ``series`` where there is one. Rides may be missing or have failed.
        folder: existing folder that can be written to.
        by: compared columns: the last one names the contenders, which are compared on equal seeds
            in each case of those before it.
        title: title of the report.
        base: baseline; None: the first contender in the rows.
        measures: columns of the report's tables; the files have all measures.
        paper: values of a paper for the same cases.
        report: tables and sentences of the benchmark.
        limitations: limitations of this benchmark; those of all simulations are added.
        panels: draw box plots, tracks and curves.
        say: receives progress messages; by default the log ``cohelm.results``.

    Returns:
        Files that were written. ``episodes.parquet`` needs pyarrow.

    Raises:
        OSError: if a file cannot be written.
    """
    rides, problems = _with_ratings(results, by, folder)
    if not len(rides):
        return ()
    chosen = baseline(rides, base)
    table = [folder / EPISODES] if has_arrow() else []
    for file in table:
        write_episodes(rides, file)
    say(f"summing up {len(rides)} rides")
    write_summary(rides, chosen, folder / SUMMARY)
    content = report or BenchReport(sheets=(), notes=(), summary={})
    page = render(
        "report.html",
        title=title or folder.name,
        part=part_of(len(rides), folder),
        summary=_counts(rides),
        notes=[note_of(each) for each in (*content.notes, *problems) if each not in limitations],
        cases=all_tables(rides, chosen, measures, paper or PaperTable("", {})),
        drawn=draw(rides, chosen, say) if panels else None,
        ratings=ratings(rides),
        proxies=proxies(rides),
        sheets=[each for each in content.sheets if each.rows],
        errors=_errors(rides),
        limitations=[*limitations, *LIMITATIONS],
    )
    (folder / PAGE).write_text(page, encoding="utf-8")
    return (*table, folder / SUMMARY, folder / PAGE)


def note_of(sentence: str) -> ReportNote:
    """Sentence with its verdict, if it has one, apart."""
    return ReportNote(*_VERDICT.split(sentence, maxsplit=1))


def _with_ratings(
    results: Sequence[Result], by: Sequence[str], folder: Path
) -> tuple[Rides, Sequence[str]]:
    """Rides with their ratings, and a sentence if the ratings cannot be read."""
    curves = [result.arrays.get("series") for result in results]
    rides = Rides([result.row for result in results], by, curves)
    try:
        return with_ratings(rides, read_ratings(folder)), ()
    except ConfigError as cause:
        return rides, (f"no ratings: {cause}",)


def _counts(rides: Rides) -> str:
    seeds = sorted(set(rides.seeds))
    versions = sorted({str(row["version"]) for row in rides if row.get("version")})
    made = f"; cohelm {', '.join(versions)}" if versions else ""
    span = f"seeds {seeds[0]} to {seeds[-1]}" if len(seeds) > 1 else f"seed {seeds[0]}"
    return (
        f"{_count(len(rides), 'ride')}: {_count(len(rides.contenders), rides.by[-1])} in "
        f"{_count(len(rides.cases), 'case')}, {span}{made}"
    )


def _count(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _errors(rides: Rides) -> list[ProgramErrors]:
    """Each program error once, with its traceback and a command that repeats it."""
    found: dict[str, list[int]] = {}
    for i, row in enumerate(rides.rows):
        if row.get("outcome") == "error":
            found.setdefault(str(row.get("error") or "no message"), []).append(i)
    out = []
    for error, at in found.items():
        row = rides.rows[at[0]]
        command, traceback = str(row.get("replay") or ""), str(row.get("traceback") or "")
        out.append(ProgramErrors(f"{len(at)} × {error}", command, traceback))
    return out
