"""Shape fits of a cluster of returns: a disc (a body), a face, a corner, or clutter.

Each model gives −2 log-likelihood of the points (m, 2) up to a common constant. Range noise σ is
independent and normal across the surface. Each parameter costs ln m (Bayesian information
criterion), so that models with more parameters must fit better. Points are in beam order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.array_kernels import ZERO
from cohelm.arrays import Floats
from cohelm.kernels import CACHED, callee

CLUTTER_SCALE = 4.0
"""Deviation of clutter from a disc, in σ."""
SPLIT_GAIN = 8.0
"""Least decrease of −2 log-evidence for a split."""


class DiscPrior(NamedTuple):
    """Disc that stands for a body."""

    radius: float
    """r₀, m."""
    radius_deviation: float
    """σ_r, m."""
    noise: float
    """σ of returns about the disc, m."""


class DiscFit(NamedTuple):
    """Most probable disc behind some returns."""

    x: float
    """Centre, m."""
    y: float
    """Centre, m."""
    radius: float
    """m."""
    misfit: float
    """The minimum without the weak prior."""
    deviation: float
    """Standard deviation of the centre along its worse axis, m."""


@njit(**CACHED)
def fit_disc(points: Floats, origin: Floats, prior: DiscPrior) -> DiscFit:
    """Fit a disc behind the returns (m, 2), m ≥ 1, seen from a sensor at ``origin`` (2,), m.

    Minimises Σ((|pᵢ − c| − r)/σ)² + ((r − r₀)/σ_r)² by Gauss-Newton. The start lies 0.8 of the
    radius behind the points' mean; a weak prior (0.3 m) there keeps one or two points solvable.
    """
    m = points.shape[0]
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    ux, uy = mx - origin[0], my - origin[1]
    radius = prior.radius
    scale = 0.8 * radius / max(math.hypot(ux, uy), 1e-9)
    sx, sy = mx + scale * ux, my + scale * uy
    x, y, r = sx, sy, radius
    wp, wr, ws = 1.0 / prior.noise**2, 1.0 / prior.radius_deviation**2, 1.0 / 0.3**2
    hxx = hyy = hxy = hxr = hyr = hrr = 0.0
    for _ in range(8):
        hxx, hyy, hxy, hxr, hyr, hrr = ws, ws, 0.0, 0.0, 0.0, wr
        gx, gy, gr = ws * (x - sx), ws * (y - sy), wr * (r - radius)
        for i in range(m):
            dx, dy = x - points[i, 0], y - points[i, 1]
            d = max(math.hypot(dx, dy), 1e-9)
            a, b, e = dx / d, dy / d, d - r
            hxx += wp * a * a
            hxy += wp * a * b
            hyy += wp * b * b
            hxr -= wp * a
            hyr -= wp * b
            hrr += wp
            gx += wp * a * e
            gy += wp * b * e
            gr -= wp * e
        # Schur complement over r: the information of the centre alone.
        axx, axy, ayy = hxx - hxr * hxr / hrr, hxy - hxr * hyr / hrr, hyy - hyr * hyr / hrr
        bx, by = gx - hxr * gr / hrr, gy - hyr * gr / hrr
        det = axx * ayy - axy * axy
        px, py = -(ayy * bx - axy * by) / det, -(axx * by - axy * bx) / det
        # Steps of at most 0.1 m keep Gauss-Newton from overshooting.
        cut = min(1.0, 0.1 / max(math.hypot(px, py), 1e-12))
        px, py = cut * px, cut * py
        r += -(gr + hxr * px + hyr * py) / hrr
        x, y = x + px, y + py
        if abs(px) + abs(py) < 1e-4:
            break
    misfit = wr * (r - radius) ** 2
    for i in range(m):
        misfit += wp * (math.hypot(x - points[i, 0], y - points[i, 1]) - r) ** 2
    axx, axy, ayy = hxx - hxr * hxr / hrr, hxy - hxr * hyr / hrr, hyy - hyr * hyr / hrr
    weaker = 0.5 * (axx + ayy) - math.hypot(0.5 * (axx - ayy), axy)
    return DiscFit(x, y, r, misfit, 1.0 / math.sqrt(weaker))


@njit(**CACHED)
def disc_evidence(misfit: float, count: int) -> float:
    """−2 log-evidence of a disc with this misfit: a free centre, and a radius with a prior."""
    return misfit + 2.0 * math.log(count)


@njit(**CACHED)
def clutter_evidence(misfit: float, count: int) -> float:
    """−2 log-evidence of points about a disc with a deviation of ``CLUTTER_SCALE``·σ."""
    return misfit / CLUTTER_SCALE**2 + 2.0 * count * math.log(CLUTTER_SCALE) + 2.0 * math.log(count)


@njit(**CACHED)
def flat_evidence(points: Floats, noise: float) -> float:
    """−2 log-evidence of the better of a flat face and a convex right-angled corner.

    The angle has a deviation of 10° (as of four noisy points). Every cut of the points into two
    runs of at least two is tried, by prefix sums.
    """
    m = points.shape[0]
    sums = np.zeros((m + 1, 5))
    x0, y0 = points[0, 0], points[0, 1]
    for i in range(m):
        x, y = points[i, 0] - x0, points[i, 1] - y0
        sums[i + 1, 0] = sums[i, 0] + x
        sums[i + 1, 1] = sums[i, 1] + y
        sums[i + 1, 2] = sums[i, 2] + x * x
        sums[i + 1, 3] = sums[i, 3] + x * y
        sums[i + 1, 4] = sums[i, 4] + y * y
    log_m, w = math.log(m), 1.0 / noise**2
    best = w * _line(sums, ZERO, m)[0] + 2.0 * log_m
    for cut in range(2, m - 1):
        left, right = _line(sums, ZERO, cut), _line(sums, cut, m)
        turn = left[1] - right[1]
        off = (turn - math.pi * math.floor(turn / math.pi) - 0.5 * math.pi) / math.radians(10.0)
        corner = w * (left[0] + right[0]) + off * off + 4.0 * log_m
        best = min(best, corner)
    return best


@callee()
def _line(sums: Floats, start: int, stop: int) -> tuple[float, float]:
    """Fit a line to a run of points: (sum of squared distances, its direction)."""
    n = stop - start
    mx = (sums[stop, 0] - sums[start, 0]) / n
    my = (sums[stop, 1] - sums[start, 1]) / n
    xx = sums[stop, 2] - sums[start, 2] - n * mx * mx
    xy = sums[stop, 3] - sums[start, 3] - n * mx * my
    yy = sums[stop, 4] - sums[start, 4] - n * my * my
    least = 0.5 * (xx + yy) - math.hypot(0.5 * (xx - yy), xy)
    return max(least, 0.0), 0.5 * math.atan2(2.0 * xy, xx - yy)


@callee()
def split_discs(points: Floats, origin: Floats, prior: DiscPrior) -> int:
    """Index at which two touching bodies in one run are split; 0 if one shape explains it as well.

    Arguments as for :func:`fit_disc`.
    """
    m = points.shape[0]
    misfit = fit_disc(points, origin, prior).misfit
    single = min(disc_evidence(misfit, m), clutter_evidence(misfit, m))
    single = min(single, flat_evidence(points, prior.noise))
    best, split = single - SPLIT_GAIN, 0
    # At most 24 candidate cuts bound the time on wide runs.
    for cut in range(2, m - 1, max(1, m // 24)):
        first = fit_disc(points[:cut], origin, prior).misfit
        second = fit_disc(points[cut:], origin, prior).misfit
        both = first + second + 5.0 * math.log(m)
        if both < best:
            best, split = both, cut
    return split
