"""Report of lost or not: detections by distance, false alarms, and the curve of both."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy import stats

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import BenchReport, Result, Sheet
from cohelm.evaluation.report.statistics import wilson_share
from cohelm.health import HealthParameters

WITHIN = 2.0
"""Time within which a carry must be detected, s."""
BINS = (0.5, 1.0, 2.0, 5.0, 10.1)
"""Bounds of the distances of a carry, m."""
THRESHOLDS = np.linspace(0.05, 2.5, 50)
"""Scores at which the curve is drawn; 1 is the bound of being lost."""
_APART = 1.0
"""Time between two crossings of a threshold that are two alarms, s."""


class RocPoint(NamedTuple):
    """Point of the curve."""

    threshold: float
    detected: float
    """Share of the carries of 1 m and more that are detected in time."""
    alarms: float
    """False alarms per hour."""


def lost_report(results: Sequence[Result], folder: Path) -> BenchReport:
    """Detections by distance and false alarms of the whole monitor; curve of scan against map."""
    done = [each for each in results if not each.row["error"]]
    carried = [each for each in done if _is_carried(each.row)]
    hours = sum(_sound_time(each.row) for each in done) / 3600.0
    false = [each.row for each in done if _is_false(each.row)]
    curve = roc([each.row for each in done], [each.arrays["series"] for each in done])
    rate = len(false) / hours if hours else math.nan
    high = stats.chi2.ppf(0.975, 2 * len(false) + 2) / 2.0 / hours if hours else math.nan
    far = [each.row for each in carried if float(each.row["distance"]) >= 1.0]
    share = wilson_share(np.array([_delay(row) <= WITHIN for row in far], dtype=bool))
    notes = (
        f"{len(done)} drives on {len({each.row['floor'] for each in done})} floors, "
        f"{len(carried)} of them carried",
        f"carries of 1 m and more detected within {WITHIN:g} s: {share:.3f} of {len(far)}",
        f"false alarms: {len(false)} in {hours:.2f} h, {rate:.2f} an hour, "
        f"at most {high:.2f} (95 %)",
    )
    return BenchReport(
        sheets=(_sheet([each.row for each in carried]),),
        notes=notes,
        summary={
            "drives": len(done),
            "carried": len(carried),
            "detected_1m": share.mean,
            "alarms_per_hour": rate,
            "hours": hours,
            "curve": [point._asdict() for point in curve],
            "false": [f"{row['floor']} {row['seed']}" for row in false],
        },
    )


def roc(rows: Sequence[Mapping[str, Any]], series: Sequence[Floats]) -> list[RocPoint]:
    """Curve of the fit of scan and map, with breaks of the view, over multiples of the bounds."""
    p, out = HealthParameters(), []
    scores = [
        np.max(each[:, 1:] / [p.lost_share, p.lost_offset, p.lost_turn, p.break_fall], axis=1)
        for each in series
    ]
    hours = sum(_sound_time(row) for row in rows) / 3600.0
    for threshold in THRESHOLDS:
        hits, trials, alarms = 0, 0, 0
        for row, each, score in zip(rows, series, scores, strict=True):
            sound = each[:, 0] < (float(row["at"]) if _is_carried(row) else math.inf)
            alarms += _crossings(each[sound, 0], score[sound] >= threshold)
            if _is_carried(row) and float(row["distance"]) >= 1.0:
                trials += 1
                due = ~sound & (each[:, 0] <= float(row["at"]) + WITHIN)
                hits += bool((score[due] >= threshold).any())
        out.append(
            RocPoint(float(threshold), hits / max(trials, 1), alarms / hours if hours else 0.0)
        )
    return out


def _sheet(rows: Sequence[Mapping[str, Any]]) -> Sheet:
    out = []
    for low, high in pairwise(BINS):
        group = [row for row in rows if low <= float(row["distance"]) < high]
        delays = np.array([_delay(row) for row in group], dtype=float)
        share = wilson_share(np.asarray(delays <= WITHIN))
        found = delays[np.isfinite(delays)]
        out.append(
            (
                f"{low:g} to {high:g}",
                str(len(group)),
                f"{share.mean:.3f} [{share.low:.3f}, {share.high:.3f}]",
                f"{np.median(found):.2f}" if len(found) else "–",
            )
        )
    return Sheet(
        title=f"carried chairs that are stopped within {WITHIN:g} s",
        columns=("distance, m", "drives", "detected [95 %]", "median delay, s"),
        rows=tuple(out),
    )


def _is_carried(row: Mapping[str, Any]) -> bool:
    return float(row["carried"]) > 0.0


def _sound_time(row: Mapping[str, Any]) -> float:
    return (
        min(float(row["at"]), float(row["duration"]))
        if _is_carried(row)
        else float(row["duration"])
    )


def _is_false(row: Mapping[str, Any]) -> bool:
    found = float(row["found"])
    return math.isfinite(found) and (not _is_carried(row) or found < float(row["at"]))


def _delay(row: Mapping[str, Any]) -> float:
    delay = float(row["found"]) - float(row["at"])
    return delay if delay >= 0.0 else math.inf


def _crossings(time: Floats, above: np.ndarray) -> int:
    """Number of times at which a condition begins, at least a second apart."""
    starts = time[np.flatnonzero(above & ~np.concatenate([[False], above[:-1]]))]
    if not len(starts):
        return 0
    count, last = 1, starts[0]
    for start in starts[1:]:
        if start - last > _APART:
            count, last = count + 1, start
    return count
