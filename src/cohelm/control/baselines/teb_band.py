"""Bands of poses and times: along the reference, shifted, around a person, resized."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.control.api import LocalProblem
from cohelm.kernels import CACHED
from cohelm.robots.wall_contact import WallGrid

_STALE = 0.5
"""A band older than this is dropped, s."""
_FEWEST, _ROWS = 4, 60
"""Smallest and largest number of poses of a band."""
_NEAR = 0.5
"""Gap from a person below which a band is bent, m."""


@value
class Band:
    """Memory of the planner."""

    time: float
    """Time of the plan, s."""
    rows: Annotated[Floats, Shape("n 4")]
    """(x, y, θ, time to the next pose)."""
    side: float
    """Side of the person in the way: 1 left, −1 right, 0 as drawn."""
    other: Annotated[Floats, Shape("k 4")]
    """The band on the other side, continued by the next call; empty: there is none."""


class BandWeights(NamedTuple):
    """Budget and weights; see ``Teb.Parameters``."""

    outer: int
    inner: int
    interval: float
    tolerance: float
    time: float
    kinematics: float
    speed: float
    acceleration: float
    obstacles: float
    inflated: float
    path: float
    goal: float
    growth: float


class BandLimits(NamedTuple):
    """Limits of the robot."""

    low: float
    """Lowest speed, m/s."""
    high: float
    """Highest speed, m/s."""
    turn: float
    """rad/s."""
    acceleration: float
    """m/s²."""
    braking: float
    """m/s²."""
    turn_acceleration: float
    """rad/s²."""
    margin: float
    """Share of the speeds that is not used."""


class BandProblem(NamedTuple):
    """Everything that a band is optimised for."""

    limits: BandLimits
    twist: Floats
    """(3,) measured twist."""
    end_speed: float
    """At the end, m/s; NaN: any."""
    goal: Floats
    """(3,)."""
    path: Floats
    """(k, 2)."""
    holonomic: bool
    capsule: Floats
    discs: Floats
    """Footprint, as in ``Robot``."""
    wall_gap: float
    """Minimum gap to walls, m."""
    people_gap: float
    """Minimum gap to people, m."""
    inflation: float
    """Gap beyond these that has a cost, m."""
    people: Floats
    """(p, N+1, 2) predicted positions; people stay at the last one."""
    radius: Floats
    """(p,) m."""
    person_step: float
    """s."""
    walls: WallGrid


def band_along_reference(problem: LocalProblem, interval: float) -> Floats:
    """A band along the reference, with its timing."""
    poses, step = problem.reference.poses, problem.reference.step
    every = max(round(interval / step), 1)
    picks = np.unique([*range(0, len(poses), every), len(poses) - 1])
    if len(picks) < _FEWEST:
        picks = np.unique(np.linspace(0, len(poses) - 1, _FEWEST).round().astype(int))
    rows = np.column_stack([poses[picks], np.append(np.diff(picks) * step, interval)])
    rows[0, :3] = problem.pose
    return rows


def shifted_band(problem: LocalProblem, old: Band, rows: Floats) -> Floats | None:
    """One of the last bands from the robot on; None if it is too old, too short or elsewhere."""
    if not 0.0 <= problem.time - old.time <= _STALE:
        return None
    rows, goal = rows.copy(), problem.reference.poses[-1]
    if len(rows) < _FEWEST or np.hypot(*(rows[-1, :2] - goal[:2])) > 1.0:
        return None
    near = np.hypot(*(rows[: min(4, len(rows) - _FEWEST + 1), :2] - problem.pose[:2]).T)
    rows = rows[int(np.argmin(near)) :]
    if len(rows) < _FEWEST:
        return None
    turn = 2.0 * math.pi * round(float(problem.pose[2] - rows[0, 2]) / (2.0 * math.pi))
    rows[:, 2] += turn
    rows[0, :3] = problem.pose
    return rows


def band_around_person(problem: LocalProblem, rows: Floats, side: float) -> Floats | None:
    """The band bent around the first person near it, on one side; None if no person is near."""
    mean, radius = problem.predictions.mean[:, 0], problem.people.radius
    if not len(radius):
        return None
    times = np.append(0.0, np.cumsum(rows[:-1, 3]))
    steps = np.clip((times / problem.predictions.step).astype(int), 0, mean.shape[1] - 1)
    offset = mean[:, steps] - rows[None, :, :2]
    gap = np.hypot(offset[..., 0], offset[..., 1]) - radius[:, None]
    near = problem.robot.capsule[4] + _NEAR
    close = np.argwhere(gap < near)
    if not len(close):
        return None
    person, k = close[int(np.argmin(close[:, 1]))]
    normal = side * np.array([-math.sin(rows[k, 2]), math.cos(rows[k, 2])])
    needed = max(near + radius[person] + float(offset[person, k] @ normal), 0.0)
    s = np.append(0.0, np.cumsum(np.hypot(*np.diff(rows[:, :2], axis=0).T)))
    bump = np.exp(-0.5 * ((s - s[k]) / 0.8) ** 2)
    bump *= np.minimum(s / max(s[k], 0.1), 1.0)
    out = rows.copy()
    out[:, :2] += (needed * bump)[:, None] * normal
    legs = np.diff(out[:, :2], axis=0)
    lengths, before = np.hypot(*legs.T), np.diff(s)
    out[:-1, 3] *= np.clip(lengths / np.maximum(before, 1e-3), 1.0, 3.0)
    tangent = np.unwrap(np.append(rows[0, 2], np.arctan2(legs[:, 1], legs[:, 0])))
    out[1:-1, 2] = 0.5 * (tangent[1:-1] + tangent[2:])
    return out


def twists(rows: Floats, holonomic: bool) -> Floats:
    """(v_x, v_y, ω) (n − 1, 3) of a band's intervals, in the frame of their middles."""
    change = np.diff(rows[:, :3], axis=0) / rows[:-1, 3:]
    middle = rows[:-1, 2] + 0.5 * np.diff(rows[:, 2])
    cos, sin = np.cos(middle), np.sin(middle)
    vx = cos * change[:, 0] + sin * change[:, 1]
    vy = cos * change[:, 1] - sin * change[:, 0] if holonomic else np.zeros_like(vx)
    return np.column_stack([vx, vy, change[:, 2]])


@njit(**CACHED)
def resized(band: Floats, wanted: float, tolerance: float) -> Floats:
    """The band with long intervals split and short ones joined."""
    out = np.empty((_ROWS, 4))
    count = 0
    n = band.shape[0]
    for k in range(n):
        last = k == n - 1
        joined = count > 0 and 0 < k < n - 1 and out[count - 1, 3] < wanted - tolerance
        if joined and n > 3 and out[count - 1, 3] + band[k, 3] < wanted + tolerance:
            out[count - 1, 3] += band[k, 3]
            continue
        for i in range(4):
            out[count, i] = band[k, i]
        count += 1
        if not last and band[k, 3] > wanted + tolerance and count + n - k < _ROWS:
            out[count - 1, 3] = 0.5 * band[k, 3]
            for i in range(3):
                out[count, i] = 0.5 * (band[k, i] + band[k + 1, i])
            out[count, 3] = 0.5 * band[k, 3]
            count += 1
    return out[:count].copy()
