"""Changes of the inputs: linear and angular acceleration."""

from __future__ import annotations

from typing import NamedTuple

from pydantic import Field

from cohelm.arrays import Floats
from cohelm.config import Model
from cohelm.control.scene import Scene
from cohelm.control.terms.stage import LocalModel
from cohelm.kernels import INNER, KERNEL, callee

NAME = "input_change"


class InputChange(Model):
    """Weight on u_k − u_{k−1}, so that the ride is smooth and successive plans agree; assumed."""

    speed: float = Field(0.016, ge=0.0)
    """Weight of the linear acceleration, 1/(m/s²)² per second."""
    turn: float = Field(0.016, ge=0.0)
    """Weight of the angular acceleration, 1/(rad/s²)² per second."""

    def table(self, scene: Scene) -> InputChangeTable:
        """Weights of a step."""
        return InputChangeTable(
            self.speed / scene.step, self.turn / scene.step, scene.robot.n_linear
        )


class InputChangeTable(NamedTuple):
    """Weights of a step."""

    speed: float
    turn: float
    n_linear: int


@callee(INNER)
def cost(t: InputChangeTable, u: Floats, before: Floats) -> float:
    """Cost of input u (m,) after another one, s."""
    total = 0.0
    for i in range(u.shape[0]):
        change = u[i] - before[i]
        total += (t.speed if i < t.n_linear else t.turn) * change * change
    return total


@callee(KERNEL)
def model(t: InputChangeTable, k: int, u: Floats, before: Floats, q: LocalModel) -> None:
    """Add the model of the input at step k."""
    for i in range(u.shape[0]):
        weight = 2.0 * (t.speed if i < t.n_linear else t.turn)
        change = u[i] - before[i]
        q.input_gradient[k, i] += weight * change
        q.input_curvature[k, i] += weight
        if k > 0:
            q.input_gradient[k - 1, i] -= weight * change
            q.input_curvature[k - 1, i] += weight
            q.input_coupling[k, i] -= weight
