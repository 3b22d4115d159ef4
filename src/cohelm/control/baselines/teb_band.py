"""The timed elastic band's optimisation: Levenberg steps on a banded system, compiled.

A band is an array (n, 4): poses x, y, θ, and in the last column the time to the next one. A term
touches at most three neighbouring rows, so the normal equations have half a bandwidth of 11.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.baselines.dwa_critics import beside
from cohelm.control.baselines.teb_steps import BAND, resized, solved
from cohelm.maps.distance import sample
from cohelm.robots.contact import nearest_on_spine

_EDGE = 14
"""Residuals of the terms between neighbours."""
_NEXT_X, _NEXT_Y = 4, 5
"""Of an interval's variables those that place its end."""
_TINY, _LEAST_TIME = 1e-6, 0.02
_FAR = 4.0
"""People farther from a pose are not looked at, m."""
_PATIENCE = 1e-3
"""An iteration that gains less than this share of the cost is the last."""


@njit(cache=True)
def optimise(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    band: Floats,
    iterations: Floats,
    times: Floats,
    weights: Floats,
    limits: Floats,
    ends: Floats,
    path: Floats,
    holonomic: bool,
    capsule: Floats,
    discs: Floats,
    gaps: Floats,
    people: Floats,
    radius: Floats,
    person_step: float,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
) -> tuple[Floats, float]:
    """(the band that is the nearest local optimum, its cost).

    Args:
        band: (n, 4), to begin with; its first pose stays.
        iterations: (outer, inner); before each outer one the band gets poses as it needs them, and
            after it obstacles count ``weights[8]`` times as much.
        times: wanted between poses and its tolerance, s.
        weights: of (time, kinematics, speed, acceleration, obstacles, inflation, path, goal, growth
            of the obstacles').
        limits: least and greatest v, greatest ω, acceleration, braking, α, and a margin as a share.
        ends: (v_x, v_y, ω now; wanted speed at the end, NaN: any; goal x, y, θ).
        path: (k, 2).
        holonomic: whether the robot can move sideways.
        capsule, discs: the footprint, as in ``Robot``.
        gaps: least to walls and to people, and how far beyond inflation counts, m.
        people, radius, person_step: predicted bodies (p, N+1, 2), (p,), s; they stay at the end.
        distance, resolution, X_MG: the walls' distance field.
    """
    heavy = weights.copy()
    cost, damping = np.inf, 1.0
    for _ in range(int(iterations[0])):
        band = resized(band, times[0], times[1])
        n = band.shape[0]
        trial, cost = band.copy(), np.inf
        matrix, right = np.zeros((4 * n, BAND)), np.zeros(4 * n)
        new_matrix, new_right = np.zeros((4 * n, BAND)), np.zeros(4 * n)
        for i in range(int(iterations[1]) + 1):
            if i > 0:
                _move(band, solved(matrix, right, damping), trial)
            new = _assembled(
                trial, new_matrix, new_right, heavy, limits, ends, path, holonomic, capsule, discs,
                gaps, people, radius, person_step, distance, resolution, X_MG,
            )  # fmt: skip
            if new >= cost:
                damping *= 5.0
                continue
            gain = cost - new
            band, trial = trial, band
            matrix, new_matrix, right, new_right = new_matrix, matrix, new_right, right
            cost = new
            if i > 0:
                damping = max(0.3 * damping, 1e-4)
            if gain < _PATIENCE * cost:
                break
        heavy[4] *= weights[8]
    return band, cost


@njit(cache=True)
def _move(band: Floats, step: Floats, out: Floats) -> None:
    """``band`` less a step (4n,), into ``out``."""
    for k in range(band.shape[0]):
        for i in range(4):
            out[k, i] = band[k, i] - step[4 * k + i]
        out[k, 3] = max(out[k, 3], _LEAST_TIME)


