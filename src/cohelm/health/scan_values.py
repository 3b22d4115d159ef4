"""Plausibility of one sweep by itself: invalid readings, stuck values, a repeated sweep."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.kernels import CACHED

SAME_RANGE = 1e-3
"""Difference below which neighbouring beams read the same value, m: a tenth of the noise of a
scanner."""
SAME_BEAMS = 20
"""Length of a run of equal values from which they are stuck; also a share of the beams, below."""
SAME_SHARE = 0.1


class SweepCheck(NamedTuple):
    """Result of :func:`check_sweep`."""

    usable: Booleans
    """Beams (b,) with a return or a free path that may be believed."""
    invalid: float
    """Share of the beams without a believable reading."""
    stuck: float
    """Share of the beams that belong to a run of one value."""
    repeated: float
    """Share of the returns that equal the sweep before to the last bit; 0 without one."""


def check_sweep(ranges: Floats, range_max: float, before: Floats | None) -> SweepCheck:
    """Check the ranges (b,) of a sweep, m, against themselves and the sweep before."""
    past = before if before is not None and len(before) == len(ranges) else ranges[:0]
    return SweepCheck(*_check(ranges, range_max, past))


@njit(**CACHED)
def _check(
    ranges: Floats, range_max: float, before: Floats
) -> tuple[Booleans, float, float, float]:
    b = len(ranges)
    usable = np.zeros(b, dtype=np.bool_)
    least = max(SAME_BEAMS, int(SAME_SHARE * b))
    # +inf is a free path (REP-117); NaN, −inf, 0 and beyond the sensor's range are no readings.
    for i in range(b):
        r = ranges[i]
        usable[i] = r == math.inf or (r > 0.0 and r <= range_max)
    # Runs of returns with one value: noise makes them impossible.
    stuck, i = 0, 0
    while i < b:
        j = i + 1
        if math.isfinite(ranges[i]) and usable[i]:
            while j < b and abs(ranges[j] - ranges[i]) <= SAME_RANGE:
                j += 1
            if j - i >= least:
                stuck += j - i
                usable[i:j] = False
        i = j
    equal, returns = 0, 0
    if len(before):
        for i in range(b):
            if math.isfinite(ranges[i]):
                returns += 1
                equal += ranges[i] == before[i]
    repeated = equal / returns if returns >= SAME_BEAMS else 0.0
    return usable, 1.0 - usable.sum() / max(b, 1), stuck / max(b, 1), repeated
