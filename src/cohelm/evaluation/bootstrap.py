"""How sure a mean is: percentile bootstrap intervals (Efron 1979); and how sure a share is."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers, value

RESAMPLES = 2_000
"""Of an interval; another draw moves its bounds by some 5 % of its width."""
LEVEL = 0.95
_SEED = 20_240
_NORMAL = 1.959964
"""Of the standard normal distribution, 95 % lies within this of 0."""


@value
class Estimate:
    """A mean, or another figure, and the interval that holds it."""

    mean: float
    """Or the median, or the share, where that is what was estimated."""
    low: float
    high: float
    count: int
    """Of how many values; the rest had none."""

    def __format__(self, spec: str) -> str:
        """``1.23 [1.10, 1.35]``."""
        if not self.count:
            return "–"
        return f"{self.mean:{spec}} [{self.low:{spec}}, {self.high:{spec}}]"


def mean_of(values: Floats) -> Estimate:
    """Mean of values (n,) with its 95 % percentile bootstrap interval (Efron 1979); NaN left out.

    The same values give the same interval, in whatever order they come.
    """
    given = np.sort(values[np.isfinite(values)])
    if not len(given):
        return _nothing()
    return _estimate(float(given.mean()), given[_drawn(len(given))].mean(axis=1), len(given))


def median_of(values: Floats) -> Estimate:
    """Median of values (n,), and as :func:`mean_of`.

    A resample's median is the value, or the mean of the two, in the middle of the drawn ranks.
    """
    given = np.sort(values[np.isfinite(values)])
    if not len(given):
        return _nothing()
    medians = given[_middles(len(given))].mean(axis=1)
    return _estimate(float(np.median(given)), medians, len(given))


def middle_of(values: Floats) -> float:
    """The median of values (n,) without an interval; NaN are left out, NaN of none."""
    there = values[np.isfinite(values)]
    return float(np.median(there)) if len(there) else math.nan


def share(met: Booleans) -> Estimate:
    """The share of (n,) that is met with its 95 % score interval (Wilson 1927).

    Unlike the bootstrap's it says something of none in a hundred: up to 3.7 % may be.
    """
    n = len(met)
    if not n:
        return _nothing()
    p, z2 = float(np.mean(met)), _NORMAL**2
    middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n)
    half = _NORMAL * math.sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n)) / (1.0 + z2 / n)
    return Estimate(mean=p, low=max(middle - half, 0.0), high=min(middle + half, 1.0), count=n)


def _estimate(centre: float, resampled: Floats, count: int) -> Estimate:
    low, high = np.quantile(resampled, [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0])
    return Estimate(mean=centre, low=float(low), high=float(high), count=count)


def _nothing() -> Estimate:
    return Estimate(mean=np.nan, low=np.nan, high=np.nan, count=0)


@lru_cache(maxsize=8)
def _drawn(n: int) -> Integers:
    """Ranks (RESAMPLES, n) of so many resamples of n values."""
    drawn: Integers = np.random.default_rng(_SEED).integers(n, size=(RESAMPLES, n))
    return drawn


@lru_cache(maxsize=256)
def _middles(n: int) -> Integers:
    """The ranks (RESAMPLES, 2) in the middle of each resample, the same twice where n is odd."""
    middle = [(n - 1) // 2, n // 2]
    ranks: Integers = np.partition(_drawn(n), middle, axis=1)[:, middle]
    return ranks
