"""Linear tracking MPC with distances to people's present positions; after Turri et al. (2013)."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.arrays import unchecked
from cohelm.config import Model
from cohelm.control.api import LocalProblem
from cohelm.control.baselines.tracking import along_reference, plan_of_solution, tracking_terms
from cohelm.control.optimal_control import OptimalControl
from cohelm.control.stack import TrackingTerms
from cohelm.control.terms import Barrier, WallBarrier
from cohelm.control.validation import check_problem
from cohelm.control.warm_start import estimate_current_input
from cohelm.messages import LocalPlan
from cohelm.robots.clearance import Clearance


class Mpc:
    """One quadratic program for each of a few speed profiles along the reference; takes the best.

    The model is linearised about the reference at that profile, so only the choice of the profile
    is nonlinear. It has no prediction: people stay where they are, and a barrier with γ = 1 is a
    plain distance to them.
    """

    class Parameters(Model):
        """Horizon, profiles, terms and distance; assumed unless a source is named."""

        steps: int = Field(25, ge=3, le=100)
        """N; as in ``mpc_dcbf``."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s; as in ``mpc_dcbf``."""
        profiles: tuple[float, ...] = Field((1.0, 0.5, 0.0), min_length=1, max_length=9)
        """Shares of the reference's speed about which the problem is linearised: cruising,
        slowing down, braking."""
        tolerance: float = Field(0.15, ge=0.0, le=1.0)
        """Slack beyond which braking replaces a trajectory with no smaller violation, m."""
        norm: Literal[1, 2, "inf"] = 2
        """Norm of the distance to people, see ``terms.norms``."""
        margin: float = Field(0.3, ge=0.0, le=2.0)
        """Distance between robot and person, m."""
        terms: TrackingTerms = tracking_terms(
            bodies=Barrier(gamma=1.0, l1=60.0, l2=60.0), walls=WallBarrier(l1=60.0, l2=60.0)
        )

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step
        clearance = Clearance(now=p.margin, growth=0.0, upper=p.margin, standing=1.0)
        self.control = OptimalControl(p.terms, clearance, norm=p.norm)

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        check_problem(problem)
        problem = at_present_positions(problem)
        current_input = estimate_current_input(problem, previous)
        solutions = [
            self.control.solve(
                problem, along_reference(problem, current_input, share=share), iterations=1
            )
            for share in self.parameters.profiles
        ]
        best = min(solutions, key=lambda solution: solution.evaluation.cost)
        tolerance = self.parameters.tolerance
        return plan_of_solution(self.control, problem, best, current_input, tolerance=tolerance)


def at_present_positions(problem: LocalProblem) -> LocalProblem:
    """The problem in which people stay where they are."""
    p, mean = problem.predictions, problem.people.mean
    present = np.broadcast_to(mean[:, None, None, :2], (len(mean), 1, *p.mean.shape[2:]))
    still = np.zeros((len(mean), 1, *p.mean.shape[2:]))
    s = problem.spaces
    return unchecked(
        problem,
        predictions=unchecked(
            p,
            names=("stays",),
            weight=np.ones((len(mean), 1)),
            mean=np.ascontiguousarray(present),
            velocity=still,
            deviation=np.ascontiguousarray(still[..., 0]),
        ),
        spaces=unchecked(
            s,
            axis=s.axis[:, :1].copy(),
            front=s.front[:, :1].copy(),
            side=s.side[:, :1].copy(),
            rear=s.rear[:, :1].copy(),
        ),
    )
