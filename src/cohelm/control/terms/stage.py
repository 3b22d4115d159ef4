"""The robot at one state of a trajectory, and the local model to which terms add.

A stage cost is a function of the state x_k and of the inputs u_{k−1} and u_{k−2} that led to it.
Its model is the gradient and a positive semi-definite curvature (Gauss-Newton) by state and input.
"""

from __future__ import annotations

from typing import NamedTuple

from cohelm.arrays import Floats
from cohelm.kernels import INNER, callee


class Stage(NamedTuple):
    """State x_k of a trajectory, k ≥ 1."""

    k: int
    x: float
    y: float
    heading: float
    cos: float
    sin: float
    s: float
    """Arc length on the path, m."""
    d: float
    """Distance to the left of the path, m."""
    i_path: int
    """Nearest sample of the path."""
    speed: float
    """Norm of the translating inputs of the step that led here, m/s."""


class Encounter(NamedTuple):
    """A predicted person as seen from the robot."""

    gap: float
    """Between the robot's capsule and the body, m."""
    distance: float
    """From the nearest point of the capsule's spine to the person's centre, m."""
    ex: float
    """Unit vector from the robot's spine to the person, in the robot frame."""
    ey: float
    nx: float
    """The same vector in the map frame."""
    ny: float
    sx: float
    """Nearest point of the spine, in the robot frame, m."""
    sy: float
    inside: bool
    """That point is not an end of the spine."""


class LocalModel(NamedTuple):
    """Gradient and curvature of a cost along a trajectory of L steps."""

    pose_gradient: Floats
    """(L+1, 3)."""
    pose_curvature: Floats
    """(L+1, 6): xx, xy, xθ, yy, yθ, θθ."""
    input_gradient: Floats
    """(L, m)."""
    input_curvature: Floats
    """(L, m), of each input."""
    input_coupling: Floats
    """(L, m), of each input with itself one step before."""


@callee(INNER)
def add_slope(q: LocalModel, k: int, slope: float, jx: float, jy: float, ja: float) -> None:
    """Add the gradient ``slope``·(jx, jy, ja) at state k."""
    q.pose_gradient[k, 0] += slope * jx
    q.pose_gradient[k, 1] += slope * jy
    q.pose_gradient[k, 2] += slope * ja


@callee(INNER)
def add_curvature(q: LocalModel, k: int, size: float, jx: float, jy: float, ja: float) -> None:
    """Add the curvature ``size``·j jᵀ, j = (jx, jy, ja), at state k."""
    row = q.pose_curvature[k]
    row[0] += size * jx * jx
    row[1] += size * jx * jy
    row[2] += size * jx * ja
    row[3] += size * jy * jy
    row[4] += size * jy * ja
    row[5] += size * ja * ja


@callee(INNER)
def add_square(
    q: LocalModel, k: int, weight: float, r: float, jx: float, jy: float, ja: float
) -> None:
    """Add the model of ``weight``·r² at state k, with (jx, jy, ja) = ∂r/∂x_k."""
    add_slope(q, k, 2.0 * weight * r, jx, jy, ja)
    add_curvature(q, k, 2.0 * weight, jx, jy, ja)
