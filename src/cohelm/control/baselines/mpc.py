"""Linear tracking MPC with distances to people's present positions; after Turri et al. (2013)."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import ConstraintRows, ConstraintValues, LocalProblem, Trajectory
from cohelm.control.baselines.tracking import along_reference, plan_of_solution
from cohelm.control.sqp import OptimalControl
from cohelm.control.terms import (
    InputEffort,
    InputLimits,
    SmoothInput,
    TrackReference,
    WallBarrier,
)
from cohelm.control.terms.constraints import barrier
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.messages import LocalPlan
from cohelm.robots.capsule import nearest_on_spine_in_map

_NORMS = {1: 1, 2: 2, "inf": 0}
_DISTANCE = 1.0
"""γ of a plain distance constraint: h ≥ 0 at every step, independent of the step before."""


class PresentDistance:
    """h = ‖q‖ − r_robot − r_i − margin at people's present positions.

    q leads from the spine of the footprint to the person, taken along and across the reference, so
    that its norms do not depend on the map's axes. ``inf`` is a box about the person with a linear
    constraint: pass beside it, or stay behind it. ``1`` is a diamond, √2 as wide so that it
    contains the disc of norm 2.
    """

    class Parameters(Model):
        """Norm, margin and weights; assumed."""

        norm: Literal[1, 2, "inf"] = 2
        """Norm of the distance."""
        margin: float = Field(0.3, ge=0.0, le=2.0)
        """Distance between robot and person, m."""
        l1: float = Field(60.0, ge=0.0)
        """Weight of the slack, 1/m per person."""
        l2: float = Field(60.0, ge=0.0)
        """Weight of the squared slack, 1/m² per person."""

    name = "present_distance"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def values(self, problem: LocalProblem, trajectory: Trajectory) -> ConstraintValues:
        """Largest violation by person, over steps, (n,)."""
        p, people = self.parameters, problem.people
        min_distance = problem.robot.capsule[4] + people.radius + p.margin
        h, gradient = distance_barrier(
            problem.robot.capsule,
            trajectory.poses,
            people.mean[:, :2],
            min_distance,
            problem.reference.poses[:, 2],
            _NORMS[p.norm],
        )
        layout = barrier.separate_slacks(len(h))
        slack, smallest = barrier.largest_violations(h, _DISTANCE, layout)
        return ConstraintValues(slack=slack, smallest=smallest, h=h, gradient=gradient)

    def rows(
        self,
        problem: LocalProblem,
        trajectory: Trajectory,
        sensitivity: Floats,
        values: ConstraintValues,
    ) -> ConstraintRows:
        """The rows that can become active."""
        del problem, trajectory
        h, layout = values.h, barrier.separate_slacks(len(values.h))
        rows = barrier.linearise_dcbf(
            h, values.gradient, sensitivity, _DISTANCE, barrier.NEAR, layout
        )
        return barrier.constraint_rows(rows, layout, h.shape[1])


@njit(cache=True)
def distance_barrier(
    capsule: Floats, poses: Floats, positions: Floats, min_distance: Floats, axes: Floats, norm: int
) -> tuple[Floats, Floats]:
    """(h (n, N+1), gradient (n, N+1, 3)) in norm 1, 2 or 0 for the largest component.

    poses: (N+1, 3).  positions: (n, 2).  min_distance: (n,) both radii and the margin.
    axes: (N+1,) headings of the axes.
    """
    n, states = positions.shape[0], poses.shape[0]
    h = np.empty((n, states))
    gradient = np.empty((n, states, 3))
    for i in range(n):
        for k in range(states):
            d, nx, ny, ax, ay, inside = nearest_on_spine_in_map(
                capsule, poses[k], positions[i, 0], positions[i, 1]
            )
            size, length = min_distance[i], d
            ux, uy, turned = nx, ny, 0.0
            if norm != 2:
                # the components of q, and the direction in which its norm grows
                cos, sin = math.cos(axes[k]), math.sin(axes[k])
                qx, qy = d * (cos * nx + sin * ny), d * (-sin * nx + cos * ny)
                gx, gy = math.copysign(1.0, qx), math.copysign(1.0, qy)
                if norm == 1:
                    size *= math.sqrt(2.0)
                elif abs(qx) > abs(qy):
                    gy = 0.0
                else:
                    gx = 0.0
                d = gx * qx + gy * qy
                ux, uy = cos * gx - sin * gy, sin * gx + cos * gy
                # the nearest point slides: q stays normal to the spine and turns with it
                if inside:
                    turned = length * (-ux * ny + uy * nx)
                    share = ux * nx + uy * ny
                    ux, uy = share * nx, share * ny
            h[i, k] = d - size
            gradient[i, k, 0] = -ux
            gradient[i, k, 1] = -uy
            gradient[i, k, 2] = turned - (ux * ax + uy * ay)
    return h, gradient


class Mpc:
    """One quadratic program for each of a few speed profiles along the reference; takes the best.

    The model is linearised about the reference at that profile, so only the choice of the profile
    is nonlinear. It has no prediction: people stay where they are.
    """

    class Parameters(Model):
        """Horizon, profiles, terms and constraints; assumed unless a source is named."""

        steps: int = Field(25, ge=3, le=100)
        """N; as in ``mpc_dcbf``."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s; as in ``mpc_dcbf``."""
        profiles: tuple[float, ...] = Field((1.0, 0.5, 0.0), min_length=1, max_length=9)
        """Shares of the reference's speed about which the problem is linearised: cruising,
        slowing down, braking."""
        tolerance: float = Field(0.15, ge=0.0, le=1.0)
        """Slack beyond which braking replaces a trajectory with no smaller violation, m."""
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallBarrier.Parameters = WallBarrier.Parameters(gamma=1.0)
        distance: PresentDistance.Parameters = PresentDistance.Parameters()

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.control = OptimalControl(
            costs=(
                TrackReference(p.track_reference),
                InputEffort(p.input_effort),
                SmoothInput(p.smooth_input),
            ),
            constraints=(
                InputLimits(p.input_limits),
                WallBarrier(p.wall_clearance),
                PresentDistance(p.distance),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem)
        current_input = estimate_current_input(problem, previous)
        solutions = [
            self.control.solve(
                problem, along_reference(problem, current_input, share=share), iterations=1
            )
            for share in self.parameters.profiles
        ]
        best = min(solutions, key=lambda solution: solution.evaluation.merit)
        tolerance = self.parameters.tolerance
        return plan_of_solution(self.control, problem, best, current_input, tolerance=tolerance)
