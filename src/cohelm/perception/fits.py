"""What a cluster of returns can be: a disc (a body), a face, a corner, or clutter.

Each model gives −2 log-likelihood of the points (m, 2) up to a constant they share, range noise σ
being independent normal across the surface, plus ln m a parameter (the Bayesian information
criterion), so that models with more parameters must earn them. Points are in beam order.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats

LOOSE = 4.0
"""Clutter lies this many σ from a disc."""


@njit(cache=True)
def fit_disc(
    points: Floats, origin: Floats, radius: float, radius_deviation: float, noise: float
) -> tuple[float, float, float, float, float]:
    """The most probable disc behind the returns, for a radius known in advance to some degree.

    Minimises Σ((|pᵢ − c| − r)/σ)² + ((r − r₀)/σ_r)² by Gauss-Newton, started 0.8 of the radius
    behind the points' mean. A weak prior (0.3 m) at that start keeps one or two points solvable.

    Args:
        points: (m, 2), m ≥ 1, m.
        origin: (2,) the sensor, m.
        radius, radius_deviation: r₀ and σ_r, m.
        noise: σ, m.

    Returns:
        (x, y, r, misfit, deviation): centre and radius, m; the minimum without the weak prior;
        standard deviation of the centre along its worse axis, m.
    """
    m = points.shape[0]
    mx, my = points[:, 0].mean(), points[:, 1].mean()
    ux, uy = mx - origin[0], my - origin[1]
    scale = 0.8 * radius / max(math.hypot(ux, uy), 1e-9)
    sx, sy = mx + scale * ux, my + scale * uy
    x, y, r = sx, sy, radius
    wp, wr, ws = 1.0 / noise**2, 1.0 / radius_deviation**2, 1.0 / 0.3**2
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
        # r is eliminated first: what is left is the centre's own information.
        axx, axy, ayy = hxx - hxr * hxr / hrr, hxy - hxr * hyr / hrr, hyy - hyr * hyr / hrr
        bx, by = gx - hxr * gr / hrr, gy - hyr * gr / hrr
        det = axx * ayy - axy * axy
        px, py = -(ayy * bx - axy * by) / det, -(axx * by - axy * bx) / det
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
    return x, y, r, misfit, 1.0 / math.sqrt(weaker)


@njit(cache=True)
def disc_evidence(misfit: float, count: int) -> float:
    """−2 log-evidence of a disc with this misfit: a centre, and a radius that has its prior."""
    return misfit + 2.0 * math.log(count)


@njit(cache=True)
def clutter_evidence(misfit: float, count: int) -> float:
    """−2 log-evidence of points strewn about a disc with a deviation of ``LOOSE``·σ."""
    return misfit / LOOSE**2 + 2.0 * count * math.log(LOOSE) + 2.0 * math.log(count)


@njit(cache=True)
def flat_evidence(points: Floats, noise: float) -> float:
    """−2 log-evidence of the better of a flat face and a convex right-angled corner of two faces.

    The corner's angle may be off by about 10° (as with four points and noise); every cut of the
    points into two runs of at least two is tried, by prefix sums.
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
    best = w * _line(sums, 0, m)[0] + 2.0 * log_m
    for cut in range(2, m - 1):
        left, right = _line(sums, 0, cut), _line(sums, cut, m)
        turn = left[1] - right[1]
        off = (turn - math.pi * math.floor(turn / math.pi) - 0.5 * math.pi) / math.radians(10.0)
        corner = w * (left[0] + right[0]) + off * off + 4.0 * log_m
        best = min(best, corner)
    return best


@njit(cache=True)
def _line(sums: Floats, start: int, stop: int) -> tuple[float, float]:
    """(sum of squared distances to the best line, its direction) of a run of points."""
    n = stop - start
    mx = (sums[stop, 0] - sums[start, 0]) / n
    my = (sums[stop, 1] - sums[start, 1]) / n
    xx = sums[stop, 2] - sums[start, 2] - n * mx * mx
    xy = sums[stop, 3] - sums[start, 3] - n * mx * my
    yy = sums[stop, 4] - sums[start, 4] - n * my * my
    least = 0.5 * (xx + yy) - math.hypot(0.5 * (xx - yy), xy)
    return max(least, 0.0), 0.5 * math.atan2(2.0 * xy, xx - yy)
