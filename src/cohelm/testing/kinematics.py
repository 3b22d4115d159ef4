"""Contract of ``robots.Kinematics``."""

from __future__ import annotations

import numpy as np

from cohelm.geometry import transform
from cohelm.robots import Kinematics
from cohelm.testing.conformance import TOLERANCE, require, require_finite, steady

_LIMITS = np.array([1.2, 0.3, 1.2, 0.8, 1.0, 2.5])
_STEP = 0.1
_POSE = np.array([1.0, -2.0, 0.7])
_LOSS = 1.05
"""Allowed loss by facets of the disc of velocities: 1 / 1.05 of the speed is left."""


def check_kinematics(motion: Kinematics) -> None:
    """Check a motion model: bounds, speed, rollout, exact sensitivities, equivariance.

    Raises:
        ConformanceError: naming the violated rule.
    """
    m = motion.inputs
    require(m >= 1, f"inputs must be a positive number, is {m!r}")
    inputs = _sample_inputs(motion)
    _check_bounds(motion)
    _check_twists(motion, inputs)
    _check_speed(motion, inputs)
    _check_rollout(motion, inputs)
    _check_turned(motion)
    _check_sensitivity(motion, inputs)


def _sample_inputs(motion: Kinematics) -> np.ndarray:
    lower, upper, _, _ = motion.bounds(_LIMITS)
    share = np.random.default_rng(0).random((12, motion.inputs))
    return np.asarray(lower + share * (upper - lower))


def _check_bounds(motion: Kinematics) -> None:
    lower, upper, rise, fall = steady(
        lambda: motion.bounds(_LIMITS), inputs=_LIMITS, what="bounds", within=1.0
    )
    for name, bound in (("lower", lower), ("upper", upper), ("rise", rise), ("fall", fall)):
        require(np.shape(bound) == (motion.inputs,), f"bounds: {name} must be (m,)")
        require_finite({f"bounds: {name}": bound})
    require((lower <= 0.0) & (upper >= 0.0), "bounds must allow standing still")
    require((rise > 0.0) & (fall > 0.0), "bounds: rise and fall must be positive")


def _check_twists(motion: Kinematics, inputs: np.ndarray) -> None:
    twist = motion.twist(inputs)
    require(np.shape(twist) == (len(inputs), 3), "twist must turn (..., m) into (..., 3)")
    back = motion.input(twist)
    require(np.abs(back - inputs) < TOLERANCE, "input must undo twist")
    require(motion.twist(np.zeros(motion.inputs)) == 0.0, "no input must be no twist")


def _check_speed(motion: Kinematics, inputs: np.ndarray) -> None:
    """Check that speed is the norm of the translating inputs, and facets approximate it."""
    over = motion.translating
    require(over in (1, 2), f"translating must be 1 or 2, is {over!r}")
    norm = np.linalg.norm(inputs[:, :over], axis=1)
    speed = np.linalg.norm(motion.twist(inputs)[:, :2], axis=1)
    require(np.abs(speed - norm) < TOLERANCE, "the translating inputs must be the velocity")
    facets = np.asarray(motion.facets)
    require(
        facets.ndim == 2 and facets.shape[1] == motion.inputs, "facets must be (f, m), f may be 0"
    )
    require_finite({"facets": facets})
    require(facets[:, over:] == 0.0, "facets must not bound the turning inputs")
    course = np.linspace(-np.pi, np.pi, 360)
    circle = np.zeros((360, motion.inputs))
    circle[:, :over] = np.column_stack([np.cos(course), np.sin(course)])[:, :over]
    circle = circle[np.linalg.norm(circle[:, :over], axis=1) > 1.0 - TOLERANCE]
    reached = (circle @ facets.T).max(axis=1, initial=0.0 if len(facets) else 1.0)
    require(reached >= 1.0 - TOLERANCE, "facets must keep the norm of the speed")
    require(reached <= _LOSS, "facets must not take more than a twentieth of the speed")


def _check_rollout(motion: Kinematics, inputs: np.ndarray) -> None:
    poses = steady(
        lambda: motion.rollout(_POSE, inputs, _STEP),
        inputs=(_POSE, inputs),
        what="rollout",
        within=1.0,
    )
    require(poses.shape == (len(inputs) + 1, 3), "rollout must return (N+1, 3)")
    require_finite({"rollout": poses})
    require(poses[0] == _POSE, "rollout must begin at the given pose")
    still = motion.rollout(_POSE, np.zeros_like(inputs), _STEP)
    require(np.abs(still - _POSE) < TOLERANCE, "a robot without input must not move")
    prefix = motion.rollout(_POSE, inputs[:5], _STEP)
    require(prefix == poses[:6], "rollout must not depend on later inputs")
    from_origin = motion.rollout(np.zeros(3), inputs, _STEP)
    moved = np.column_stack([transform(_POSE, from_origin[:, :2]), from_origin[:, 2] + _POSE[2]])
    require(
        np.abs(moved - poses) < TOLERANCE,
        "moving and turning the start must move the whole rollout",
    )


def _check_turned(motion: Kinematics) -> None:
    """Check that the first step leads in the heading after that share of the turn."""
    share = motion.turned
    require(0.0 <= share <= 1.0, f"turned must be from 0 to 1, is {share!r}")
    _, upper, _, _ = motion.bounds(_LIMITS)
    half = 0.5 * upper[None]
    displacement = np.diff(motion.rollout(_POSE, half, _STEP)[:, :2], axis=0)[0]
    vx, vy, turn = motion.twist(half)[0]
    course = _POSE[2] + share * _STEP * turn + np.arctan2(vy, vx)
    wanted = _STEP * np.hypot(vx, vy) * np.array([np.cos(course), np.sin(course)])
    require(
        np.abs(displacement - wanted) < TOLERANCE,
        f"rollout must turn by {share:g} of a step before it moves",
    )


def _check_sensitivity(motion: Kinematics, inputs: np.ndarray) -> None:
    """Check against central differences: error h² = 1e-10 in the derivative, 1e-6 allowed."""
    poses = motion.rollout(_POSE, inputs, _STEP)
    exact = motion.sensitivity(poses, inputs, _STEP)
    require(
        exact.shape == (len(inputs) + 1, 3, inputs.size), "sensitivity must return (N+1, 3, N·m)"
    )
    h = 1e-5
    for column in range(inputs.size):
        push = np.zeros(inputs.shape)
        push.flat[column] = h
        above = motion.rollout(_POSE, inputs + push, _STEP)
        below = motion.rollout(_POSE, inputs - push, _STEP)
        error = np.abs((above - below) / (2.0 * h) - exact[:, :, column]).max()
        require(
            error < TOLERANCE,
            f"sensitivity to input {column % motion.inputs} at step {column // motion.inputs} "
            f"differs from finite differences by {error:.2g}",
        )
