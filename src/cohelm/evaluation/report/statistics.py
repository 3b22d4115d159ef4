"""Interval estimates, and tests of paired differences."""

from __future__ import annotations

import math
from collections.abc import Callable, Hashable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import stats

from cohelm.arrays import Booleans, Floats, value
from cohelm.evaluation.metrics.measures import RideMeasure

RESAMPLES = 2_000
"""Resamples of a bootstrap interval; its bounds vary with the draw by 5 % of its width."""
ALPHA = 0.05
"""Level of the corrected p-value below which a difference is called one."""
_SEED = 20_240
_EXACT = 50


@value
class Estimate:
    """Estimate of a mean, median or share with its 95 % interval."""

    mean: float
    """Estimated value: mean, median or share."""
    low: float
    high: float
    count: int
    """Number of values; missing ones do not count."""

    def __format__(self, spec: str) -> str:
        """``1.23 [1.10, 1.35]``."""
        if not self.count:
            return "–"
        return f"{self.mean:{spec}} [{self.low:{spec}}, {self.high:{spec}}]"


NO_ESTIMATE = Estimate(mean=math.nan, low=math.nan, high=math.nan, count=0)


def bootstrap_mean(values: Floats) -> Estimate:
    """Mean of values (n,) with its percentile bootstrap interval (Efron 1979), without NaN.

    The interval does not depend on the order of the values.
    """
    return _bootstrap(values, np.mean)


def bootstrap_median(values: Floats) -> Estimate:
    """Median of values (n,) with its percentile bootstrap interval, without NaN."""
    return _bootstrap(values, np.median)


def bootstrap(samples: Sequence[Floats], statistic: Callable[..., Any]) -> tuple[float, float]:
    """Percentile bootstrap interval of a vectorised statistic of paired samples, each (n,)."""
    found = stats.bootstrap(
        samples,
        statistic,
        n_resamples=RESAMPLES,
        paired=True,
        vectorized=True,
        method="percentile",
        rng=np.random.default_rng(_SEED),
    ).confidence_interval
    return float(found.low), float(found.high)


def median(values: Floats) -> float:
    """Median of values (n,) without NaN; NaN of none."""
    there = values[np.isfinite(values)]
    return float(np.median(there)) if len(there) else math.nan


def wilson_share(met: Booleans) -> Estimate:
    """Share of (n,) that is true, with its score interval (Wilson 1927)."""
    n = len(met)
    if not n:
        return NO_ESTIMATE
    k = int(np.count_nonzero(met))
    interval = stats.binomtest(k, n).proportion_ci(method="wilson")
    return Estimate(mean=k / n, low=float(interval.low), high=float(interval.high), count=n)


def _bootstrap(values: Floats, statistic: Callable[..., Any]) -> Estimate:
    given = np.sort(values[np.isfinite(values)])
    if not len(given):
        return NO_ESTIMATE
    centre = float(statistic(given))
    low = high = centre
    if given[0] != given[-1]:
        low, high = bootstrap((given,), statistic)
    return Estimate(mean=centre, low=low, high=high, count=len(given))


@value
class Contrast:
    """Difference of a measure between two groups of rides on equal cases and seeds."""

    difference: Estimate
    """Mean difference with its bootstrap interval."""
    p: float
    """Two-sided; NaN without a test."""
    corrected: float = float("nan")
    """p corrected for all simultaneous tests (Holm 1979)."""
    better: int = 0
    """1: larger is better, −1: smaller is better, 0: neither."""
    sign: int = 0
    """Sign of the sum of signed ranks."""

    @property
    def verdict(self) -> str:
        """``better``, ``worse`` or ``differs``; empty where it may be chance.

        The mean and most pairs may have opposite signs: such a measure differs only.
        """
        if not self.corrected < ALPHA:
            return ""
        if not self.better or self.difference.mean * self.sign <= 0.0:
            return "differs"
        return "better" if self.sign * self.better > 0 else "worse"


