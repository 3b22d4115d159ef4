"""Ways round that are sampled: arcs, the best of which the SQP starts from.

A gradient method stays on one side of a person; arcs of two segments look at the other ways round.
They are scored by a coarse cost of their own: enough to rank them, and cheap.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Floats32
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.constraints.series import flattened
from cohelm.control.warm_start import followed
from cohelm.maps.distance import sample
from cohelm.robots.contact import nearest_on_spine

_TERMINAL, _HEADING, _SPEED, _TURN = 4.0, 0.3, 0.8, 0.25
"""Weights of the coarse cost, after the defaults of the cost terms."""
_TOUCH, _CROWD = 60.0, 6.0
"""Prices of a touch and of a personal space entered, 1/m."""
_MARGIN, _GROWTH, _GREATEST = 0.1, 0.08, 0.35
"""Gap kept to people now, m, its growth, m/s, and its bound, m: those of ``Bodies``."""
_CREEP = 0.3
"""Arcs are tried up to this speed even where the reference stands, m/s."""


def best_arcs(problem: LocalProblem, now: Floats, count: int) -> Iterator[Motion]:
    """The ``count`` sampled arcs with the least coarse cost, best first."""
    reference, robot = problem.reference, problem.robot
    steps = len(reference.poses) - 1
    low, high, rise, fall = problem.input_bounds()
    targets = _targets()
    scaled = targets.copy()
    scaled[:, :, 0] *= min(problem.speed_limit, high[0], max(float(reference.speeds.max()), _CREEP))
    scaled[:, :, 1] *= high[1]
    scaled = np.clip(scaled, low, high)
    costs = _coarse_costs(
        scaled,
        now,
        rise,
        fall,
        problem.pose,
        reference.step,
        reference.poses,
        reference.speeds,
        robot.capsule,
        robot.discs,
        flattened(problem.predictions.mean),
        np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
        problem.spaces.floor,
        problem.walls.distance,
        problem.walls.resolution,
        problem.walls.X_MG,
        problem.profile.clearance,
        count == 1,
    )
    for best in np.argsort(costs, kind="stable")[:count]:
        inputs = _ramped(scaled[best], steps, now, rise * reference.step, fall * reference.step)
        yield followed(problem, inputs, now)


@functools.cache
def _targets() -> Floats:
    """Targets (a, 2, 2) of (v, ω) for the two halves, as shares of the limits."""
    speeds = (0.0, 0.5, 1.0)
    turns = (-0.8, -0.4, -0.2, 0.0, 0.2, 0.4, 0.8)
    arcs = [[(v, w), (v, back * w)] for v in speeds for w in turns for back in (1.0, 0.0, -1.0)]
    arcs += [[(0.3, w), (1.0, 0.0)] for w in turns]
    arcs += [[(1.0, w), (0.0, 0.0)] for w in turns]
    arcs += [[(-0.3, w), (0.0, 0.0)] for w in turns]
    return np.array(arcs)


@njit(cache=True)
def _ramped(target: Floats, steps: int, now: Floats, rise: Floats, fall: Floats) -> Floats:
    """Inputs (steps, m) that go to the first, then to the second target (2, m)."""
    out = np.empty((steps, target.shape[1]))
    for i in range(target.shape[1]):
        before = now[i]
        for k in range(steps):
            wanted = target[0 if 2 * k < steps else 1, i]
            before = min(max(wanted, before - fall[i]), before + rise[i])
            out[k, i] = before
    return out


@njit(cache=True)
def _coarse_costs(  # noqa: PLR0913, PLR0917  # a kernel takes plain arrays
    targets: Floats,
    now: Floats,
    rise: Floats,
    fall: Floats,
    start: Floats,
    step: float,
    reference: Floats,
    speeds: Floats,
    capsule: Floats,
    discs: Floats,
    positions: Floats,
    radius: Floats,
    floor: float,
    distance: Floats32,
    resolution: float,
    X_MG: Floats,
    clearance: float,
    only_best: bool,
) -> Floats:
    """The coarse cost (a,) of every arc; a lower bound of it where only the best one counts."""
    steps = reference.shape[0] - 1
    costs = np.empty(targets.shape[0])
    least = np.inf
    pose = np.empty(3)
    nearest = np.empty(positions.shape[0])
    for a in range(targets.shape[0]):
        inputs = _ramped(targets[a], steps, now, rise * step, fall * step)
        pose[:] = start
        nearest[:] = np.inf
        cost, wall = 0.0, np.inf
        for k in range(steps):
            v, w = inputs[k, 0], inputs[k, 1]
            pose[0] += step * v * math.cos(pose[2])
            pose[1] += step * v * math.sin(pose[2])
            pose[2] += step * w
            dx = pose[0] - reference[k + 1, 0]
            dy = pose[1] - reference[k + 1, 1]
            dh = pose[2] - reference[k + 1, 2]
            dv = v - speeds[k]
            weight = step if k < steps - 1 else _TERMINAL
            cost += 0.5 * weight * (dx * dx + dy * dy + _HEADING * dh * dh)
            cost += 0.5 * step * (_SPEED * dv * dv + _TURN * w * w)
            if only_best and cost >= least:
                break
            if k % 3 != 2:
                continue
            for i in range(positions.shape[0]):
                x, y = positions[i, k + 1, 0], positions[i, k + 1, 1]
                d = nearest_on_spine(capsule, pose, x, y)[0]
                margin = min(_MARGIN + _GROWTH * (k + 1) * step, _GREATEST)
                gap = d - capsule[4] - radius[i] - margin
                nearest[i] = min(nearest[i], gap)
            cos, sin = math.cos(pose[2]), math.sin(pose[2])
            for j in range(discs.shape[0]):
                x = pose[0] + cos * discs[j, 0] - sin * discs[j, 1]
                y = pose[1] + sin * discs[j, 0] + cos * discs[j, 1]
                gap = sample(distance, resolution, X_MG, x, y)[0] - discs[j, 2] - clearance
                wall = min(wall, gap)
        if wall < 0.0:
            cost -= _TOUCH * wall
        for i in range(positions.shape[0]):
            if nearest[i] < 0.0:
                cost -= _TOUCH * nearest[i]
            if nearest[i] < floor:
                cost += _CROWD * (floor - nearest[i])
        costs[a] = cost
        least = min(least, cost)
    return costs
