"""Respect personal space: the dynamic control barrier of Xu et al., eqs. (8) and (9)."""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Measure, Motion, Rows
from cohelm.control.constraints.separation import social_barrier
from cohelm.control.constraints.series import by_person, flattened, person_rows


class SocialSpace:
    """h = ‖c − p_i‖ − r_body − r_i − l_i − l at predicted positions; see ``separation``.

    The robot's own reach l depends on its speed, which is decided here; it is frozen at the
    measured speed within a solve.
    """

    class Parameters(Model):
        """Barrier and price, assumed: small, because in a narrow corridor it must yield."""

        gamma: float = Field(0.15, gt=0.0, le=1.0)
        """γ of eq. (9)."""
        l1: float = Field(4.0, ge=0.0)
        """Price of the slack, 1/m a person."""
        l2: float = Field(4.0, ge=0.0)
        """Price of the slack squared, 1/m² a person."""

    name = "social_space"

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
        spaces = problem.spaces
        return social_barrier(
            problem.robot.capsule,
            motion.poses,
            flattened(problem.predictions.mean),
            np.repeat(problem.people.radius, problem.predictions.mean.shape[1]),
            spaces.kind,
            spaces.scale,
            flattened(spaces.axis),
            flattened(spaces.front),
            flattened(spaces.side),
            flattened(spaces.rear),
            spaces.floor,
            spaces.robot,
            spaces.robot_floor,
        )