@njit(cache=True)
def _assembled(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    band: Floats,
    matrix: Floats,
    right: Floats,
    weights: Floats,
    limits: Floats,
    ends: Floats,
    path: Floats,
    holonomic: bool,
    capsule: Floats,
    discs: Floats,
    gaps: Floats,
    people: Floats,
    radius: Floats,
    person_step: float,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
) -> float:
    """½ of the sum of squared residuals; JᵀJ and Jᵀr in place.

    The large kernels are called at one place each: they would be compiled again for every other.
    """
    n = band.shape[0]
    matrix.fill(0.0)
    right.fill(0.0)
    cost = _smoothness(band, matrix, right, weights, limits, ends, path, holonomic)
    slope, time, bodies = np.zeros(BAND), 0.0, people.shape[0]
    for k in range(1, n):
        time += band[k - 1, 3]
        cos, sin = math.cos(band[k, 2]), math.sin(band[k, 2])
        share = min(time / person_step, people.shape[1] - 1.0)
        m = min(int(share), people.shape[1] - 2)
        share -= m
        for j in range(bodies + discs.shape[0]):
            if j < bodies:
                x = people[j, m, 0] + share * (people[j, m + 1, 0] - people[j, m, 0])
                y = people[j, m, 1] + share * (people[j, m + 1, 1] - people[j, m, 1])
                if math.hypot(x - band[k, 0], y - band[k, 1]) > _FAR:
                    continue
                d, nx, ny, ax, ay, _ = nearest_on_spine(capsule, band[k], x, y)
                slope[0], slope[1], slope[2] = -nx, -ny, -(nx * ax + ny * ay)
                gap, least = d - capsule[4] - radius[j], gaps[1]
            else:
                disc = discs[j - bodies]
                ax, ay = cos * disc[0] - sin * disc[1], sin * disc[0] + cos * disc[1]
                d, gx, gy = sample(distance, resolution, X_MG, band[k, 0] + ax, band[k, 1] + ay)
                slope[0], slope[1], slope[2] = gx, gy, -gx * ay + gy * ax
                gap, least = d - disc[2], gaps[0]
            hard, soft = max(least - gap, 0.0), max(least + gaps[2] - gap, 0.0)
            if soft > 0.0:
                # both terms have the slope of the gap: together one row
                price = weights[5] + (weights[4] if hard > 0.0 else 0.0)
                cost += 0.5 * (weights[4] * hard * hard + weights[5] * soft * soft)
                root = math.sqrt(price)
                for i in range(3):
                    slope[i] *= -root
                pull = (weights[4] * hard + weights[5] * soft) / root
                _add(matrix, right, 4 * k, slope, 3, pull)
    return cost


