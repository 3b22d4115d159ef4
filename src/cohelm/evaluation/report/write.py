"""Files that every benchmark of rides writes, in the same form.

The page shows tables (groups side by side, differences from the baseline, values of a paper) and
drawings (box plots of the measures, tracks, curves over time).
"""

from __future__ import annotations

import logging
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup

from cohelm.arrays import Floats
from cohelm.errors import CohelmError, ConfigError
from cohelm.evaluation.metrics.measures import PROXIES, REPORTED, RideMeasure, measure_info
from cohelm.evaluation.report.html import Content, Table, TableCell, render
from cohelm.evaluation.report.ratings import read_ratings, with_ratings
from cohelm.evaluation.report.rides import Key, Rides
from cohelm.evaluation.report.statistics import Contrast, Estimate, bootstrap_mean
from cohelm.evaluation.report.store import has_arrow, part_of, write_episodes
from cohelm.evaluation.report.summary import baseline, case_name, centre, contrasts, write_summary
from cohelm.evaluation.sweeps.ride_task import RideTask
from cohelm.evaluation.sweeps.store import EPISODES
from cohelm.evaluation.sweeps.tasks import Result
from cohelm.plotting import panels
from cohelm.scenarios.build import RideSetup, build_scenario

UNFOLDED = 12
"""Number of cases above which their tables are folded."""
_ARROWS = {1: "\N{NO-BREAK SPACE}↑", -1: "\N{NO-BREAK SPACE}↓", 0: ""}


@dataclass(frozen=True)
class PaperTable:
    """Values that a paper reports for the same cases."""

    source: str
    """Paper and table: ``Xu et al., Table 3``."""
    rows: Mapping[Key, Mapping[str, float]]
    """Values of all compared columns → measure → value."""


@dataclass(frozen=True)
class CaseTables:
    """Tables of one case."""

    title: str
    tables: tuple[Table, ...]
    is_folded: bool = False


def all_tables(
    rides: Rides, base: str, measures: Sequence[str], paper: PaperTable
) -> list[CaseTables]:
    """Tables of all cases together where there are several, then of each case."""
    split = rides.split()
    out = []
    if len(split) > 1:
        tables = case_tables(rides.by_contender(), base, measures, PaperTable("", {}))
        out.append(CaseTables(f"all {len(split)} cases", tables))
    for case, by_name in split.items():
        theirs = {key[-1:]: row for key, row in paper.rows.items() if key[:-1] == case}
        tables = case_tables(by_name, base, measures, PaperTable(paper.source, theirs))
        title = case_name(case, rides.by) or "all rides"
        out.append(CaseTables(title, tables, is_folded=len(split) > UNFOLDED))
    return out


def case_tables(
    by_name: Mapping[str, Rides], base: str, measures: Sequence[str], paper: PaperTable
) -> tuple[Table, ...]:
    """Groups of one case, and their differences from the baseline.

    Args:
        by_name: contender → rides.
        base: baseline.
        measures: columns; those without any value are left out.
        paper: values of a paper by (contender,).
    """
    names = [
        name
        for name in measures
        if any(each.has(name) for each in by_name.values())
        or any(name in row for row in paper.rows.values())
    ]
    tables = (_groups(by_name, names, paper), differences(by_name, base, names))
    return tuple(each for each in tables if each is not None)


def differences(by_name: Mapping[str, Rides], base: str, names: Sequence[str]) -> Table | None:
    """Difference of each group from the baseline on equal seeds; None without other groups."""
    found = contrasts(by_name, base, names)
    others = [name for name in by_name if name != base]
    if not found or not others:
        return None
    rows: list[list[Content]] = []
    for name in others:
        pairs = len(by_name[name].pairs(by_name[base])[0])
        cells = [_contrast(found[name, key], measure_info(key)) for key in names]
        rows.append([name, str(pairs), *cells])
    caption = (
        f"difference from {base} on equal seeds: mean [95 % bootstrap interval], p by signed ranks "
        "(shares of rides: McNemar), corrected after Holm for all rows of a column"
    )
    if by_name[base].has_shared_draws:
        caption += "; the riders of one case and seed count as one, with their mean"
    some = next(iter(by_name.values()))
    return Table([some.by[-1], "pairs", *_headings(names)], rows, caption)


def proxies(rides: Rides) -> Table | None:
    """Rider proxies over all cases; None where no rider had a stick."""
    names = [name for name in PROXIES if rides.has(name)]
    if not any(name != "authority" for name in names):  # it is 0 without a device
        return None
    rows = [_group(name, group, names) for name, group in rides.by_contender().items()]
    caption = "median [95 % interval], all cases"
    return Table([rides.by[-1], "rides", *_headings(names)], rows, caption)


