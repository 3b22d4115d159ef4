"""Tables of rides, common to all benchmarks: groups, differences on equal seeds, matrices.

Headings, units and digits are those of ``cohelm.evaluation.report.measures``.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.metrics.measures import OF_RIDES, PERCENT, Family, RideMeasure, measure_info
from cohelm.evaluation.report.rides import Rides, Row
from cohelm.evaluation.report.statistics import (
    Estimate,
    bootstrap_mean,
    bootstrap_median,
    wilson_share,
)
from cohelm.evaluation.report.write import Sheet

_DERIVED: Mapping[str, RideMeasure] = {
    "any_collision": RideMeasure("any collision", OF_RIDES, -1, Family.SAFETY, 0),
    "touch_speed": RideMeasure("fastest contact", "m/s", -1, Family.SAFETY),
    "collision_speed": RideMeasure("fastest collision with a person", "m/s", -1, Family.SAFETY),
    "delay": RideMeasure("delay over empty floor", "s", -1, digits=1),
    "collisions": RideMeasure("collisions", "", -1, Family.SAFETY),
    "path_length_ratio": RideMeasure("path length over the straight line", "", -1),
    "path_irregularity": RideMeasure("path irregularity", "rad", -1),
    "goal_traversal_ratio": RideMeasure("distance left over distance at the start", "", -1),
    "motion_energy": RideMeasure("motion energy", "m²/s", -1, digits=1),
    "closest_pedestrian": RideMeasure("centre of the nearest person, mean", "m", 1),
    "socnavbench_ttc": RideMeasure("time to collision, mean", "s", 1),
}
"""Measures of benchmarks beyond those of a ride's row."""
_MAXIMA = ("touch_speed", "collision_speed")
"""Shown by their maximum, not their median."""


def measure(name: str) -> RideMeasure:
    """Label, unit, direction and digits of a measure."""
    return _DERIVED.get(name) or measure_info(name)


def column(rides: Rides, name: str) -> Floats:
    """Measure of each ride, (k,), NaN where there is none; derived ones included."""
    if name == "touch_speed":
        return np.fmax(rides.column("collision_speed"), rides.column("collision_speed_wall"))
    if name == "delay":
        return rides.column("time") - rides.column("time_empty_floor")
    return rides.column(name)


def estimate(rides: Rides, name: str) -> Estimate:
    """Share with its Wilson interval, maximum without one, or median with bootstrap interval."""
    values = column(rides, name)
    if measure(name).of_rides:
        return wilson_share(values > 0.0)
    if name in _MAXIMA:
        there = values[np.isfinite(values)]
        most = float(there.max()) if len(there) else np.nan
        return Estimate(mean=most, low=most, high=most, count=len(there))
    return bootstrap_median(values)


def paired_differences(one: Rides, other: Rides, name: str) -> Floats:
    """Measure of one minus that of the other on equal cases and seeds, (u,).

    Riders of one scene and seed meet the same people, so they count as one ride with their mean;
    NaN where no rider has both values.
    """
    i, j = one.pairs(other)
    found: dict[Any, list[float]] = {}
    differences = column(one, name)[i] - column(other, name)[j]
    for unit, each in zip(one.units(i), differences, strict=True):
        found.setdefault(unit, []).append(float(each))
    return np.array([_mean(each) for each in found.values()])


def groups_of(rows: Sequence[Row], case: str = "scene", by: str = "planner") -> dict[str, Any]:
    """Case → contender → rides, in the order of the rows."""
    cases = Rides(rows, (case,)).by_contender()
    return {name: Rides(each.rows, (by,)).by_contender() for name, each in cases.items()}


def group_table(
    title: str, groups: Mapping[str, Rides], measures: Sequence[str], head: str = "planner"
) -> Sheet:
    """One line per group: shares and medians with 95 % intervals."""
    return Sheet(
        title=f"{title}: share or median [95 % interval]",
        columns=(head, "rides", *(measure(name).heading for name in measures)),
        rows=tuple(
            (name, str(len(rides)), *(estimate_text(estimate(rides, m), m) for m in measures))
            for name, rides in groups.items()
            if len(rides)
        ),
    )


def difference_table(
    title: str,
    groups: Mapping[str, Rides],
    base: str,
    measures: Sequence[str],
    head: str = "planner",
) -> Sheet:
    """Difference of every group from ``base`` on equal seeds: mean [95 % interval]."""
    others = [name for name in groups if name != base and len(groups[name])]
    return differences_sheet(
        f"{title}: difference from {base} on equal seeds",
        {
            name: {
                m: bootstrap_mean(paired_differences(groups[name], groups[base], m))
                for m in measures
            }
            for name in others
            if base in groups and len(groups[base])
        },
        measures,
        head,
    )


def differences_sheet(
    title: str,
    differences: Mapping[str, Mapping[str, Estimate]],
    measures: Sequence[str],
    head: str,
) -> Sheet:
    """Table of mean differences, name → measure → estimate."""
    return Sheet(
        title=f"{title} (mean [95 % interval])",
        columns=(head, *(measure(name).heading for name in measures)),
        rows=tuple(
            (name, *(signed_text(by_measure[m], m) for m in measures))
            for name, by_measure in differences.items()
        ),
    )


def matrix_table(rides: Rides, name: str) -> Sheet:
    """One measure: a line per case, a column per contender."""
    contenders = rides.contenders
    return Sheet(
        title=f"{measure(name).heading}{'' if measure(name).of_rides else ', median'}",
        columns=(*rides.by[:-1], *contenders),
        rows=tuple(
            (*case, *(_cell(each[who], name) if who in each else "" for who in contenders))
            for case, each in rides.split().items()
        ),
    )


def _cell(rides: Rides, name: str) -> str:
    if measure(name).of_rides:
        return f"{int((column(rides, name) > 0.0).sum())} of {len(rides)}"
    found = estimate(rides, name)
    return value_text(found.mean, name) if found.count else "–"


def figures(groups: Mapping[str, Rides], measures: Sequence[str]) -> dict[str, Any]:
    """Figures of a table for programs."""
    return {
        who: {"rides": len(rides), **{m: as_dict(estimate(rides, m)) for m in measures}}
        for who, rides in groups.items()
    }


def as_dict(each: Estimate) -> dict[str, float | None]:
    """Estimate for programs; None instead of NaN."""
    values = {"value": each.mean, "low": each.low, "high": each.high}
    finite = {key: x if np.isfinite(x) else None for key, x in values.items()}
    return {**finite, "count": each.count}


def value_text(value: float, name: str) -> str:
    """Number with the digits of its measure, shares in per cent; ``–`` where there is none."""
    return measure(name).text(value)


def estimate_text(each: Estimate, name: str) -> str:
    """``97 [92, 99]``; a maximum has no interval."""
    if not each.count:
        return "–"
    text = value_text(each.mean, name)
    if name in _MAXIMA:
        return text
    return f"{text} [{value_text(each.low, name)}, {value_text(each.high, name)}]"


def signed_text(each: Estimate, name: str) -> str:
    """Difference with its sign: ``+1.2 [0.3, 2.1]``; shares in per cent."""
    if not each.count:
        return "–"
    how = measure(name)
    digits = how.digits + how.of_rides
    factor = 100.0 if how.unit in {PERCENT, OF_RIDES} else 1.0
    mean, low, high = (factor * x + 0.0 for x in (each.mean, each.low, each.high))
    return f"{mean:+.{digits}f} [{low:.{digits}f}, {high:.{digits}f}]"


def _mean(values: Sequence[float]) -> float:
    there = [each for each in values if np.isfinite(each)]
    return float(np.mean(there)) if there else float("nan")
