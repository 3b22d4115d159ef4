"""A robot that moves any way: omni-directional wheels, or the agent of a crowd benchmark."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, read_only
from cohelm.config import Model

_SIDES = 16
"""Of the polygon that stands for the disc of allowed velocities; up to 1.9 % is lost on each."""


class Holonomic:
    """x⁺ = x + Δt (R(θ) (v_x, v_y), ω); inputs (v_x, v_y, ω) in the robot frame.

    Speed is bounded by its norm, ‖(v_x, v_y)‖ ≤ v_max, linearly by an inscribed polygon one corner
    of which is straight ahead: full speed is kept on both axes. Backwards ``max_reverse_speed``
    holds besides. Sideways, where the sign does not tell speeding up from braking, changes are
    bounded by what the brakes can do.
    """

    class Parameters(Model):
        """None."""

    inputs = 3
    translating = 2
    turned = 0.0

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        angle = (np.arange(_SIDES) + 0.5) * (2.0 * math.pi / _SIDES)
        normals = np.stack([np.cos(angle), np.sin(angle), np.zeros(_SIDES)], axis=-1)
        self.facets = read_only(normals / math.cos(math.pi / _SIDES))

    def twist(self, u: Floats) -> Floats:
        """(v_x, v_y, ω)."""
        return np.array(u, dtype=float)

    def input(self, twist: Floats) -> Floats:
        """(v_x, v_y, ω)."""
        return np.array(twist, dtype=float)

    def bounds(self, limits: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """See :meth:`Kinematics.bounds`."""
        v, reverse, turn, speed_up, brake, turn_up = limits
        return (
            np.array([-reverse, -v, -turn]),
            np.array([v, v, turn]),
            np.array([speed_up, brake, turn_up]),
            np.array([brake, brake, turn_up]),
        )

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """See :meth:`Kinematics.rollout`."""
        return holonomic_rollout(pose, inputs, dt)

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """Closed form: ∂p_k/∂v_j = Δt R(θ_j), ∂p_k/∂ω_j = Δt (p_k − p_{j+1})^⊥, ∂θ_k/∂ω_j = Δt."""
        return holonomic_sensitivity(poses, inputs, dt)


@njit(cache=True)
def holonomic_rollout(pose: Floats, inputs: Floats, dt: float) -> Floats:
    """Poses (N+1, 3) from ``pose`` under inputs (N, 3)."""
    out = np.empty((inputs.shape[0] + 1, 3))
    out[0] = pose
    for k in range(inputs.shape[0]):
        cos, sin = math.cos(out[k, 2]), math.sin(out[k, 2])
        out[k + 1, 0] = out[k, 0] + dt * (cos * inputs[k, 0] - sin * inputs[k, 1])
        out[k + 1, 1] = out[k, 1] + dt * (sin * inputs[k, 0] + cos * inputs[k, 1])
        out[k + 1, 2] = out[k, 2] + dt * inputs[k, 2]
    return out


@njit(cache=True)
def holonomic_sensitivity(poses: Floats, inputs: Floats, dt: float) -> Floats:
    """See :meth:`Holonomic.sensitivity`; (N+1, 3, 3N)."""
    n = inputs.shape[0]
    out = np.zeros((n + 1, 3, 3 * n))
    for j in range(n):
        cos, sin = math.cos(poses[j, 2]), math.sin(poses[j, 2])
        for k in range(j + 1, n + 1):
            out[k, 0, 3 * j] = dt * cos
            out[k, 1, 3 * j] = dt * sin
            out[k, 0, 3 * j + 1] = -dt * sin
            out[k, 1, 3 * j + 1] = dt * cos
            out[k, 0, 3 * j + 2] = -dt * (poses[k, 1] - poses[j + 1, 1])
            out[k, 1, 3 * j + 2] = dt * (poses[k, 0] - poses[j + 1, 0])
            out[k, 2, 3 * j + 2] = dt
    return out
