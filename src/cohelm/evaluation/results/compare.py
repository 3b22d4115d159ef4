"""Two result folders beside each other: what got better, what got worse, what cannot be said."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Booleans
from cohelm.errors import ConfigError
from cohelm.evaluation.results.contrasts import Contrast, contrast, corrected
from cohelm.evaluation.results.measures import measure
from cohelm.evaluation.results.rides import Key, Rides, Row, ended_badly, measures_of

JUDGED = (
    "reached", "broke_off", "hit_moving", "hit_standing", "hit_wall", "time", "path_length",
    "min_distance", "wall_distance", "social_space_intrusion", "stalled_time", "heading_change",
    "jerk_rms", "agreement", "fight_rate", "rider_effort",
)  # fmt: skip
"""Measures in which a change for the worse is a regression, where no others are named."""


ALL = "all"
"""In place of a case: over all of them."""


@dataclass(frozen=True)
class Change:
    """A measure of a group in B less that in A, on the rides that both have."""

    group: Key
    """What was compared, by the values of the columns."""
    name: str
    before: float
    """Share or median of the paired rides in A."""
    after: float
    less: Contrast

    @property
    def verdict(self) -> str:
        """``worse`` is a regression; empty where it may well be chance."""
        return self.less.verdict


@dataclass(frozen=True)
class Comparison:
    """What two folders have in common, and how they differ in it."""

    by: tuple[str, ...]
    changes: tuple[Change, ...]
    pairs: int
    identical: int
    """Of the pairs, those equal in every judged measure and outcome."""
    only_before: int
    only_after: int
    """Rides without a partner."""
    reconfigured: int
    """Of the pairs, those whose experiments were not the same."""
    failures: tuple[tuple[Row, Row], ...] = ()
    """Pairs that ended worse in B, one by one: too few of them may be no regression yet."""
    other_groups: tuple[Key, ...] = ()
    """Groups without one pair: nothing is said of them."""

    @property
    def regressions(self) -> tuple[Change, ...]:
        """What clearly got worse."""
        return tuple(each for each in self.changes if each.verdict == "worse")


def compare(before: Rides, after: Rides, names: Sequence[str] | None = None) -> Comparison:
    """Contrast two sweeps ride by ride, where what was compared and the seed agree.

    Every contender is judged over all cases together, in which the riders of one scene and seed
    count as one, and in each case by itself; the p-values of either are corrected for all their
    groups and measures (Holm 1979), so that sweeps that differ by chance alone are called different
    in one of ten comparisons at most.

    Args:
        before, after: the rides of A and of B.
        names: measures to judge; None: ``JUDGED``.

    Raises:
        ConfigError: if they do not compare the same columns, share no ride, or lack a measure that
            is named.
    """
    _check(before, after, names)
    asked = [name for name in names or JUDGED if before.has(name) and after.has(name)]
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
    changes = _changes(by_group, asked)
    if len(by_group) > len(together):
        changes = [*_changes(together, asked), *changes]
    same = _same(one, other, asked)
    return Comparison(
        by=before.by,
        changes=tuple(changes),
        pairs=len(one),
        identical=int(same.sum()),
        only_before=len(before) - len(one),
        only_after=len(after) - len(one),
        reconfigured=sum(
            a.get("config") != b.get("config") for a, b in zip(one, other, strict=True)
        ),
        failures=tuple(_failures(one, other)),
        other_groups=tuple(sorted(ours.keys() ^ by_group.keys() | theirs.keys() - ours.keys())),
    )


def as_dict(found: Comparison) -> dict[str, Any]:
    """The same for programs."""
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
                "less": each.less.less.mean,
                "low": each.less.less.low,
                "high": each.less.less.high,
                "pairs": each.less.less.count,
                "p": each.less.p,
                "p_holm": each.less.corrected,
                "verdict": each.verdict,
            }
            for each in found.changes
        ],
    }


def _check(before: Rides, after: Rides, names: Sequence[str] | None) -> None:
    if before.by != after.by:
        raise ConfigError(
            f"the folders compare different things: {', '.join(before.by)} and "
            f"{', '.join(after.by)}"
        )
    known = {*measures_of(before), *measures_of(after)}
    missing = [name for name in names or () if name not in known]
    if missing:
        raise ConfigError(
            f"no ride says anything of {', '.join(missing)}; there are {', '.join(sorted(known))}",
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


def _changes(by_group: Mapping[Key, tuple[Rides, Rides]], names: Sequence[str]) -> list[Change]:
    """Of every group and measure, corrected for all of them."""
    drafts = [(key, name, both) for key, both in by_group.items() for name in names]
    sure = corrected(
        [
            contrast(b.column(name), a.column(name), measure(name), b.units(range(len(b))))
            for _, name, (a, b) in drafts
        ]
    )
    return [
        Change(key, name, *_middles(name, *both), less)
        for (key, name, both), less in zip(drafts, sure, strict=True)
    ]


def _middles(name: str, one: Rides, other: Rides) -> tuple[float, float]:
    """Share or median of each, over the pairs in which both have one."""
    a, b = one.column(name), other.column(name)
    there = np.isfinite(a) & np.isfinite(b)
    if not there.any():
        return np.nan, np.nan
    middle = np.mean if measure(name).share else np.median
    return float(middle(a[there])), float(middle(b[there]))


def _failures(one: Rides, other: Rides) -> Iterator[tuple[Row, Row]]:
    """Pairs that end worse than before: not reached, a collision, or a fault of the program."""
    for a, b in zip(one, other, strict=True):
        if ended_badly(b) > ended_badly(a):
            yield a, b


def _same(one: Rides, other: Rides, names: Sequence[str]) -> Booleans:
    """Pairs (k,) that agree in outcome and in every measure."""
    same: Booleans = np.array(
        [a.get("outcome") == b.get("outcome") for a, b in zip(one, other, strict=True)], dtype=bool
    )
    for name in names:
        a, b = one.column(name), other.column(name)
        same &= (a == b) | (np.isnan(a) & np.isnan(b))
    return same
