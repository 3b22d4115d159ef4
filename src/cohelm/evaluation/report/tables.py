"""Tables of a report: groups side by side, differences from the baseline, values of a paper."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from cohelm.evaluation.metrics.measures import PROXIES, RideMeasure, measure_info
from cohelm.evaluation.report.html import Content, Table, TableCell
from cohelm.evaluation.report.rides import Key, Rides
from cohelm.evaluation.report.statistics import Contrast, Estimate, bootstrap_mean
from cohelm.evaluation.report.summary import case_name, centre, contrasts

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