def ratings(rides: Rides) -> Table | None:
    """Ratings by people, 1 to 5; None without any."""
    if not rides.has("rating"):
        return None
    rows: list[list[Content]] = []
    for name, group in rides.by_contender().items():
        given = group.column("rating")
        given = given[np.isfinite(given)]
        if len(given):
            cell = _estimate(bootstrap_mean(given), measure_info("rating"))
            rows.append([name, str(len(given)), cell])
    return Table([rides.by[-1], "rides rated", "mean [95 % interval]"], rows)


def _groups(by_name: Mapping[str, Rides], names: Sequence[str], paper: PaperTable) -> Table:
    rows: list[list[Content]] = []
    emphasised = set()

    def add_paper(name: str) -> None:
        row = paper.rows.get((name,))
        if row is not None:
            emphasised.add(len(rows))
            cells = [measure_info(key).text(row.get(key, math.nan)) for key in names]
            rows.append([f"{name}, paper", "", *cells])

    for name, group in by_name.items():
        rows.append(_group(name, group, names))
        add_paper(name)
    for (name,) in paper.rows:
        if name not in by_name:
            add_paper(name)
    caption = "share of rides [95 % score interval] or median [95 % bootstrap interval]"
    if paper.rows:
        caption += f"; in italics: {paper.source}"
    some = next(iter(by_name.values()))
    columns = [some.by[-1], "rides", *_headings(names)]
    return Table(columns, rows, caption, frozenset(emphasised))


def _group(name: str, group: Rides, names: Sequence[str]) -> list[Content]:
    cells = [_estimate(centre(group, key), measure_info(key)) for key in names]
    return [name, str(len(group)), *cells]


def _headings(names: Sequence[str]) -> list[str]:
    infos = [measure_info(name) for name in names]
    return [each.heading + _ARROWS[each.better] for each in infos]


def _estimate(each: Estimate, info: RideMeasure) -> Content:
    if not each.count:
        return "–"
    return TableCell(info.text(each.mean), (f"[{info.text(each.low)}, {info.text(each.high)}]",))


def _contrast(each: Contrast, info: RideMeasure) -> Content:
    found = each.difference
    if not found.count:
        return "–"
    sign = "+" if found.mean > 0.0 else ""
    return TableCell(
        f"{sign}{info.text(found.mean)} {each.verdict}".strip(),
        (
            f"[{info.text(found.low)}, {info.text(found.high)}]",
            "" if math.isnan(each.corrected) else f"p {_p(each.corrected)}",
        ),
        {"better": "good", "worse": "bad"}.get(each.verdict, ""),
    )


def _p(p: float) -> str:
    """``< .001``, ``= .03``."""
    return "< .001" if p < 0.001 else f"= {p:.2g}".replace("0.", ".")


CASES = 6
"""Largest number of cases that are drawn; tables and files have all."""
BOXED = ("time", "time_ratio", "min_distance", "path_length")
"""Measures with box plots."""
GAP = 6
"""Column of the gap to the nearest person in a curve."""
CURVES: Mapping[str, tuple[int, float | None]] = {
    "speed, m/s": (4, None),
    "turn rate, rad/s": (5, None),
    "nearest person, m": (GAP, 6.0),
}
"""Curves over time (Xu et al., Figs 14b, d, f): column, and upper limit of the axis."""

Say = Callable[[str], None]
Styles = Mapping[str, panels.Look]


@dataclass(frozen=True)
class ReportFigure:
    """SVG or image of a report."""

    content: Markup
    caption: str = ""
    is_map: bool = False


@dataclass(frozen=True)
class Drawings:
    """All drawings of a report."""

    styles: Sequence[tuple[str, Markup]]
    """Contender and a sample of its line and mark."""
    selection: str
    seeds: str
    boxes: list[list[ReportFigure]] = field(default_factory=list)
    tracks: list[ReportFigure] = field(default_factory=list)
    curves: list[ReportFigure] = field(default_factory=list)


