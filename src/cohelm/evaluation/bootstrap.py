"""How sure a mean is: percentile bootstrap intervals (Efron 1979)."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats, value

RESAMPLES = 10_000
LEVEL = 0.95
_SEED = 20_240


@value
class Estimate:
    """A mean and the interval that holds it."""

    mean: float
    low: float
    high: float
    count: int
    """Of how many values; the rest had none."""

    def __format__(self, spec: str) -> str:
        """``1.23 [1.10, 1.35]``."""
        if not self.count:
            return "–"
        return f"{self.mean:{spec}} [{self.low:{spec}}, {self.high:{spec}}]"


def estimate(values: Floats) -> Estimate:
    """Mean of values (n,) with its 95 % interval; NaN are left out.

    The resamples are the same every time, so that the same values give the same interval.
    """
    given = values[np.isfinite(values)]
    if not len(given):
        return Estimate(mean=np.nan, low=np.nan, high=np.nan, count=0)
    picks = np.random.default_rng(_SEED).integers(len(given), size=(RESAMPLES, len(given)))
    low, high = np.quantile(given[picks].mean(axis=1), [0.5 - LEVEL / 2.0, 0.5 + LEVEL / 2.0])
    return Estimate(mean=float(given.mean()), low=float(low), high=float(high), count=len(given))
