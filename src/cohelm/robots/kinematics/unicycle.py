"""Robots that cannot move sideways, such as a chair with two driven wheels."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row
from cohelm.arrays import Floats, read_only
from cohelm.config import Model
from cohelm.kernels import CACHED
from cohelm.robots.kinematics.api import InputBounds
from cohelm.robots.kinematics.motion import rollout_sensitivity


class Unicycle:
    """Xu et al., eq. (10): x⁺ = x + Δt (v cos θ, v sin θ, ω); inputs (v, ω)."""

    class Parameters(Model):
        """There are none."""

    inputs = 2
    translating = 1
    turned = 0.0
    facets = read_only(np.empty((0, 2)))

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def twist(self, u: Floats) -> Floats:
        """(v, 0, ω)."""
        u = np.asarray(u)
        out = np.zeros((*u.shape[:-1], 3), dtype=u.dtype)
        out[..., 0] = u[..., 0]
        out[..., 2] = u[..., 1]
        return out

    def input(self, twist: Floats) -> Floats:
        """(v_x, ω); the sideways velocity is dropped."""
        return np.asarray(twist)[..., ::2].copy()

    def bounds(self, limits: Floats) -> InputBounds:
        """See :meth:`Kinematics.bounds`."""
        v, reverse, turn, speed_up, brake, turn_up = limits
        return InputBounds(
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
        return rollout_sensitivity(poses, 2, dt, 0)


class TurnFirst(Unicycle):
    """x⁺ = x + Δt (v cos θ⁺, v sin θ⁺, ω) with θ⁺ = θ + Δt ω; inputs (v, ω).

    The unicycle of CrowdNav (Chen et al. 2019, ``crowd_sim/envs/utils/agent.py``): it turns, then
    moves straight on within each step. No real drive does; planners need it for such simulators.
    """

    turned = 1.0

    def rollout(self, pose: Floats, inputs: Floats, dt: float) -> Floats:
        """See :meth:`Kinematics.rollout`."""
        return _turn_first_rollout(pose, inputs, dt)

    def sensitivity(self, poses: Floats, inputs: Floats, dt: float) -> Floats:
        """Closed form: ∂p_k/∂v_j = Δt e_{j+1}, ∂p_k/∂ω_j = Δt (p_k − p_j)^⊥, ∂θ_k/∂ω_j = Δt."""
        return rollout_sensitivity(poses, 2, dt, 1)


@njit(**CACHED)
def unicycle_rollout(pose: Floats, inputs: Floats, dt: float) -> Floats:
    """Poses (N+1, 3) of eq. (10) from ``pose`` under inputs (N, 2)."""
    out = np.empty((inputs.shape[0] + 1, 3))
    copy_row(out[0], pose)
    for k in range(inputs.shape[0]):
        v, w = inputs[k, 0], inputs[k, 1]
        out[k + 1, 0] = out[k, 0] + dt * v * math.cos(out[k, 2])
        out[k + 1, 1] = out[k, 1] + dt * v * math.sin(out[k, 2])
        out[k + 1, 2] = out[k, 2] + dt * w
    return out


@njit(**CACHED)
def _turn_first_rollout(pose: Floats, inputs: Floats, dt: float) -> Floats:
    out = np.empty((inputs.shape[0] + 1, 3))
    out[0] = pose
    for k in range(inputs.shape[0]):
        v, heading = inputs[k, 0], out[k, 2] + dt * inputs[k, 1]
        out[k + 1, 0] = out[k, 0] + dt * v * math.cos(heading)
        out[k + 1, 1] = out[k, 1] + dt * v * math.sin(heading)
        out[k + 1, 2] = heading
    return out