@njit(cache=True)
def _smoothness(  # noqa: PLR0917  # a kernel takes plain arrays
    band: Floats,
    matrix: Floats,
    right: Floats,
    weights: Floats,
    limits: Floats,
    ends: Floats,
    path: Floats,
    holonomic: bool,
) -> float:
    """The terms between neighbours, their slopes by forward differences."""
    n, cost = band.shape[0], 0.0
    residual, moved = np.zeros(_EDGE), np.zeros(_EDGE)
    slopes, place = np.zeros((_EDGE, BAND)), np.zeros((3, 4))
    for k in range(n - 1):
        size = 4 * min(3, n - k)
        for v in range(size):
            place[v // 4, v % 4] = band[k + v // 4, v % 4]
        _, _, x, y = beside(path, place[1, 0], place[1, 1])
        for v in range(-1, size):
            if v >= 0:
                place[v // 4, v % 4] += _TINY
            if v in (_NEXT_X, _NEXT_Y):  # no other variable changes the nearest point of the path
                _, _, near_x, near_y = beside(path, place[1, 0], place[1, 1])
            else:
                near_x, near_y = x, y
            _edge(place, k, n, weights, limits, ends, near_x, near_y, holonomic, moved)
            if v >= 0:
                place[v // 4, v % 4] = band[k + v // 4, v % 4]
            for e in range(_EDGE):
                if v < 0:
                    residual[e] = moved[e]
                else:
                    slopes[e, v] = (moved[e] - residual[e]) / _TINY
        for e in range(_EDGE):
            cost += 0.5 * residual[e] * residual[e]
            if residual[e] != 0.0:
                _add(matrix, right, 4 * k, slopes[e], size, residual[e])
    return cost


@njit(cache=True)
def _add(
    matrix: Floats, right: Floats, first: int, slope: Floats, size: int, residual: float
) -> None:
    """One residual into JᵀJ and Jᵀr; ``slope`` is to ``size`` variables from ``first`` on."""
    for a in range(size):
        if slope[a] == 0.0:
            continue
        right[first + a] += slope[a] * residual
        for b in range(a + 1):
            matrix[first + a, a - b] += slope[a] * slope[b]


@njit(cache=True)
def _edge(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    rows: Floats,
    k: int,
    n: int,
    weights: Floats,
    limits: Floats,
    ends: Floats,
    near_x: float,
    near_y: float,
    holonomic: bool,
    out: Floats,
) -> None:
    """Residuals (14,) of the interval from pose ``k`` to the next one, and to the one after.

    near_x, near_y: the point of the path that is nearest to the next one.
    """
    out.fill(0.0)
    vx, vy, w = _velocity(rows, 0, holonomic)
    dt = rows[0, 3]
    out[0] = math.sqrt(weights[0] * max(dt, 1e-3))  # their sum is the time
    if not holonomic:  # Rösmann et al. 2012, eq. (8): both poses on one arc
        dx, dy = rows[1, 0] - rows[0, 0], rows[1, 1] - rows[0, 1]
        cos = math.cos(rows[0, 2]) + math.cos(rows[1, 2])
        sin = math.sin(rows[0, 2]) + math.sin(rows[1, 2])
        out[1] = math.sqrt(weights[1]) * (cos * dy - sin * dx)
    root = math.sqrt(weights[2])
    margin = 1.0 - limits[6]
    if holonomic:
        out[2] = root * _beyond(math.sqrt(vx * vx + vy * vy + 1e-12), -1.0, margin * limits[1])
    else:
        out[2] = root * _beyond(vx, limits[0], margin * limits[1])
    out[3] = root * _beyond(w, -margin * limits[2], margin * limits[2])
    root = math.sqrt(weights[3])
    if k == 0:
        out[4] = root * _change(ends[0], vx, 0.5 * dt, limits)
        out[5] = root * _beyond((w - ends[2]) / (0.5 * dt), -limits[5], limits[5])
        if holonomic:
            out[6] = root * _change(ends[1], vy, 0.5 * dt, limits)
    if k < n - 2:
        vx2, vy2, w2 = _velocity(rows, 1, holonomic)
        between = 0.5 * (dt + rows[1, 3])
        out[7] = root * _change(vx, vx2, between, limits)
        out[8] = root * _beyond((w2 - w) / between, -limits[5], limits[5])
        if holonomic:
            out[9] = root * _change(vy, vy2, between, limits)
    if k == n - 2:
        root = math.sqrt(weights[7])
        out[10], out[11] = root * (rows[1, 0] - ends[4]), root * (rows[1, 1] - ends[5])
        out[12] = 0.3 * root * (rows[1, 2] - ends[6])
        if not math.isnan(ends[3]):
            speed = math.sqrt(vx * vx + vy * vy + 1e-12)
            out[13] = math.sqrt(weights[3]) * _change(speed, ends[3], 0.5 * dt, limits)
    else:
        root = math.sqrt(weights[6])
        out[10], out[11] = root * (rows[1, 0] - near_x), root * (rows[1, 1] - near_y)


@njit(cache=True)
def _velocity(rows: Floats, k: int, holonomic: bool) -> tuple[float, float, float]:
    """(v_x, v_y, ω) of the interval that begins at ``rows[k]``, in its middle's frame."""
    dt = max(rows[k, 3], 1e-3)
    dx, dy = rows[k + 1, 0] - rows[k, 0], rows[k + 1, 1] - rows[k, 1]
    turn = rows[k + 1, 2] - rows[k, 2]
    middle = rows[k, 2] + 0.5 * turn
    cos, sin = math.cos(middle), math.sin(middle)
    sideways = (-sin * dx + cos * dy) / dt if holonomic else 0.0
    return (cos * dx + sin * dy) / dt, sideways, turn / dt


@njit(cache=True)
def _beyond(x: float, low: float, high: float) -> float:
    """By how much x is outside [low, high]."""
    return max(x - high, 0.0) - max(low - x, 0.0)


@njit(cache=True)
def _change(before: float, after: float, time: float, limits: Floats) -> float:
    """By how much the acceleration goes beyond what the robot may do, m/s²."""
    sign = 1.0 if before + after >= 0.0 else -1.0
    return _beyond(sign * (after - before) / max(time, 1e-3), -limits[4], limits[3])
