"""``summary.csv``: every measure of every group, and how it stands beside the base."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.bootstrap import Estimate, mean_of, median_of, share
from cohelm.evaluation.results.contrasts import Contrast, contrast, corrected
from cohelm.evaluation.results.measures import Measure, measure
from cohelm.evaluation.results.rides import Key, Rides, measures_of, number

COLUMNS = (
    "measure", "unit", "rides", "count", "value", "low", "high", "mean", "mean_low", "mean_high",
    "min", "p25", "p75", "max", "base", "pairs", "less", "less_low", "less_high", "p", "p_holm",
    "verdict",
)  # fmt: skip
"""After those that say what was compared. ``value`` is the share of rides, or the median."""


def centre(rides: Rides, name: str, how: Measure) -> Estimate:
    """Share of the rides with its Wilson interval, or the median with its bootstrap interval."""
    values = rides.column(name)
    if how.share:
        return share(values > 0.0)
    return median_of(values)


def contrasts(
    by_name: Mapping[str, Rides], base: str, names: Sequence[str]
) -> dict[tuple[str, str], Contrast]:
    """(contender, measure) → it less the base on equal cases and seeds.

    The p-values of a measure are corrected for all contenders it was tested for. Riders of one
    scene and seed count as one.
    """
    if base not in by_name:
        return {}
    others = [name for name in by_name if name != base]
    found: dict[tuple[str, str], Contrast] = {}
    for name in names:
        how, row = measure(name), []
        for other in others:
            one, two = by_name[other], by_name[base]
            i, j = one.pairs(two)
            units = one.units(i)
            row.append(contrast(one.column(name)[i], two.column(name)[j], how, units))
        found |= {(other, name): each for other, each in zip(others, corrected(row), strict=True)}
    return found


def summary_rows(rides: Rides, base: str) -> list[dict[str, Any]]:
    """A row for every case, contender and measure."""
    names = measures_of(rides)
    out = []
    for case, by_name in rides.split().items():
        less = contrasts(by_name, base, names)
        for contender, group in by_name.items():
            key = dict(zip(rides.by, (*case, contender), strict=True))
            out += [
                {**key, **_figures(group, name), **_beside(less.get((contender, name)), base)}
                for name in names
            ]
    return out


def write_summary(rides: Rides, base: str, file: Path) -> None:
    """Write ``summary.csv``; an empty cell: there is no such value.

    Raises:
        OSError: if the file cannot be written.
    """
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        columns = (*rides.by, *COLUMNS)
        writer.writerow(columns)
        for row in summary_rows(rides, base):
            writer.writerow([_cell(row.get(key)) for key in columns])


def _figures(group: Rides, name: str) -> dict[str, Any]:
    how, values = measure(name), group.column(name)
    there = values[np.isfinite(values)]
    middle, mean = centre(group, name, how), mean_of(values)
    spread = np.percentile(there, [0, 25, 75, 100]) if len(there) else np.full(4, math.nan)
    return {
        "measure": name,
        "unit": how.unit,
        "rides": len(group),
        "count": len(there),
        "value": middle.mean,
        "low": middle.low,
        "high": middle.high,
        "mean": mean.mean,
        "mean_low": mean.low,
        "mean_high": mean.high,
        **dict(zip(("min", "p25", "p75", "max"), spread.tolist(), strict=True)),
    }


def _beside(found: Contrast | None, base: str) -> dict[str, Any]:
    if found is None:
        return {}
    return {
        "base": base,
        "pairs": found.less.count,
        "less": found.less.mean,
        "less_low": found.less.low,
        "less_high": found.less.high,
        "p": found.p,
        "p_holm": found.corrected,
        "verdict": found.verdict,
    }


def _cell(content: Any) -> Any:
    if isinstance(content, float):
        return f"{content:.6g}" if math.isfinite(content) else ""
    return "" if content is None else content


def base_of(rides: Rides, wanted: str | None) -> str:
    """What the others are compared with: what is wanted, else the first there is."""
    contenders = rides.contenders
    return wanted if wanted in contenders else (contenders[0] if contenders else "")


def case_name(case: Key, by: Sequence[str]) -> str:
    """A case in words: its values, parted by commas; those that are no words with their name."""
    return ", ".join(_told(name, each) for name, each in zip(by[:-1], case, strict=True))


def _told(name: str, content: str) -> str:
    if not content:
        return f"no {name}"
    bare = "." in name or content in {"true", "false"} or not math.isnan(number(content))
    return f"{name}={content}" if bare else content
