"""``summary.csv``: each measure of each group, and its difference from the baseline."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.evaluation.metrics.measures import PERCENT, measure_info
from cohelm.evaluation.report.rides import Key, Rides, measures_of, number
from cohelm.evaluation.report.statistics import (
    Contrast,
    Estimate,
    bootstrap_mean,
    bootstrap_median,
    contrast,
    corrected,
    wilson_share,
)

COLUMNS = (
    "measure", "unit", "rides", "count", "value", "low", "high", "mean", "mean_low", "mean_high",
    "min", "p25", "p75", "max", "base", "pairs", "difference", "difference_low",
    "difference_high", "p", "p_holm", "verdict",
)  # fmt: skip
"""Columns after those that are compared. ``value`` is the share of rides, or the median."""


def centre(rides: Rides, name: str) -> Estimate:
    """Share of the rides with its Wilson interval, or the median with its bootstrap interval."""
    values = rides.column(name)
    return wilson_share(values > 0.0) if measure_info(name).of_rides else bootstrap_median(values)


def contrasts(
    by_name: Mapping[str, Rides], base: str, names: Sequence[str]
) -> dict[tuple[str, str], Contrast]:
    """(contender, measure) → its difference from the baseline on equal cases and seeds.

    The p-values of a measure are corrected for all its contenders. Riders of one case and seed
    count as one.
    """
    if base not in by_name:
        return {}
    others = [name for name in by_name if name != base]
    found: dict[tuple[str, str], Contrast] = {}
    for name in names:
        row = []
        for other in others:
            one, two = by_name[other], by_name[base]
            i, j = one.pairs(two)
            values = one.column(name)[i], two.column(name)[j]
            row.append(contrast(*values, measure_info(name), one.units(i)))
        found |= {(other, name): each for other, each in zip(others, corrected(row), strict=True)}
    return found


def write_summary(rides: Rides, base: str, file: Path) -> None:
    """Write ``summary.csv`` with a row for each case, contender and measure.

    An empty cell means that there is no such value.

    Raises:
        OSError: if the file cannot be written.
    """
    names = measures_of(rides)
    with file.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow((*rides.by, *COLUMNS))
        for case, by_name in rides.split().items():
            found = contrasts(by_name, base, names)
            for contender, group in by_name.items():
                for name in names:
                    difference = _difference(found.get((contender, name)), base)
                    row = {**_figures(group, name), **difference}
                    cells = (_cell(row.get(key)) for key in COLUMNS)
                    writer.writerow((*case, contender, *cells))


def baseline(rides: Rides, wanted: str | None) -> str:
    """Contender that the others are compared with: ``wanted``, else the first one."""
    contenders = rides.contenders
    return wanted if wanted in contenders else (contenders[0] if contenders else "")


def case_name(case: Key, by: Sequence[str]) -> str:
    """Values of a case, separated by commas; numbers with the name of their column."""
    return ", ".join(_named(name, each) for name, each in zip(by[:-1], case, strict=True))


def _figures(group: Rides, name: str) -> dict[str, Any]:
    info, values = measure_info(name), group.column(name)
    there = values[np.isfinite(values)]
    middle, mean = centre(group, name), bootstrap_mean(values)
    spread = np.percentile(there, [0, 25, 75, 100]) if len(there) else np.full(4, math.nan)
    return {
        "measure": name,
        "unit": "" if info.of_rides or info.unit == PERCENT else info.unit,
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


def _difference(found: Contrast | None, base: str) -> dict[str, Any]:
    if found is None:
        return {}
    return {
        "base": base,
        "pairs": found.difference.count,
        "difference": found.difference.mean,
        "difference_low": found.difference.low,
        "difference_high": found.difference.high,
        "p": found.p,
        "p_holm": found.corrected,
        "verdict": found.verdict,
    }


def _cell(content: Any) -> Any:
    if isinstance(content, float):
        return f"{content:.6g}" if math.isfinite(content) else ""
    return "" if content is None else content


def _named(name: str, content: str) -> str:
    if not content:
        return f"no {name}"
    bare = "." in name or content in {"true", "false"} or not math.isnan(number(content))
    return f"{name}={content}" if bare else content
