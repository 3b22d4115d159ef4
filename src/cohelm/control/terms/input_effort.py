"""Inputs: turning, and for tracking planners the speed of the reference; Xu et al., eq. (12)."""

from __future__ import annotations

import math
from typing import Literal, NamedTuple

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.path import PathTable
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel
from cohelm.kernels import INNER, KERNEL, callee

NAME = "input_effort"


class InputEffort(Model):
    """Squared turn rate; the speed has no price of its own, since being late has one."""

    turn: float = Field(0.15, ge=0.0)
    """Weight of the turn rate, 1/(rad/s)² per second."""

    def table(self, scene: Scene) -> InputEffortTable:
        """Weights of a step."""
        return InputEffortTable(0.0, self.turn * scene.step, False, scene.robot.n_linear)


class InputDeviation(InputEffort):
    """(u − û)ᵀ Q_u (u − û), where û is the reference's speed without turning.

    A holonomic robot is to have that speed in the reference's direction, whatever its own heading.
    As printed the inputs themselves are penalised (û = 0): the chair then lags behind its
    reference, and where reversing is allowed it can become the cheapest answer to a barrier.
    """

    input_cost: Literal["reference", "printed"] = "reference"
    """Desired input û: the reference's speed, or 0 as printed."""
    speed: float = Field(0.0, ge=0.0)
    """Weight of the speed, 1/(m/s)² per second."""

    def table(self, scene: Scene) -> InputEffortTable:
        """Weights of a step."""
        linear = self.speed * scene.step
        return InputEffortTable(
            linear, self.turn * scene.step, self.input_cost == "printed", scene.robot.n_linear
        )


class InputEffortTable(NamedTuple):
    """Weights of a step."""

    speed: float
    turn: float
    printed: bool
    n_linear: int


@callee(INNER)
def _residuals(
    t: InputEffortTable, path: PathTable, k: int, heading: float, u: Floats
) -> tuple[float, float, float]:
    """(u_0 − û_0, u_1 − û_1, θ̂ − θ) of the translating inputs of the step from state k."""
    wanted = 0.0 if t.printed else path.speeds[k]
    if t.n_linear == 1:
        return u[0] - wanted, 0.0, 0.0
    error = path.poses[k, 2] - heading
    return u[0] - wanted * math.cos(error), u[1] - wanted * math.sin(error), error


@callee(INNER)
def cost(t: InputEffortTable, path: PathTable, k: int, heading: float, u: Floats) -> float:
    """Cost of input u (m,) of the step from state k, where the robot has a heading; s."""
    turn = u[u.shape[0] - 1]
    total: float = t.turn * turn * turn
    if t.speed > 0.0:
        along, across, _ = _residuals(t, path, k, heading, u)
        total += t.speed * (along * along + across * across)
    return total


@callee(KERNEL)
def model(
    t: InputEffortTable, path: PathTable, k: int, heading: float, u: Floats, q: LocalModel
) -> None:
    """Add the model of the step from state k; the heading's coupling with the input is left out."""
    last = u.shape[0] - 1
    q.input_gradient[k, last] += 2.0 * t.turn * u[last]
    q.input_curvature[k, last] += 2.0 * t.turn
    if t.speed > 0.0:
        along, across, error = _residuals(t, path, k, heading, u)
        q.input_gradient[k, 0] += 2.0 * t.speed * along
        q.input_curvature[k, 0] += 2.0 * t.speed
        if t.n_linear > 1:
            q.input_gradient[k, 1] += 2.0 * t.speed * across
            q.input_curvature[k, 1] += 2.0 * t.speed
            wanted = 0.0 if t.printed else path.speeds[k]
            turned = across * math.cos(error) - along * math.sin(error)
            q.pose_gradient[k, 2] += 2.0 * t.speed * wanted * turned
            q.pose_curvature[k, 5] += 2.0 * t.speed * wanted * wanted
