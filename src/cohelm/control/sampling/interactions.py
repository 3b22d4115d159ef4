"""Costs of an arc at one pose: kernels for walls, people, personal spaces and groups."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.sampling.scene import GroupHulls, PersonHypotheses, RobotState, RolloutWalls
from cohelm.maps.distance import sample

_ROUNDING = 1e-9
"""m."""


@njit(cache=True, error_model="numpy")
def missing_clearance(  # a kernel takes plain values
    walls: RolloutWalls, robot: RobotState, x: float, y: float, angle: float, clearance: float
) -> tuple[float, bool, float]:
    """(free distance, whether a wall is touched, squared missing share of the clearance)."""
    grid, discs = walls.grid, robot.discs
    # the robot's circle first: where it is clear, all discs are
    free = (
        sample(grid.distance, grid.resolution, grid.X_MG, x, y)[0] - robot.outer_radius - clearance
    )
    if free > 0.0:
        return free, False, 0.0
    nearest = np.inf
    cos, sin = math.cos(angle), math.sin(angle)
    for j in range(discs.shape[0]):
        u = x + cos * discs[j, 0] - sin * discs[j, 1]
        v = y + sin * discs[j, 0] + cos * discs[j, 1]
        gap = sample(grid.distance, grid.resolution, grid.X_MG, u, v)[0] - discs[j, 2]
        if gap < walls.margin[j]:
            return 0.0, True, 0.0
        nearest = min(nearest, gap)
    missing = max(clearance - nearest, 0.0) / max(clearance, 1e-6)
    return 0.0, False, missing * missing


@njit(cache=True, error_model="numpy")
def capsule_gap(capsule: Floats, angle: float, dx: float, dy: float) -> tuple[float, float, float]:
    """(gap between the robot's capsule and a point at (dx, dy) from the pose, unit vector to it).

    Faster than ``robots.capsule``, and less smooth at the spine: it serves no gradient.
    """
    cos, sin = math.cos(angle), math.sin(angle)
    qx, qy = cos * dx + sin * dy - capsule[0], cos * dy - sin * dx - capsule[1]
    bx, by = capsule[2] - capsule[0], capsule[3] - capsule[1]
    square = bx * bx + by * by
    t = min(max((qx * bx + qy * by) / square, 0.0), 1.0) if square > 0.0 else 0.0
    ex, ey = qx - t * bx, qy - t * by
    d = math.sqrt(ex * ex + ey * ey + 1e-12)
    ex, ey = ex / d, ey / d
    return d - capsule[4], cos * ex - sin * ey, sin * ex + cos * ey


@njit(cache=True, error_model="numpy")
def space_intrusion(
    people: PersonHypotheses, state: Floats, gap: float, nx: float, ny: float
) -> float:
    """Squared share of intrusion into a personal space; (nx, ny) points to the person.

    state: (8,) of ``PersonHypotheses.states``.
    """
    # of the direction to the robot from the person's axis of motion
    cos = -(nx * state[2] + ny * state[3])
    cos2 = cos * cos
    q = (state[4] if cos > 0.0 else state[5]) * cos2 + state[6] * (1.0 - cos2)
    extent = people.scale / q if people.printed else math.sqrt(people.scale / q)
    extent = max(extent, people.floor)
    share = max(extent - gap, 0.0) / extent if extent > 0.0 else 0.0
    return share * share


@njit(cache=True, error_model="numpy")
def depth_in_hulls(
    groups: GroupHulls, capsule: Floats, x: float, y: float, angle: float, k: int
) -> float:
    """Sum of squared depths of the robot's centre, grown by its half width, in hulls, m²."""
    # discs about the hulls skip all groups that are far away
    mx, my = 0.5 * (capsule[0] + capsule[2]), 0.5 * (capsule[1] + capsule[3])
    near, robot_radius = False, math.sqrt(mx * mx + my * my) + capsule[4] + _ROUNDING
    for g in range(groups.support.shape[0]):
        dx, dy = x - groups.disc[g, k, 0], y - groups.disc[g, k, 1]
        reach = groups.disc[g, k, 2] + robot_radius
        near |= dx * dx + dy * dy < reach * reach
    if not near:
        return 0.0
    # the depth is the shortest distance to the border along any normal
    cos, sin = math.cos(angle), math.sin(angle)
    x, y = x + cos * mx - sin * my, y + sin * mx + cos * my
    total = 0.0
    for g in range(groups.support.shape[0]):
        dx, dy = x - groups.disc[g, k, 0], y - groups.disc[g, k, 1]
        reach = groups.disc[g, k, 2] + capsule[4]
        if dx * dx + dy * dy >= reach * reach:
            continue
        depth = np.inf
        for j in range(groups.normal.shape[0]):
            inner = groups.support[g, k, j] - x * groups.normal[j, 0] - y * groups.normal[j, 1]
            depth = min(depth, inner + capsule[4])
            if depth <= 0.0:
                break
        if depth > 0.0:
            total += depth * depth
    return total
