"""Do not touch people: a barrier on bodies, with a margin that grows with the prediction's age."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints.separation import body_barrier
from cohelm.control.constraints.series import by_person, flattened, person_rows


class Bodies:
    """h = ‖c − p_i‖ − r_body − r_i − margin(t) at predicted positions; see ``separation``."""

    class Parameters(Model):
        """Barrier and margins; assumed."""

        gamma: float = Field(0.3, gt=0.0, le=1.0)
        """γ of eq. (9); 1 is a plain distance constraint."""
        margin: float = Field(0.10, ge=0.0)
        """Distance kept from a body now, m."""
        growth: float = Field(0.08, ge=0.0)
        """How the margin grows with prediction time, m/s."""
        greatest: float = Field(0.35, ge=0.0)
        """The margin's bound, m."""
        squeezing: float = Field(0.05, ge=0.0)
        """The margin when the ride is stalled, m; it does not grow then."""
        l1: float = Field(60.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(60.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "bodies"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By person, the worst over hypotheses and steps, (n,)."""
        h, gradient = self._barrier(problem, motion)
        return by_person(problem, h, gradient, self.parameters.gamma)

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        del motion
        return person_rows(problem, measure, sensitivity, self.parameters.gamma)

    def _barrier(self, problem: LocalProblem, motion: Motion) -> tuple[Floats, Floats]:
        positions = flattened(problem.predictions.mean)
        p = self.parameters
        return body_barrier(
            problem.robot.capsule,
            motion.poses,
            positions,
            np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            problem.predictions.step,
            p.squeezing if problem.stalled else p.margin,
            0.0 if problem.stalled else p.growth,
            p.greatest,
        )
