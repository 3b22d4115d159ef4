import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from cohelm.geometry import compose, transform, wrap_angle
from cohelm.robots import Holonomic, TurnFirst, Unicycle, move
from cohelm.robots.kinematics import slowed, within_limits
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


@given(poses(), inputs(), st.floats(0.02, 0.3))
def test_to_turn_first_is_to_turn_a_step_earlier(pose, u, dt):
    """A unicycle that turned on the spot before, and then lags one turn behind."""
    earlier = np.column_stack([np.append(0.0, u[:, 0]), np.append(u[:, 1], 0.0)])
    got = TurnFirst().rollout(pose, u, dt)
    assert np.abs(got[:, :2] - Unicycle().rollout(pose, earlier, dt)[1:, :2]).max() < 1e-12


@given(poses(), inputs(), st.floats(0.02, 0.2))
def test_a_holonomic_robot_that_does_not_sidestep_is_a_unicycle(pose, u, dt):
    sideways = np.insert(u, 1, 0.0, axis=1)
    difference = Holonomic().rollout(pose, sideways, dt) - Unicycle().rollout(pose, u, dt)
    assert np.abs(difference).max() < 1e-12


def test_a_holonomic_robot_by_hand():
    # a quarter turn in one step of 0.5 s, while 2 m/s to the left; then 1 m/s ahead, which is +y
    u = np.array([[0.0, 2.0, np.pi], [1.0, 0.0, 0.0]])
    got = Holonomic().rollout(np.zeros(3), u, 0.5)
    assert got == pytest.approx(np.array([[0, 0, 0], [0, 1, np.pi / 2], [0, 1.5, np.pi / 2]]))


def test_facets_are_a_polygon_of_16_sides_within_the_disc():
    facets, course = Holonomic().facets, np.linspace(-np.pi, np.pi, 2881)
    velocity = np.column_stack([np.cos(course), np.sin(course), np.zeros(2881)])
    longest = 1.0 / (velocity @ facets.T).max(axis=1)
    # the inscribed polygon: 1 at its corners, of which four are on the axes, cos(π/16) between them
    assert longest.max() == pytest.approx(1.0)
    assert longest.min() == pytest.approx(np.cos(np.pi / 16.0))
    assert longest[[720, 1440, 2160]] == pytest.approx(np.ones(3))
    assert np.isclose(longest, 1.0).sum() == 17  # 16 corners, −180° twice
    assert len(Unicycle().facets) == 0


@given(
    hnp.arrays(float, (9, 3), elements=st.floats(-4.0, 4.0)),
    hnp.arrays(float, 3, elements=st.floats(-0.7, 0.7)),
)
def test_limits_hold_on_the_norm_and_on_every_change(wanted, now):
    """Rise 0.1, fall 0.2 a step, half of it at the first; 1 m/s: (0.7, 0.7) is slower than that."""
    rise, fall = np.full((2, 3), 0.1), np.full((2, 3), 0.2)
    rise[0] *= 0.5
    fall[0] *= 0.5
    top = np.ones(3)
    got = within_limits(wanted, now, -top, top, rise, fall, 2, 1.0)
    assert np.hypot(got[:, 0], got[:, 1]).max() <= 1.0 + 1e-12
    change = np.diff(np.vstack([now, got]), axis=0)
    assert (change[0] <= 0.05 + 1e-12).all()
    assert (change[0] >= -0.1 - 1e-12).all()
    assert change.max() <= 0.1 + 1e-12
    assert change.min() >= -0.2 - 1e-12


def test_limits_that_do_not_bind_change_nothing():
    wanted = np.array([[0.3, -0.2, 0.5], [0.6, 0.1, -0.5]])
    wide = np.full((1, 3), 9.0)
    got = within_limits(wanted, np.zeros(3), -wide[0], wide[0], wide, wide, 2, 1.0)
    assert got == pytest.approx(wanted, abs=1e-15)


def test_slowing_keeps_the_course():
    got = slowed(np.array([[3.0, 4.0, 2.0], [0.3, 0.4, 2.0], [0.0, 0.0, 1.0]]), 1.0, 2)
    assert got == pytest.approx(np.array([[0.6, 0.8, 2.0], [0.3, 0.4, 2.0], [0, 0, 1.0]]))


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
