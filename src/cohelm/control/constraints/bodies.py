"""Do not touch people: a barrier on bodies, with a margin that grows with the prediction's age."""

from __future__ import annotations

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints import barrier
from cohelm.control.constraints.futures import Futures, Margin, futures
from cohelm.control.constraints.separation import body_barrier, body_gradient


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
        deviations: float = Field(0.0, ge=0.0, le=5.0)
        """By how many standard deviations of the predicted position the margin grows besides."""
        greatest: float = Field(0.35, ge=0.0)
        """The margin's bound, m."""
        squeezing: float = Field(0.06, ge=0.0)
        """The margin when the ride is stalled, m; it does not grow then."""
        at_least: float = Field(0.15, ge=0.0, le=1.0)
        """Probability from which on a future binds; a person's likeliest always does."""
        l1: float = Field(60.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(60.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "bodies"

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.l1, self.l2 = p.l1, p.l2
        self._margin = Margin(
            now=p.margin, growth=p.growth, deviations=p.deviations, most=p.greatest
        )
        self._squeezing = Margin(now=p.squeezing)

    def measure(self, problem: LocalProblem, motion: Motion) -> Measure:
        """By person, the worst over futures and steps, (n,)."""
        who = self._futures(problem)
        h = body_barrier(problem.robot.capsule, motion.poses, who.positions, who.kept)
        return who.measure(h, self.parameters.gamma)

    def rows(
        self, problem: LocalProblem, motion: Motion, sensitivity: Floats, measure: Measure
    ) -> Rows:
        """Those that can become active."""
        who, gamma = self._futures(problem), self.parameters.gamma
        near = barrier.near_states(measure.h, gamma, barrier.NEAR)
        gradient = body_gradient(problem.robot.capsule, motion.poses, who.positions, near)
        return who.rows(measure.h, gradient, sensitivity, gamma)

    def _futures(self, problem: LocalProblem) -> Futures:
        p = self.parameters
        margin = self._squeezing if problem.stalled else self._margin
        return futures(problem, p.at_least, margin, p.gamma, 0.0)