def draw(rides: Rides, base: str, say: Say) -> Drawings:
    """Draw box plots, tracks and curves of all contenders."""
    styles = {name: panels.look(i) for i, name in enumerate(rides.contenders)}
    split = rides.split()
    cases = evenly(list(split), CASES)
    some = "" if len(cases) == len(split) else f"{len(cases)} of the {len(split)} cases are drawn."
    out = Drawings(
        styles=[(name, Markup(panels.sample(each))) for name, each in styles.items()],
        selection=some,
        seeds=f"{some} In each case the seed on which {base} took its median time.".strip(),
    )
    say(f"drawing {len(cases)} of {len(split)} cases")
    if len(split) > 1:
        out.boxes.append(_boxes("all cases", rides.by_contender(), styles))
    for case in cases:
        name = case_name(case, rides.by) or "all rides"
        out.boxes.append(_boxes(name, split[case], styles))
        shown = typical(split[case], base)
        if shown:
            seed = next(iter(shown.values())).seeds[0]
            out.tracks.append(_tracks(f"{name}, seed {seed}", shown, styles))
            out.curves.extend(_curves(f"{name}, seed {seed}", shown, styles))
    return out


def evenly(cases: Sequence[Key], most: int) -> list[Key]:
    """At most ``most`` cases, evenly spaced, with the first and the last one."""
    if len(cases) <= most:
        return list(cases)
    return [cases[i] for i in np.linspace(0, len(cases) - 1, most).astype(int)]


def typical(by_name: Mapping[str, Rides], base: str) -> dict[str, Rides]:
    """Contender → its ride, with a curve, on the seed of the baseline's median time.

    The seed is one of those that most contenders rode; the others are left out.
    """
    with_curve = {
        name: {row["seed"]: i for i, row in enumerate(each.rows) if each.curves[i] is not None}
        for name, each in by_name.items()
    }
    count: dict[int, int] = {}
    for seeds in with_curve.values():
        for seed in seeds:
            count[seed] = count.get(seed, 0) + 1
    if not count:
        return {}
    fullest = max(count.values())
    lead = base if with_curve.get(base) else max(with_curve, key=lambda n: len(with_curve[n]))
    time = by_name[lead].column("time")
    at = [(s, time[i]) for s, i in with_curve[lead].items() if count[s] == fullest]
    at = at or [(seed, np.nan) for seed, n in count.items() if n == fullest]
    ordered = sorted(at, key=lambda each: (np.isnan(each[1]), each[1], each[0]))
    there = sum(bool(np.isfinite(each[1])) for each in ordered)
    seed = ordered[(there - 1) // 2 if there else 0][0]
    return {
        name: by_name[name].take([seeds[seed]])
        for name, seeds in with_curve.items()
        if seed in seeds
    }


def _setup_of(ride: Rides) -> RideSetup | None:
    """Setup of the first ride; None where its row does not define it."""
    task = RideTask.from_row(ride.rows[0])
    try:
        return None if task is None else build_scenario(task.load(), task.seed)
    except (CohelmError, OSError):
        return None


def _boxes(title: str, by_name: Mapping[str, Rides], styles: Styles) -> list[ReportFigure]:
    figures = []
    for key in BOXED:
        if not any(each.has(key) for each in by_name.values()):
            continue
        values = {
            name: panels.Values(styles[name], each.column(key), each.column("reached") == 0.0)
            for name, each in by_name.items()
        }
        figures.append(_svg(panels.box_panel(title, measure_info(key).heading, values)))
    return figures


def _tracks(title: str, shown: Mapping[str, Rides], styles: Styles) -> ReportFigure:
    curves = {name: (styles[name], curve_of(each)[:, :3]) for name, each in shown.items()}
    setup = _setup_of(next(iter(shown.values())))
    if setup is None:
        return _svg(panels.track_panel(title, curves, None, np.full((2, 2), np.nan)), is_map=True)
    ends = np.array([setup.start[:2], setup.request.goal])
    return _svg(panels.track_panel(title, curves, setup.world.grid, ends), is_map=True)


def _curves(title: str, shown: Mapping[str, Rides], styles: Styles) -> list[ReportFigure]:
    out = []
    for axis, (column, top) in CURVES.items():
        lines = {
            name: (styles[name], curve_of(each)[:, 0], curve_of(each)[:, column])
            for name, each in shown.items()
        }
        if any(np.isfinite(values).any() for _, _, values in lines.values()):
            out.append(_svg(panels.curve_panel(title, axis, lines, top)))
    return out


def curve_of(one: Rides) -> Floats:
    """Curve of one ride, with gaps clipped at 0 as in the measures."""
    if one.curves[0] is None:
        return np.empty((0, 8))
    curve = one.curves[0].copy()
    curve[:, GAP] = curve[:, GAP].clip(min=0.0)
    return curve


def _svg(svg: str, *, is_map: bool = False) -> ReportFigure:
    return ReportFigure(Markup(svg), is_map=is_map)  # drawn here, with escaped text


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
