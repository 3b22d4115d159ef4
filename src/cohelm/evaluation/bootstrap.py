"""How sure a mean is: percentile bootstrap intervals (Efron 1979); and how sure a share is."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from cohelm.arrays import Booleans, Floats, value

RESAMPLES = 10_000
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


def estimate(values: Floats, of: Callable[..., Floats] = np.mean) -> Estimate:
    """Mean of values (n,), or what else ``of(values, axis)`` says, with its 95 % interval.

    NaN are left out.

    The resamples are the same every time, so that the same values give the same interval.
    """
    given = values[np.isfinite(values)]
    if not len(given):
        return Estimate(mean=np.nan, low=np.nan, high=np.nan, count=0)
    picks = np.random.default_rng(_SEED).integers(len(given), size=(RESAMPLES, len(given)))
    low, high = np.quantile(of(given[picks], axis=1), [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0])
    mean = float(of(given, axis=0))
    return Estimate(mean=mean, low=float(low), high=float(high), count=len(given))


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
        return Estimate(mean=np.nan, low=np.nan, high=np.nan, count=0)
    p, z2 = float(np.mean(met)), _NORMAL**2
    middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n)
    half = _NORMAL * math.sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n)) / (1.0 + z2 / n)
    return Estimate(mean=p, low=max(middle - half, 0.0), high=min(middle + half, 1.0), count=n)
