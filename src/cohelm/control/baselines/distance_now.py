"""Keep away from where people are now: the distance constraint of a linear MPC, in three norms."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.series import series_rows
from cohelm.robots.contact import nearest_on_spine

_NORMS = {1: 1, 2: 2, "inf": 0}
_DISTANCE = 1.0
"""γ of a plain distance constraint: h ≥ 0 at every step, whatever h was before."""


class DistanceNow:
    """h = ‖q‖ − r_body − r_i − margin, q from the footprint's spine to a person's place now.

    q is taken along and across the reference, so that its norms mean the same whichever way the
    world is turned. ``inf`` is a box about the person, whose constraint is linear: pass beside it,
    or stay behind it. ``1`` is a diamond, made √2 as wide so that it contains the disc of norm 2.
    """

    class Parameters(Model):
        """Norm, margin and price; assumed."""

        norm: Literal[1, 2, "inf"] = 2
        """Of the distance."""
        margin: float = Field(0.3, ge=0.0, le=2.0)
        """Distance kept from a body, m."""
        l1: float = Field(60.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(60.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "distance_now"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By person, the worst over the steps, (n,)."""
        h, gradient = distance_barrier(
            problem.robot.capsule,
            motion.poses,
            problem.people.mean[:, :2],
            problem.people.radius,
            problem.reference.poses[:, 2],
            _NORMS[self.parameters.norm],
            self.parameters.margin,
        )
        worst, smallest = barrier.worst(h, _DISTANCE)
        return Measure(slack=worst, smallest=smallest, h=h, gradient=gradient)

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        del problem, motion
        return series_rows(measure.h, measure.gradient, sensitivity, _DISTANCE, barrier.NEAR)


@njit(cache=True)
def distance_barrier(  # noqa: PLR0917  # a kernel takes plain arrays
    capsule: Floats,
    poses: Floats,
    positions: Floats,
    radius: Floats,
    along: Floats,
    norm: int,
    margin: float,
) -> tuple[Floats, Floats]:
    """(h (n, N+1), gradient (n, N+1, 3)) in norm 1, 2 or 0 for the greatest component.

    poses: (N+1, 3).  positions: (n, 2).  radius: (n,).  along: (N+1,) headings of the axes.
    """
    n, states = positions.shape[0], poses.shape[0]
    h = np.empty((n, states))
    gradient = np.empty((n, states, 3))
    for i in range(n):
        for k in range(states):
            d, nx, ny, ax, ay, inside = nearest_on_spine(
                capsule, poses[k], positions[i, 0], positions[i, 1]
            )
            kept, length = capsule[4] + radius[i] + margin, d
            ux, uy, turned = nx, ny, 0.0
            if norm != 2:
                cos, sin = math.cos(along[k]), math.sin(along[k])
                qx, qy = d * (cos * nx + sin * ny), d * (-sin * nx + cos * ny)
                gx, gy = math.copysign(1.0, qx), math.copysign(1.0, qy)
                if norm == 1:
                    kept *= math.sqrt(2.0)
                elif abs(qx) > abs(qy):
                    gy = 0.0
                else:
                    gx = 0.0
                d = gx * qx + gy * qy
                ux, uy = cos * gx - sin * gy, sin * gx + cos * gy
                if inside:  # the foot slides along the spine: q stays across it and turns with it
                    turned = length * (-ux * ny + uy * nx)
                    size = ux * nx + uy * ny
                    ux, uy = size * nx, size * ny
            h[i, k] = d - kept
            gradient[i, k, 0] = -ux
            gradient[i, k, 1] = -uy
            gradient[i, k, 2] = turned - (ux * ax + uy * ay)
    return h, gradient
