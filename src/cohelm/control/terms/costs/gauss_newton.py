"""Gauss-Newton model of ½‖r‖², and weights per input; shared by the cost terms."""

from __future__ import annotations

import functools

import numpy as np
from numba import njit

from cohelm.arrays import Floats, read_only
from cohelm.robots import Kinematics


def gauss_newton(residual: Floats, jacobian: Floats) -> tuple[Floats, Floats]:
    """(JᵀJ, Jᵀr) from r (q,) and J (q, c)."""
    return jacobian.T @ jacobian, residual @ jacobian


@njit(cache=True)
def pose_model(error: Floats, weight: Floats, sensitivity: Floats) -> tuple[Floats, Floats]:
    """(H (c, c), g (c,)) of ½ Σ_k Σ_a weight·error² over poses 1…N, c = N·m.

    An input has no effect on earlier poses, which saves half of the products.
    error, weight: (N, 3).  sensitivity: (N+1, 3, c).
    """
    steps, columns = sensitivity.shape[0] - 1, sensitivity.shape[2]
    m = columns // steps
    hessian = np.zeros((columns, columns))
    gradient = np.zeros(columns)
    for k in range(steps):
        num_effective = m * (k + 1)  # inputs before this pose
        for a in range(3):
            w = weight[k, a]
            if w == 0.0:
                continue
            row = sensitivity[k + 1, a]
            for i in range(num_effective):
                weighted = w * row[i]
                if weighted == 0.0:
                    continue
                gradient[i] += weighted * error[k, a]
                for j in range(i + 1):
                    hessian[i, j] += weighted * row[j]
    for i in range(columns):
        for j in range(i):
            hessian[j, i] = hessian[i, j]
    return hessian, gradient


@functools.lru_cache(maxsize=16)
def no_cost(size: int) -> tuple[Floats, Floats]:
    """(H, (size, size); g, (size,)) of a term without a weight."""
    return read_only(np.zeros((size, size))), read_only(np.zeros(size))


@functools.lru_cache(maxsize=64)
def per_input(
    kinematics: Kinematics,
    linear: float,
    angular: float,
    multiplier: float = 1.0,
    divisor: float = 1.0,
) -> Floats:
    """Weights (m,) · multiplier / divisor, of linear velocities and of turn rates."""
    n_linear = kinematics.translating
    each = np.array([linear] * n_linear + [angular] * (kinematics.inputs - n_linear))
    return read_only(each * multiplier / divisor)
