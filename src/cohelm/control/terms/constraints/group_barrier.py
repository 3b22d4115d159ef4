"""Barrier on groups: the robot does not pass between people who belong together."""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
from cohelm.control.terms.constraints import barrier
from cohelm.messages import GroupSpaces


class GroupBarrier:
    """h = distance of the footprint's capsule to the hull of a group at each step; see ``shapes``.

    The hull is given by its support s(u), the capsule by the ends a and b of its spine and its
    radius r,

        h = max_u min(a·u, b·u) − s(u) − r,

    the largest gap between the two along any direction u: at most their distance outside, and
    inside, as a negative number, the shortest distance to the border. In that direction a robot
    inside a group must leave it, by a share γ of the distance per step.
    """

    class Parameters(Model):
        """Barrier and weights, assumed; lower than those of a person's space."""

        gamma: float = Field(0.2, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        l1: float = Field(2.0, ge=0.0)
        """Weight of the slack, 1/m per group."""
        l2: float = Field(2.0, ge=0.0)
        """Weight of the squared slack, 1/m² per group."""

    name = "group_space"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Largest violation by group, over steps, (g,)."""
        groups = problem.spaces.groups
        if groups is None or not len(groups.id):
            return ConstraintValues(slack=np.empty(0))
        capsule, gamma = problem.robot.capsule, self.parameters.gamma
        h = group_barrier(capsule, trajectory.poses, _normals(groups), groups.support)
        layout = barrier.separate_slacks(len(h))
        slack, smallest = barrier.largest_violations(h, gamma, layout)
        return ConstraintValues(slack=slack, smallest=smallest, h=h)

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """The rows that can become active."""
        groups, h, gradient = problem.spaces.groups, values.h, values.gradient
        gamma, layout = self.parameters.gamma, barrier.separate_slacks(len(values.h))
        if groups is not None and len(h):
            near = barrier.near_states(h, gamma, barrier.NEAR)
            capsule, normals = problem.robot.capsule, _normals(groups)
            gradient = group_gradient(capsule, trajectory.poses, normals, groups.support, near)
        rows = barrier.linearise_dcbf(h, gradient, sensitivity, gamma, barrier.NEAR, layout)
        return barrier.constraint_rows(rows, layout, h.shape[1])


@functools.lru_cache(maxsize=16)
def _normals(groups: GroupSpaces) -> Floats:
    """(m, 2) unit vectors of the directions."""
    return np.stack([np.cos(groups.direction), np.sin(groups.direction)], axis=-1)


@njit(cache=True)
def group_barrier(capsule: Floats, poses: Floats, normals: Floats, support: Floats) -> Floats:
    """Barrier values h (g, N+1) of g groups.

    capsule: as ``Robot.capsule``.  poses: (N+1, 3).  normals: (m, 2).  support: (g, N+1, m).
    """
    h = np.empty(support.shape[:2])
    for k in range(poses.shape[0]):
        ends = _ends(capsule, poses[k])
        for i in range(support.shape[0]):
            h[i, k] = _largest_gap(ends, normals, support[i, k])[0] - capsule[4]
    return h


@njit(cache=True)
def group_gradient(
    capsule: Floats, poses: Floats, normals: Floats, support: Floats, near: Booleans
) -> Floats:
    """∂h/∂pose (g, N+1, 3) of ``group_barrier``, 0 except at ``near`` (g, N+1).

    Along u, and about the robot with the arm of the end of the spine nearer to the hull.
    """
    out = np.zeros((support.shape[0], support.shape[1], 3))
    for k in range(poses.shape[0]):
        ends = _ends(capsule, poses[k])
        for i in range(support.shape[0]):
            if not near[i, k]:
                continue
            _, j = _largest_gap(ends, normals, support[i, k])
            ux, uy = normals[j, 0], normals[j, 1]
            first = ends[0] * ux + ends[1] * uy < ends[2] * ux + ends[3] * uy
            x, y = (ends[0], ends[1]) if first else (ends[2], ends[3])
            out[i, k, 0], out[i, k, 1] = ux, uy
            out[i, k, 2] = (x - poses[k, 0]) * uy - (y - poses[k, 1]) * ux
    return out


@njit(cache=True, inline="always")
def _ends(capsule: Floats, pose: Floats) -> tuple[float, float, float, float]:
    """(x, y) of both ends of the spine in the map frame."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return (
        pose[0] + cos * capsule[0] - sin * capsule[1],
        pose[1] + sin * capsule[0] + cos * capsule[1],
        pose[0] + cos * capsule[2] - sin * capsule[3],
        pose[1] + sin * capsule[2] + cos * capsule[3],
    )


@njit(cache=True, inline="always")
def _largest_gap(
    ends: tuple[float, float, float, float], normals: Floats, support: Floats
) -> tuple[float, int]:
    """(largest gap between a segment and a hull along a normal, index of that normal)."""
    largest, at = -math.inf, 0
    for j in range(normals.shape[0]):
        ux, uy = normals[j, 0], normals[j, 1]
        first, second = ends[0] * ux + ends[1] * uy, ends[2] * ux + ends[3] * uy
        gap = min(first, second) - support[j]
        if gap > largest:
            largest, at = gap, j
    return largest, at
