"""Omnidirectional robots, and the agents of crowd benchmarks."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, read_only
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.robots.kinematics.api import InputBounds
from cohelm.robots.kinematics.motion import rollout_sensitivity

_SIDES = 16
"""Sides of the polygon that replaces the disc of allowed velocities; it loses up to 1.9 %."""


class Holonomic:
    """x⁺ = x + Δt (R(θ) (v_x, v_y), ω); inputs (v_x, v_y, ω) in the robot frame.

    The norm of the velocity is bounded, ‖(v_x, v_y)‖ ≤ v_max. The linear form is an inscribed
    polygon with a corner straight ahead, so both axes keep the full speed. ``max_reverse_speed``
    bounds backward motion as well. Sideways changes are bounded by the braking deceleration,
    because their sign does not tell acceleration from braking.
    """

    class Parameters(Model):
        """There are none."""

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

    def bounds(self, limits: Floats) -> InputBounds:
        """See :meth:`Kinematics.bounds`."""
        v, reverse, turn, speed_up, brake, turn_up = limits
        return InputBounds(
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
        return rollout_sensitivity(poses, 3, dt, 0)


@njit(**CACHED)
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
