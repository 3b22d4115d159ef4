"""Artificial potential field, the joystick a force; after Khatib (1986) and Petry et al. (2010).

Local minima are its nature: where attraction and repulsion cancel the chair stands, and says so.
"""

from __future__ import annotations

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.api import LocalProblem, Motion
from cohelm.control.baselines.apf_forces import descend
from cohelm.control.baselines.steering import Steering
from cohelm.control.baselines.tracking import plan_of, scrapes
from cohelm.control.usable import usable
from cohelm.control.verification import brought_to_rest
from cohelm.control.warm_start import last_input
from cohelm.messages import LocalPlan, Status

_NAMES = ("path", "rider", "walls", "people")
_BALANCED = 0.02
"""A twist below this is standing, m/s and rad/s."""


class Apf:
    """F = (1 − η) F_path + η F_rider + Σ F_walls + Σ F_people; its direction is steered to.

    The path pulls with unit force toward a point ahead on the reference, a full deflection of the
    stick with as much. Walls and people push by Khatib's law within their reach. People are where
    they are now: a field has no future.
    """

    class Parameters(Model):
        """Reaches and strengths; the authors give none that fit this chair, these are assumed."""

        steps: int = Field(15, ge=3, le=100)
        """How far the field is followed ahead, for the picture and the walls."""
        step: float = Field(0.1, gt=0.0, le=1.0)
        """s."""
        ahead: float = Field(1.0, gt=0.0, le=5.0)
        """How far ahead on the reference the attracting point is, s."""
        gain: float = Field(1.5, gt=0.0, le=10.0)
        """Turn rate for each radian between heading and force, 1/s."""
        speed: float = Field(1.0, gt=0.0, le=1.0)
        """Share of the reference's speed that a unit force means."""
        people_reach: float = Field(1.8, gt=0.0, le=10.0)
        """ρ₀ of people, from body to footprint, m."""
        people_strength: float = Field(0.25, ge=0.0, le=20.0)
        """η of people, m³."""
        wall_reach: float = Field(0.3, gt=0.0, le=5.0)
        """ρ₀ of walls, m."""
        wall_strength: float = Field(0.0006, ge=0.0, le=5.0)
        """η of walls, m³."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        p = self.parameters = parameters or self.Parameters()
        self.steps, self.step = p.steps, p.step

    def plan(self, problem: LocalProblem, previous: LocalPlan | None) -> LocalPlan:
        """See :class:`~cohelm.control.api.LocalPlanner`."""
        problem = usable(problem, self.steps)
        now = last_input(problem, previous)
        motion, forces, target = self._followed(problem, now)
        sizes = {name: float(np.hypot(*f)) for name, f in zip(_NAMES, forces, strict=True)}
        balanced = np.abs(target).max() < _BALANCED
        wants_on = float(problem.reference.speeds.max()) > _BALANCED
        if (balanced and wants_on) or scrapes(problem, motion):
            rest = brought_to_rest(problem, now, self.steps)
            return plan_of(problem, rest, Status.STOP, costs=sizes)
        return plan_of(problem, motion, Status.OK, costs=sizes)

    def _followed(self, problem: LocalProblem, now: Floats) -> tuple[Motion, Floats, Floats]:
        """(the motion down the field, the forces now (4, 2), the target twist now (3,))."""
        p, reference, walls = self.parameters, problem.reference, problem.walls
        steering, hand = Steering.of(problem, p.gain), problem.authority
        lead = np.minimum(np.arange(self.steps) + max(round(p.ahead / p.step), 1), self.steps)
        soon = np.minimum(np.arange(self.steps) + 2, self.steps)
        poses, inputs, forces, target = descend(
            problem.pose,
            now,
            np.ascontiguousarray(reference.poses[lead, :2]),
            p.speed * np.maximum(reference.speeds[soon], reference.speeds[lead]),
            hand.deflection if hand else np.zeros(2),
            hand.eta if hand else 0.0,
            problem.robot.capsule,
            problem.robot.discs,
            problem.people.mean[:, :2],
            problem.people.radius,
            walls.distance,
            walls.resolution,
            walls.X_MG,
            np.array([p.people_reach, p.people_strength, p.wall_reach, p.wall_strength]),
            steering.to_input,
            steering.to_twist,
            steering.bounds,
            steering.sideways,
            steering.gain,
            p.step,
        )
        motion = Motion(step=p.step, poses=poses, inputs=inputs, last_input=now)
        return motion, forces, target
