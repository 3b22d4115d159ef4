import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cohelm.geometry import compose, transform, wrap_angle
from cohelm.robots import Unicycle, move
from cohelm.testing.strategies import angles, inputs, poses

TWISTS = st.tuples(st.floats(-2, 2), st.floats(-2, 2), st.floats(-3, 3)).map(np.array)


@given(poses(), inputs(), st.floats(0.02, 0.2))
def test_sensitivity_is_the_derivative_of_the_rollout(pose, u, dt):
    """Central differences with h = 1e-5: error h²/6 times a third derivative of at most 12·dt."""
    unicycle = Unicycle()
    exact = unicycle.sensitivity(unicycle.rollout(pose, u, dt), u, dt)
    h = 1e-5
    for column in range(u.size):
        push = np.zeros(u.shape)
        push.flat[column] = h
        ahead, behind = (unicycle.rollout(pose, u + s * push, dt) for s in (1.0, -1.0))
        assert np.abs((ahead - behind) / (2.0 * h) - exact[:, :, column]).max() < 1e-6


def test_eq_10_by_hand():
    # two steps of 0.1 s: 1 m/s ahead while turning at 1 rad/s; the second along 0.1 rad
    poses = Unicycle().rollout(np.zeros(3), np.ones((2, 2)), 0.1)
    by_hand = [[0, 0, 0], [0.1, 0, 0.1], [0.1 + 0.1 * np.cos(0.1), 0.1 * np.sin(0.1), 0.2]]
    assert np.abs(poses - by_hand).max() < 1e-15


def test_a_unicycle_drops_what_it_cannot_do():
    assert Unicycle().input(np.array([0.5, 0.3, 0.2])).tolist() == [0.5, 0.2]
    assert Unicycle().twist(np.array([[0.5, 0.2]])).tolist() == [[0.5, 0.0, 0.2]]


def test_bounds_come_from_the_limits(chair):
    lower, upper, rise, fall = Unicycle().bounds(chair.limits)
    assert lower.tolist() == [-chair.max_reverse_speed, -chair.max_turn_rate]
    assert upper.tolist() == [chair.max_speed, chair.max_turn_rate]
    assert rise.tolist() == [chair.max_acceleration, chair.max_turn_acceleration]
    assert fall.tolist() == [chair.max_deceleration, chair.max_turn_acceleration]


@given(poses(5.0), TWISTS, st.floats(0.01, 1.0))
def test_a_move_is_many_small_euler_steps(pose, twist, dt):
    """4,000 steps: the error of Euler's method is |v| |ω| dt² / (2 · 4000) ≤ 1.1e-3 here."""
    steps = 4000
    heading = pose[2] + twist[2] * dt * np.arange(steps) / steps
    cos, sin = np.cos(heading).mean(), np.sin(heading).mean()
    euler = pose[:2] + dt * np.array(
        [twist[0] * cos - twist[1] * sin, twist[0] * sin + twist[1] * cos]
    )
    got = move(pose, twist, dt)
    assert np.abs(got[:2] - euler).max() < 1.2e-3
    assert abs(wrap_angle(got[2] - pose[2] - twist[2] * dt)) < 1e-9


@given(poses(5.0), TWISTS, st.floats(0.0, 1.0), st.floats(0.0, 1.0))
def test_moving_twice_is_moving_once_for_as_long(pose, twist, first, second):
    once = move(pose, twist, first + second)
    twice = move(move(pose, twist, first), twist, second)
    assert np.abs(once[:2] - twice[:2]).max() < 1e-6
    assert abs(wrap_angle(once[2] - twice[2])) < 1e-9


@given(poses(5.0), TWISTS, st.floats(0.0, 1.0))
def test_moving_back_comes_back(pose, twist, dt):
    back = move(move(pose, twist, dt), -twist, dt)
    assert np.abs(back[:2] - pose[:2]).max() < 1e-6


@given(poses(5.0), poses(5.0), TWISTS)
def test_a_move_does_not_depend_on_where_the_map_begins(X_AB, pose, twist):
    there = move(compose(X_AB, pose), twist, 0.3)
    here = move(pose, twist, 0.3)
    assert np.abs(there[:2] - transform(X_AB, here[:2])).max() < 1e-6


@given(angles(), st.floats(1e-12, 1e-6))
def test_straight_on_is_the_limit_of_ever_wider_arcs(heading, turn):
    pose = np.array([0.0, 0.0, heading])
    arc = move(pose, np.array([1.0, 0.5, turn]), 1.0)
    line = move(pose, np.array([1.0, 0.5, 0.0]), 1.0)
    assert np.abs(arc[:2] - line[:2]).max() < 2.0 * turn + 1e-9


@pytest.mark.parametrize("turn", [0.5, -0.5, 3.0])
def test_an_arc_by_hand(turn):
    # v = 1 m/s on a circle of radius 1/ω, centre at (0, 1/ω)
    got = move(np.zeros(3), np.array([1.0, 0.0, turn]), 1.0)
    assert got == pytest.approx([np.sin(turn) / turn, (1.0 - np.cos(turn)) / turn, turn])
