"""The shared reference, eq. (12): x̂ = η x_user + (1 − η) x_global."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.geometry import compose, wrap_angle
from cohelm.messages import Authority, Reference
from cohelm.sharing import shared_reference

N, STEP = 10, 0.1


def along(poses, speeds=0.5):
    poses = np.asarray(poses, dtype=float)
    return Reference(step=STEP, poses=poses, speeds=np.full(len(poses), speeds))


def hand(eta, states):
    return Authority(eta=eta, intent=1.0, deflection=np.zeros(2), twist=np.zeros(3), states=states)


def arc(turn, *, speed=0.5, heading=0.0):
    """Poses (N+1, 3) of a constant turn from the origin."""
    angle = heading + turn * STEP * np.arange(N + 1)
    steps = speed * STEP * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    xy = np.vstack([np.zeros(2), np.cumsum(steps[:-1], axis=0)])
    return np.column_stack([xy, angle])


def test_without_authority_it_is_the_paths_reference_itself():
    path = along(arc(0.3))
    assert shared_reference(path, hand(0.0, along(arc(-1.0)))) is path


@given(st.floats(0.01, 0.99), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0))
def test_it_is_eq_12(eta, path_turn, hand_turn):
    path, rider = along(arc(path_turn), 0.8), along(arc(hand_turn), 0.2)
    out = shared_reference(path, hand(eta, rider))
    np.testing.assert_allclose(
        out.poses, eta * rider.poses + (1.0 - eta) * path.poses, rtol=0.0, atol=1e-12
    )
    np.testing.assert_allclose(out.speeds, eta * 0.2 + (1.0 - eta) * 0.8)
    assert out.step == path.step


@pytest.mark.parametrize("eta", [0.25, 0.5, 0.63])
def test_headings_blend_the_short_way_across_the_half_turn(eta):
    # path 0.2 short of π, rider 0.2 beyond it, written as −π + 0.2: they are 0.4 apart
    path = along(arc(0.0, heading=np.pi - 0.2))
    rider = along(arc(0.0, heading=-np.pi + 0.2))
    out = shared_reference(path, hand(eta, rider))
    np.testing.assert_allclose(
        wrap_angle(out.poses[:, 2] - np.pi), -0.2 + eta * 0.4, rtol=0.0, atol=1e-12
    )


@pytest.mark.parametrize("turns", [-9.0, -4.0, 4.0, 9.0])
def test_headings_stay_continuous_however_far_the_rider_turns(turns):
    """The blend turns as fast as the blend of both: also where they come to face each other."""
    path, rider = along(arc(0.4)), along(arc(turns))
    rider = dataclasses.replace(
        rider, poses=np.column_stack([rider.poses[:, :2], wrap_angle(rider.poses[:, 2])])
    )
    out = shared_reference(path, hand(0.6, rider))
    expected = 0.6 * turns * STEP + 0.4 * 0.4 * STEP
    np.testing.assert_allclose(np.diff(out.poses[:, 2]), expected, rtol=0.0, atol=1e-12)


@given(st.floats(0.0, 0.99), st.floats(-3.0, 3.0), st.floats(-2.0, 2.0))
def test_it_does_not_prefer_a_direction(eta, angle, turn):
    X = np.array([2.0, -1.0, angle])
    plain = shared_reference(along(arc(0.2)), hand(eta, along(arc(turn))))
    moved = shared_reference(along(compose(X, arc(0.2))), hand(eta, along(compose(X, arc(turn)))))
    expected = compose(X, plain.poses)
    np.testing.assert_allclose(moved.poses[:, :2], expected[:, :2], rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(
        wrap_angle(moved.poses[:, 2] - expected[:, 2]), 0.0, rtol=0.0, atol=1e-9
    )
