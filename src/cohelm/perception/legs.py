"""Legs among clusters of returns: single ones, two that touch, pairs within a stride.

A scanner below the hips sees no torso but what carries it. Chairs and tables stand on legs as well
and look no different, so what is said here never makes a person by itself: something has to move.
The kernels work on arrays because they run over every cluster of every scan.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

CLUTTER_DECADES = 3.4
"""ln of the range of widths over which clutter spreads evenly in the logarithm (2 to 60 cm)."""
MOST, LEAST = 0.5, -3.0
"""Bounds of the log-odds of legs, from how they look alone."""


@njit(cache=True)
def width_odds(width: float, blur: float, mean: float, deviation: float) -> float:
    """Logarithm of how much sooner something of a known size than clutter shows this width.

    The size is normal, blurred by the gap between beams; clutter's density is 1 / (w ln(w₁/w₀)).

    Args:
        width: between the outermost returns and half a gap beyond either, m.
        blur: the gap, m.
        mean, deviation: of the size, m.
    """
    spread = math.hypot(deviation, 0.5 * blur)
    off = (width - mean) / spread
    peak = max(width, 0.01) * CLUTTER_DECADES / (spread * math.sqrt(2.0 * math.pi))
    return math.log(peak) - 0.5 * off * off


@njit(cache=True)
def stride_odds(apart: float, widest: float) -> float:
    """Logarithm of how much sooner two legs than two things strewn about are ``apart``, m.

    Legs: a Rayleigh distribution with its mode at two fifths of the widest stride. Strewn about: a
    density that grows with the distance, 2d / w².
    """
    mode = widest / 2.5
    return math.log(0.5 * (widest / mode) ** 2) - 0.5 * (apart / mode) ** 2


@njit(cache=True)
def pair_legs(centre: Floats, odds: Floats, widest: float, alone: float) -> tuple[Integers, Floats]:
    """Which legs walk together: the most probable pair first, then the next of what is left.

    Two make a pair where their distance speaks for it more than a missing leg does for two people.

    Args:
        centre: (k, 2) of legs, m.
        odds: (k,) log-odds of each.
        widest: longest stride, m.
        alone: log-odds of a person whose other leg is not seen.

    Returns:
        legs (d, 2): their indices, the second −1 where there is one only; odds (d,).
    """
    k = centre.shape[0]
    legs = np.full((k, 2), -1, dtype=np.int64)
    total = np.empty(k)
    free = np.ones(k, dtype=np.bool_)
    count = 0
    while True:
        best, a, b = -np.inf, -1, -1
        for i in range(k):
            for j in range(i + 1, k):
                if not (free[i] and free[j]):
                    continue
                d = math.hypot(centre[i, 0] - centre[j, 0], centre[i, 1] - centre[j, 1])
                if d > widest:
                    continue
                stride = stride_odds(d, widest)
                both = 0.5 * (odds[i] + odds[j]) + stride
                if both > best and stride > alone:
                    best, a, b = both, i, j
        if a < 0:
            break
        legs[count, 0], legs[count, 1], total[count] = a, b, best
        free[a] = free[b] = False
        count += 1
    for i in range(k):
        if free[i]:
            legs[count, 0], total[count] = i, odds[i] + alone
            count += 1
    return legs[:count], np.minimum(np.maximum(total[:count], LEAST), MOST)
