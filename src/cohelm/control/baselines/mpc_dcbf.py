"""MPC with dynamic control barriers on moving bounding ellipses; after Jian et al. (2022)."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import replace
from cohelm.config import Model
from cohelm.control.api import LocalProblem
from cohelm.control.baselines.tracking import along_reference, plan_of_solution, tracking_terms
from cohelm.control.optimal_control import OptimalControl
from cohelm.control.stack import TrackingTerms
from cohelm.control.terms import Barrier, WallBarrier
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input, shifted_plan
from cohelm.messages import LocalPlan
from cohelm.robots.clearance import Clearance
from cohelm.shapes import ELLIPSE

_WALKING = 0.1
"""A person slower than this has no direction, m/s."""
_NOTHING = 1e-6
"""Extent of the robot's own space: there is none, m."""


class EllipseParameters(Model):
    """Size of the ellipse about a person."""

    margin: float = Field(0.25, ge=0.0, le=2.0)
    """Distance to a person in every direction, m; assumed. The authors keep their robot's
    centre 0.5 m (a Jackal) or 1.3 m (a Scout) off the ellipse."""
    deviations: float = Field(1.0, ge=0.0, le=5.0)
    """Standard deviations of the predicted position added to the axes; assumed. The long axis, in
    the direction of motion, grows with them; the short one uses the present value."""
    max_extension: float = Field(0.4, ge=0.0, le=3.0)
    """Upper bound of the extension, m; assumed."""


class MpcDcbf:
    """Tracks the reference; people are ellipses at predicted positions, under eq. (9) with γ.

    It ignores social spaces and groups. The most likely hypothesis of each person constrains, and
    others above a probability, as in ``ss_mpc_dcbf``.
    """

    class Parameters(Model):
        """N, Δt and γ are the authors'; the weights are assumed."""

        steps: int = Field(25, ge=3, le=100)
        """N; Jian et al."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s; Jian et al."""
        iterations: int = Field(4, ge=1, le=50)
        """Quadratic programs per plan; assumed (the authors run IPOPT to convergence)."""
        tolerance: float = Field(0.15, ge=0.0, le=1.0)
        """Slack beyond which braking replaces a trajectory with no smaller violation, m."""
        ellipses: EllipseParameters = EllipseParameters()
        terms: TrackingTerms = tracking_terms(
            social_space=Barrier(gamma=0.3, l1=60.0, l2=60.0), walls=WallBarrier(l1=60.0, l2=60.0)
        )
        """γ = 0.3 of the barrier on ellipses; Jian et al."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        self.control = OptimalControl(p.terms, Clearance())

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        p = self.parameters
        check_problem(problem)
        problem = bounded_by_ellipses(problem, p.ellipses)
        current_input = estimate_current_input(problem, previous)
        seeds = [along_reference(problem, current_input)]
        warm = shifted_plan(problem, previous, current_input)
        if warm is not None:
            seeds.append(warm)
        best = min(seeds, key=lambda seed: self.control.evaluate(problem, seed).cost)
        solution = self.control.solve(problem, best, iterations=p.iterations)
        return plan_of_solution(
            self.control, problem, solution, current_input, tolerance=p.tolerance
        )


def bounded_by_ellipses(problem: LocalProblem, ellipses: EllipseParameters) -> LocalProblem:
    """The problem with people as ellipses: their bodies, extended by the uncertainty.

    The ellipse with c = 1/2 has the σ as semi-axes, so the term of the social space applies. Bodies
    are inside it, hence points.
    """
    predictions, spaces = problem.predictions, problem.spaces
    speed = np.hypot(predictions.velocity[..., 0], predictions.velocity[..., 1])
    spread = np.minimum(ellipses.deviations * predictions.deviation, ellipses.max_extension)
    short = problem.people.radius[:, None, None] + ellipses.margin + spread[..., :1]
    short = np.broadcast_to(short, spread.shape)
    long = np.where(speed > _WALKING, short - spread[..., :1] + spread, short)
    axis = np.arctan2(predictions.velocity[..., 1], predictions.velocity[..., 0])
    return replace(
        problem,
        people=replace(problem.people, radius=np.zeros_like(problem.people.radius)),
        spaces=replace(
            spaces,
            kind=ELLIPSE,
            scale=0.5,
            axis=axis,
            front=long,
            side=short,
            rear=long,
            floor=0.0,
            robot=np.full(3, _NOTHING),
            robot_floor=0.0,
            groups=None,
        ),
    )
