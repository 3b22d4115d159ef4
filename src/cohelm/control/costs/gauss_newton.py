"""Gauss-Newton's quadratic model of ½‖r‖², for the terms that write their Jacobian down."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats


def gauss_newton(residual: Floats, jacobian: Floats) -> tuple[Floats, Floats]:
    """(JᵀJ, Jᵀr) from r (q,) and J (q, c)."""
    return jacobian.T @ jacobian, residual @ jacobian


@njit(cache=True)
def pose_model(error: Floats, weight: Floats, sensitivity: Floats) -> tuple[Floats, Floats]:
    """(H (c, c), g (c,)) of ½ Σ_k Σ_a weight·error² over poses 1…N, c = N·m.

    An input has no effect on the poses before it, so that half of the products are zero.
    error, weight: (N, 3).  sensitivity: (N+1, 3, c).
    """
    steps, columns = sensitivity.shape[0] - 1, sensitivity.shape[2]
    m = columns // steps
    hessian = np.zeros((columns, columns))
    gradient = np.zeros(columns)
    for k in range(steps):
        reach = m * (k + 1)
        for a in range(3):
            w = weight[k, a]
            if w == 0.0:
                continue
            row = sensitivity[k + 1, a]
            for i in range(reach):
                pull = w * row[i]
                if pull == 0.0:
                    continue
                gradient[i] += pull * error[k, a]
                for j in range(i + 1):
                    hessian[i, j] += pull * row[j]
    for i in range(columns):
        for j in range(i):
            hessian[j, i] = hessian[i, j]
    return hessian, gradient