def contrast(
    ours: Floats, theirs: Floats, info: RideMeasure, units: Sequence[Hashable] | None = None
) -> Contrast:
    """``ours`` − ``theirs``, (k,) each, pair by pair; pairs with a missing value are left out.

    Yes-or-no measures are tested by McNemar's exact test (1947), all others, and means of yes or
    no, by Wilcoxon's signed ranks (1945).

    Args:
        ours, theirs: values of the two groups.
        info: entry of the measure.
        units: independent unit of each pair; pairs of one unit count once, with the mean of their
            differences. None: every pair is independent.
    """
    both = np.isfinite(ours) & np.isfinite(theirs)  # inf: no person was near
    difference = ours[both] - theirs[both]
    if units is not None:
        there = [unit for unit, pair in zip(units, both, strict=True) if pair]
        difference = _unit_means(difference, there)
    is_yes_or_no = info.of_rides and bool(np.isin(difference, (-1.0, 0.0, 1.0)).all())
    test = exact_mcnemar if is_yes_or_no else signed_ranks
    return Contrast(
        difference=bootstrap_mean(difference),
        p=test(difference),
        better=info.better,
        sign=_rank_sign(difference),
    )


def exact_mcnemar(difference: Floats) -> float:
    """Two-sided p of differences (k,) in {−1, 0, 1}: +1 and −1 equally likely. NaN for none."""
    if not len(difference):
        return float("nan")
    up, down = int((difference > 0.0).sum()), int((difference < 0.0).sum())
    return 1.0 if up + down == 0 else float(stats.binomtest(up, up + down).pvalue)


def signed_ranks(difference: Floats) -> float:
    """Two-sided p of differences (k,): symmetric about 0. NaN for none.

    Wilcoxon's signed ranks without zero differences. Up to 50 pairs the distribution of the rank
    sum is exact also with ties, which scipy's exact method is not; beyond it is approximated by the
    normal distribution.
    """
    if not len(difference):
        return float("nan")
    moved = difference[difference != 0.0]
    if not len(moved):
        return 1.0
    if len(moved) > _EXACT:
        return float(stats.wilcoxon(moved, method="asymptotic").pvalue)
    # Mid-ranks are multiples of one half, so twice the ranks are integers.
    ranks = np.rint(2.0 * stats.rankdata(np.abs(moved))).astype(int)
    chance = np.zeros(int(ranks.sum()) + 1)
    chance[0] = 1.0
    for rank in ranks:
        chance[rank:] = 0.5 * (chance[rank:] + chance[: len(chance) - rank])
        chance[:rank] *= 0.5
    least = int(min(ranks[moved > 0.0].sum(), ranks[moved < 0.0].sum()))
    return min(1.0, 2.0 * float(chance[: least + 1].sum()))


def corrected(contrasts: Sequence[Contrast]) -> list[Contrast]:
    """The contrasts with p-values corrected for their number (Holm 1979)."""
    given = np.array([each.p for each in contrasts], dtype=float)
    holm = holm_corrected(given)
    return [replace(each, corrected=float(p)) for each, p in zip(contrasts, holm, strict=True)]


def holm_corrected(p: Floats) -> Floats:
    """p-values (k,) corrected by Holm's step-down procedure (1979); NaN are not tests."""
    out = np.full(len(p), np.nan)
    there = np.flatnonzero(np.isfinite(p))
    order = there[np.argsort(p[there], kind="stable")]
    steps = np.arange(len(order), 0, -1) * p[order]
    out[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return out


def _unit_means(difference: Floats, units: Sequence[Hashable]) -> Floats:
    """Mean difference of each unit, in the order of their first pairs."""
    found: dict[Hashable, list[float]] = {}
    for unit, each in zip(units, difference, strict=True):
        found.setdefault(unit, []).append(float(each))
    return np.array([float(np.mean(each)) for each in found.values()])


def _rank_sign(difference: Floats) -> int:
    """Sign of the sum of signed ranks of differences (k,)."""
    moved = difference[difference != 0.0]
    ranks = stats.rankdata(np.abs(moved))
    return int(np.sign((np.sign(moved) * ranks).sum()))
