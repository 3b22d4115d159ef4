"""How inputs move a robot: used by control and by simulation, so that they cannot drift apart."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.config import Model


class Kinematics(Protocol):
    """A motion model x⁺ = f(x, u) with m inputs, discretised with step dt."""

    inputs: int
    """m."""

    def twist(self, u: Floats) -> Floats:
        """The twist (..., 3) of inputs (..., m)."""
        ...

    def input(self, twist: Floats) -> Floats:
        """The inputs (..., m) nearest to a twist (..., 3)."""
        ...

    def bounds(self, limits: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """Input bounds from a robot's limits.

        Args:
            limits: (v_max, v_reverse, ω_max, a_max, a_brake, α_max), all ≥ 0.

        Returns:
            (lower, upper, greatest rise a second, greatest fall a second), each (m,).
        """
        ...

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """Poses (N+1, 3) from ``pose`` under inputs (N, m); headings are not wrapped."""
        ...

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """∂poses/∂inputs along a rollout, (N+1, 3, N·m); column m·j + i is input i at step j."""
        ...


class Unicycle:
    """Xu et al., eq. (10): x⁺ = x + Δt (v cos θ, v sin θ, ω); inputs (v, ω)."""

    class Parameters(Model):
        """None."""

    inputs = 2

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def twist(self, u: Floats) -> Floats:
        """(v, 0, ω)."""
        u = np.asarray(u)
        return np.stack([u[..., 0], np.zeros_like(u[..., 0]), u[..., 1]], axis=-1)

    def input(self, twist: Floats) -> Floats:
        """(v_x, ω); a unicycle cannot move sideways."""
        return np.asarray(twist)[..., [0, 2]]

    def bounds(self, limits: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """See :meth:`Kinematics.bounds`."""
        v, reverse, turn, speed_up, brake, turn_up = limits
        return (
            np.array([-reverse, -turn]),
            np.array([v, turn]),
            np.array([speed_up, turn_up]),
            np.array([brake, turn_up]),
        )

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """See :meth:`Kinematics.rollout`."""
        return unicycle_rollout(pose, inputs, dt)

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """Closed form: ∂p_k/∂v_j = Δt e_j, ∂p_k/∂ω_j = Δt (p_k − p_{j+1})^⊥, ∂θ_k/∂ω_j = Δt."""
        return unicycle_sensitivity(poses, inputs, dt)


@njit(cache=True)
def unicycle_rollout(pose: Floats, inputs: Floats, dt: float) -> Floats:
    """Poses (N+1, 3) of eq. (10) from ``pose`` under inputs (N, 2)."""
    out = np.empty((inputs.shape[0] + 1, 3))
    out[0] = pose
    for k in range(inputs.shape[0]):
        v, w = inputs[k, 0], inputs[k, 1]
        out[k + 1, 0] = out[k, 0] + dt * v * math.cos(out[k, 2])
        out[k + 1, 1] = out[k, 1] + dt * v * math.sin(out[k, 2])
        out[k + 1, 2] = out[k, 2] + dt * w
    return out


@njit(cache=True)
def unicycle_sensitivity(poses: Floats, inputs: Floats, dt: float) -> Floats:
    """See :meth:`Unicycle.sensitivity`; (N+1, 3, 2N)."""
    n = inputs.shape[0]
    out = np.zeros((n + 1, 3, 2 * n))
    for j in range(n):
        cos, sin = math.cos(poses[j, 2]), math.sin(poses[j, 2])
        for k in range(j + 1, n + 1):
            out[k, 0, 2 * j] = dt * cos
            out[k, 1, 2 * j] = dt * sin
            out[k, 0, 2 * j + 1] = -dt * (poses[k, 1] - poses[j + 1, 1])
            out[k, 1, 2 * j + 1] = dt * (poses[k, 0] - poses[j + 1, 0])
            out[k, 2, 2 * j + 1] = dt
    return out


def move(pose: Floats, twist: Floats, dt: float) -> Floats:
    """The pose (3,) after ``dt`` of a constant twist (3,), exactly (an arc); heading wrapped.

    For the simulator, whose physics must not share the planner's discretisation error.
    """
    return _arc(np.asarray(pose, dtype=float), np.asarray(twist, dtype=float), dt)


@njit(cache=True)
def _arc(pose: Floats, twist: Floats, dt: float) -> Floats:
    vx, vy, w = twist[0], twist[1], twist[2]
    angle = w * dt
    if abs(angle) < 1e-9:
        s, c = dt, 0.5 * w * dt * dt
    else:
        s, c = math.sin(angle) / w, (1.0 - math.cos(angle)) / w
    dx, dy = s * vx - c * vy, c * vx + s * vy
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    heading = (pose[2] + angle + math.pi) % (2.0 * math.pi) - math.pi
    return np.array([pose[0] + cos * dx - sin * dy, pose[1] + sin * dx + cos * dy, heading])
