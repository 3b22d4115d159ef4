"""Comparison of two result folders, ride by ride."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Booleans
from cohelm.errors import ConfigError
from cohelm.evaluation.metrics.measures import measure_info
from cohelm.evaluation.report.rides import Key, Rides, Row, measures_of, severity
from cohelm.evaluation.report.statistics import Contrast, contrast, corrected

JUDGED = (
    "reached", "program_error", "person_collision", "standing_contact", "wall_collision", "time",
    "path_length", "min_distance", "wall_distance", "social_space_intrusion", "stalled_time",
    "heading_change", "jerk_rms", "agreement", "conflict_share", "rider_effort",
)  # fmt: skip
"""Default measures in which a change for the worse is a regression."""
ALL = "all"
"""Case of a change over all cases."""


@dataclass(frozen=True)
class MeasureChange:
    """Difference of a measure of a group from A to B, on the rides that both have."""

    group: Key
    """Values of the compared columns."""
    name: str
    before: float
    """Share or median of the paired rides in A."""
    after: float
    contrast: Contrast

    @property
    def verdict(self) -> str:
        """``worse`` is a regression; empty where it may be chance."""
        return self.contrast.verdict


@dataclass(frozen=True)
class SweepComparison:
    """Common rides of two folders, and their differences."""

    by: tuple[str, ...]
    changes: tuple[MeasureChange, ...]
    pairs: int
    identical: int
    """Pairs that are equal in every judged measure and outcome."""
    only_before: int
    only_after: int
    """Rides without a partner."""
    reconfigured: int
    """Pairs with different configurations."""
    failures: tuple[tuple[Row, Row], ...] = ()
    """Pairs with a worse end in B; too few of them may not be a regression yet."""
    other_groups: tuple[Key, ...] = ()
    """Groups without a pair."""

    @property
    def regressions(self) -> tuple[MeasureChange, ...]:
        """Changes that are clearly worse."""
        return tuple(each for each in self.changes if each.verdict == "worse")


def compare(before: Rides, after: Rides, names: Sequence[str] | None = None) -> SweepComparison:
    """Compare two sweeps on the rides that share compared columns and seed.

    Every contender is judged over all cases together, where the riders of one case and seed count
    as one, and in each case. The p-values of either are corrected for all their groups and measures
    (Holm 1979): sweeps that differ by chance alone are called different in at most one of ten
    comparisons.

    Args:
        before, after: rides of A and of B.
        names: measures to judge; None: ``JUDGED``.

    Raises:
        ConfigError: if they compare different columns, share no ride, or lack a named measure.
    """
    _check(before, after, names)
    judged = [name for name in names or JUDGED if before.has(name) and after.has(name)]
    ours, theirs = _groups(before), _groups(after)
    by_group = {key: _paired(ours[key], theirs[key]) for key in ours if key in theirs}
    by_group = {key: both for key, both in by_group.items() if len(both[0])}
    if not by_group:
        raise ConfigError("the folders have no ride in common: no group and seed agree")
    one, other = _all(both[0] for both in by_group.values()), _all(b[1] for b in by_group.values())
    together = {
        (*(ALL,) * (len(before.by) - 1), name): (one.of(contender=name), other.of(contender=name))
        for name in one.contenders
    }
    changes = _changes(by_group, judged)
    if len(by_group) > len(together):
        changes = [*_changes(together, judged), *changes]
    identical = _identical(one, other, judged)
    return SweepComparison(
        by=before.by,
        changes=tuple(changes),
        pairs=len(one),
        identical=int(identical.sum()),
        only_before=len(before) - len(one),
        only_after=len(after) - len(one),
        reconfigured=sum(
            a.get("config") != b.get("config") for a, b in zip(one, other, strict=True)
        ),
        failures=tuple(_failures(one, other)),
        other_groups=tuple(sorted(ours.keys() ^ by_group.keys() | theirs.keys() - ours.keys())),
    )


def as_dict(found: SweepComparison) -> dict[str, Any]:
    """Comparison as plain data."""
    return {
        "by": found.by,
        "pairs": found.pairs,
        "identical": found.identical,
        "only_before": found.only_before,
        "only_after": found.only_after,
        "reconfigured": found.reconfigured,
        "failures": [
            {
                **{key: after.get(key) for key in (*found.by, "seed", "replay")},
                "before": before.get("outcome"),
                "after": after.get("outcome"),
            }
            for before, after in found.failures
        ],
        "other_groups": found.other_groups,
        "regressions": len(found.regressions),
        "changes": [
            {
                **dict(zip(found.by, each.group, strict=True)),
                "measure": each.name,
                "before": each.before,
                "after": each.after,
                "difference": each.contrast.difference.mean,
                "low": each.contrast.difference.low,
                "high": each.contrast.difference.high,
                "pairs": each.contrast.difference.count,
                "p": each.contrast.p,
                "p_holm": each.contrast.corrected,
                "verdict": each.verdict,
            }
            for each in found.changes
        ],
    }


def _check(before: Rides, after: Rides, names: Sequence[str] | None) -> None:
    if before.by != after.by:
        raise ConfigError(
            f"the folders compare different columns: {', '.join(before.by)} and "
            f"{', '.join(after.by)}"
        )
    known = {*measures_of(before), *measures_of(after)}
    missing = [name for name in names or () if name not in known]
    if missing:
        raise ConfigError(
            f"no ride has {', '.join(missing)}; there are {', '.join(sorted(known))}",
            key="--measures",
        )


def _groups(rides: Rides) -> Mapping[Key, Rides]:
    return {
        (*case, name): group
        for case, by_name in rides.split().items()
        for name, group in by_name.items()
    }


def _paired(before: Rides, after: Rides) -> tuple[Rides, Rides]:
    i, j = before.pairs(after)
    return before.take(i), after.take(j)


def _all(groups: Iterable[Rides]) -> Rides:
    each = list(groups)
    return Rides([row for rides in each for row in rides], each[0].by)


def _changes(
    by_group: Mapping[Key, tuple[Rides, Rides]], names: Sequence[str]
) -> list[MeasureChange]:
    """Changes of every group and measure, corrected for all of them."""
    drafts = [(key, name, both) for key, both in by_group.items() for name in names]
    contrasts = corrected(
        [
            contrast(b.column(name), a.column(name), measure_info(name), b.units(range(len(b))))
            for _, name, (a, b) in drafts
        ]
    )
    return [
        MeasureChange(key, name, *_middles(name, *both), each)
        for (key, name, both), each in zip(drafts, contrasts, strict=True)
    ]


def _middles(name: str, one: Rides, other: Rides) -> tuple[float, float]:
    """Share or median of each, over the pairs in which both have a value."""
    a, b = one.column(name), other.column(name)
    there = np.isfinite(a) & np.isfinite(b)
    if not there.any():
        return np.nan, np.nan
    middle = np.mean if measure_info(name).of_rides else np.median
    return float(middle(a[there])), float(middle(b[there]))


def _failures(one: Rides, other: Rides) -> Iterator[tuple[Row, Row]]:
    """Pairs with a worse end than before: not reached, a collision, or a program error."""
    for a, b in zip(one, other, strict=True):
        if severity(b) > severity(a):
            yield a, b


def _identical(one: Rides, other: Rides, names: Sequence[str]) -> Booleans:
    """Pairs (k,) with equal outcome and measures."""
    equal: Booleans = np.array(
        [a.get("outcome") == b.get("outcome") for a, b in zip(one, other, strict=True)], dtype=bool
    )
    for name in names:
        a, b = one.column(name), other.column(name)
        equal &= (a == b) | (np.isnan(a) & np.isnan(b))
    return equal
