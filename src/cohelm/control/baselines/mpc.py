"""Linear tracking MPC that keeps away from where people are now; after Turri et al. (2013)."""

from __future__ import annotations

from pydantic import Field

from cohelm.config import Model
from cohelm.control.api import LocalProblem
from cohelm.control.baselines.distance_now import DistanceNow
from cohelm.control.baselines.tracking import along_reference, planned
from cohelm.control.constraints import InputLimits, WallClearance
from cohelm.control.costs import InputEffort, SmoothInput, TrackReference
from cohelm.control.sqp import OptimalControl
from cohelm.control.usable import usable
from cohelm.control.warm_start import last_input
from cohelm.messages import LocalPlan


class Mpc:
    """One quadratic program for each of a few speed profiles along the reference; the best is used.

    The model is linearised about the reference driven at that profile, so that nothing but the
    choice of the profile is nonlinear. It predicts nobody: people are where they are.
    """

    class Parameters(Model):
        """Horizon, profiles, terms and constraints; assumed where no source is named."""

        steps: int = Field(25, ge=3, le=100)
        """N; as in ``mpc_dcbf``."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """Δt, s; as in ``mpc_dcbf``."""
        profiles: tuple[float, ...] = Field((1.0, 0.5, 0.0), min_length=1, max_length=9)
        """Shares of the reference's speed about which the problem is linearised: driving on,
        slowing down, braking."""
        tolerance: float = Field(0.15, ge=0.0, le=1.0)
        """Slack beyond which a motion that violates no less than braking is given up, m."""
        track_reference: TrackReference.Parameters = TrackReference.Parameters()
        input_effort: InputEffort.Parameters = InputEffort.Parameters()
        smooth_input: SmoothInput.Parameters = SmoothInput.Parameters()
        input_limits: InputLimits.Parameters = InputLimits.Parameters()
        wall_clearance: WallClearance.Parameters = WallClearance.Parameters(gamma=1.0)
        distance: DistanceNow.Parameters = DistanceNow.Parameters()

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
                WallClearance(p.wall_clearance),
                DistanceNow(p.distance),
            ),
        )

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        problem = usable(problem)
        now = last_input(problem, previous)
        solutions = [
            self.control.solve(problem, along_reference(problem, now, share=share), iterations=1)
            for share in self.parameters.profiles
        ]
        best = min(solutions, key=lambda solution: solution.value.merit)
        return planned(self.control, problem, best, now, tolerance=self.parameters.tolerance)
