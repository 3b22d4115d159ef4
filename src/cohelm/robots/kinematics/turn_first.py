"""A robot that turns and then moves straight on within each step: agents of some benchmarks."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.robots.kinematics.unicycle import Unicycle


class TurnFirst(Unicycle):
    """x⁺ = x + Δt (v cos θ⁺, v sin θ⁺, ω) with θ⁺ = θ + Δt ω; inputs (v, ω).

    The unicycle of CrowdNav (Chen et al. 2019, ``crowd_sim/envs/utils/agent.py``). No wheels turn
    so; it is there to plan for what such a simulator does.
    """

    turned = 1.0

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """See :meth:`Kinematics.rollout`."""
        return _rollout(pose, inputs, dt)

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """Closed form: ∂p_k/∂v_j = Δt e_{j+1}, ∂p_k/∂ω_j = Δt (p_k − p_j)^⊥, ∂θ_k/∂ω_j = Δt."""
        return _sensitivity(poses, inputs, dt)


@njit(cache=True)
def _rollout(pose: Floats, inputs: Floats, dt: float) -> Floats:
    out = np.empty((inputs.shape[0] + 1, 3))
    out[0] = pose
    for k in range(inputs.shape[0]):
        v, heading = inputs[k, 0], out[k, 2] + dt * inputs[k, 1]
        out[k + 1, 0] = out[k, 0] + dt * v * math.cos(heading)
        out[k + 1, 1] = out[k, 1] + dt * v * math.sin(heading)
        out[k + 1, 2] = heading
    return out


@njit(cache=True)
def _sensitivity(poses: Floats, inputs: Floats, dt: float) -> Floats:
    n = inputs.shape[0]
    out = np.zeros((n + 1, 3, 2 * n))
    for j in range(n):
        cos, sin = math.cos(poses[j + 1, 2]), math.sin(poses[j + 1, 2])
        for k in range(j + 1, n + 1):
            out[k, :2, 2 * j] = dt * cos, dt * sin
            out[k, 0, 2 * j + 1] = -dt * (poses[k, 1] - poses[j, 1])
            out[k, 1, 2 * j + 1] = dt * (poses[k, 0] - poses[j, 0])
            out[k, 2, 2 * j + 1] = dt
    return out
