"""Do not pass between people who belong together: a barrier on the hull of a group's spaces."""

from __future__ import annotations

import functools
import math

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.series import as_series, series_rows
from cohelm.messages import GroupSpaces


class GroupSpace:
    """h = distance of the footprint's capsule to the hull of a group at each step; see ``shapes``.

    The hull is told by its support s(u), the capsule by its spine's ends a and b and its radius r,

        h = max_u min(a·u, b·u) − s(u) − r,

    the greatest gap between the two along any direction u: their distance outside (never more
    than that), and inside, as a negative number, the shortest way out. That is the direction in
    which a robot within a group is asked to leave it, by a share γ of the way a step.
    """

    class Parameters(Model):
        """Barrier and price, assumed; less than a person's space, which it must not lead into."""

        gamma: float = Field(0.2, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        l1: float = Field(2.0, ge=0.0)
        """Price of the slack, 1/m a group."""
        l2: float = Field(2.0, ge=0.0)
        """Price of the slack squared, 1/m² a group."""

    name = "group_space"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By group, the worst over steps, (g,)."""
        groups = problem.spaces.groups
        if groups is None or not len(groups.id):
            return Measure(slack=np.empty(0))
        capsule, gamma = problem.robot.capsule, self.parameters.gamma
        return Measure(*_measured(capsule, motion.poses, _normals(groups), groups.support, gamma))

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        groups, h, gamma = problem.spaces.groups, measure.h, self.parameters.gamma
        if groups is None or not len(h):
            return series_rows(h, measure.gradient, sensitivity, gamma, barrier.NEAR)
        capsule, normals = problem.robot.capsule, _normals(groups)
        found = _linearised(capsule, motion.poses, normals, groups.support, h, sensitivity, gamma)
        return as_series(h, *found)


@njit(cache=True)
def _measured(
    capsule: Floats, poses: Floats, normals: Floats, support: Floats, gamma: float
) -> tuple[Floats, float, Floats]:
    """(slack, smallest, h) of ``Measure``."""
    h = group_barrier(capsule, poses, normals, support)
    worst, smallest = barrier.worst(h, gamma)
    return worst, smallest, h


@njit(cache=True)
def _linearised(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    normals: Floats,
    support: Floats,
    h: Floats,
    sensitivity: Floats,
    gamma: float,
) -> tuple[Floats, Floats, Integers, Integers]:
    """(margin, jacobian, series, key) as of ``barrier.rows``."""
    near = barrier.near_states(h, gamma, barrier.NEAR)
    gradient = group_gradient(capsule, poses, normals, support, near)
    return barrier.rows(h, gradient, sensitivity, gamma, barrier.NEAR)


@functools.lru_cache(maxsize=16)
def _normals(groups: GroupSpaces) -> Floats:
    """(m, 2) unit vectors of the directions."""
    return np.stack([np.cos(groups.direction), np.sin(groups.direction)], axis=-1)


@njit(cache=True)
def group_barrier(capsule: Floats, poses: Floats, normals: Floats, support: Floats) -> Floats:
    """Values h (g, N+1) against the hulls of groups.

    capsule: as ``Robot.capsule``.  poses: (N+1, 3).  normals: (m, 2).  support: (g, N+1, m).
    """
    h = np.empty(support.shape[:2])
    for k in range(poses.shape[0]):
        ends = _ends(capsule, poses[k])
        for i in range(support.shape[0]):
            h[i, k] = _widest(ends, normals, support[i, k])[0] - capsule[4]
    return h


@njit(cache=True)
def group_gradient(
    capsule: Floats, poses: Floats, normals: Floats, support: Floats, near: Booleans
) -> Floats:
    """∂h/∂pose (g, N+1, 3) of ``group_barrier``, 0 but where ``near`` (g, N+1).

    Along u, and about the robot with the arm of the spine's end that is nearer to the hull.
    """
    out = np.zeros((support.shape[0], support.shape[1], 3))
    for k in range(poses.shape[0]):
        ends = _ends(capsule, poses[k])
        for i in range(support.shape[0]):
            if not near[i, k]:
                continue
            _, at = _widest(ends, normals, support[i, k])
            ux, uy = normals[at, 0], normals[at, 1]
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
def _widest(
    ends: tuple[float, float, float, float], normals: Floats, support: Floats
) -> tuple[float, int]:
    """(the widest gap between a segment and a hull along a normal, the index of that normal)."""
    best, at = -math.inf, 0
    for j in range(normals.shape[0]):
        ux, uy = normals[j, 0], normals[j, 1]
        first, second = ends[0] * ux + ends[1] * uy, ends[2] * ux + ends[3] * uy
        gap = min(first, second) - support[j]
        if gap > best:
            best, at = gap, j
    return best, at
