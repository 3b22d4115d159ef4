"""LUCI's numbers: signs, scaling, limits and the odometry of its encoders."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

pytest.importorskip("grpc", reason="needs the extra luci")

from cohelm.platforms.luci import protocol
from cohelm.platforms.luci.conversions import (
    WINDOW,
    advanced,
    joystick_of,
    points_of,
    stick_of,
)
from cohelm.platforms.luci.parameters import Scaling, Wheels

SCALING = Scaling(forward_speed=1.2, reverse_speed=0.6, turn_rate=0.8)
WHEELS = Wheels()
TWISTS = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@pytest.mark.parametrize(
    ("twist", "numbers"),
    [
        ((0.0, 0.0), (0, 0)),
        ((0.6, 0.0), (50, 0)),  # 0.6 of 1.2 m/s
        ((-0.3, 0.0), (-50, 0)),  # 0.3 of 0.6 m/s backwards
        ((0.0, 0.4), (0, -50)),  # to the left is negative
        ((0.0, -0.8), (0, 100)),
        ((1.2, 0.8), (100, -100)),
        ((2.4, 0.8), (100, -50)),  # half of it: the arc stays
        ((math.nan, 0.1), (0, 0)),
        ((math.inf, 0.0), (0, 0)),
    ],
)
def test_a_twist_becomes_joystick_numbers(twist, numbers):
    assert joystick_of(np.array([twist[0], 0.0, twist[1]]), SCALING) == numbers


@given(TWISTS, st.integers(0, 50), st.integers(60, 100))
def test_numbers_stay_within_the_limit_and_keep_the_signs(twist, start, limit):
    scaling = SCALING.model_copy(update={"start": start, "limit": limit})
    forward, right = joystick_of(np.array([twist[0], 0.0, twist[1]]), scaling)
    assert max(abs(forward), abs(right)) <= limit
    assert forward * twist[0] >= 0
    assert right * twist[1] <= 0
    for number in (forward, right):
        assert number == 0 or abs(number) >= start


def test_the_slowest_motion_begins_where_the_chair_does():
    scaling = SCALING.model_copy(update={"start": 20})
    # 20 + 80 × 0.06 / 1.2
    assert joystick_of(np.array([0.06, 0.0, 0.0]), scaling) == (24, 0)
    assert joystick_of(np.zeros(3), scaling) == (0, 0)


def test_the_rider_s_joystick_is_forward_and_left():
    joystick = protocol.message("JoystickData")
    assert stick_of(joystick(forward_back=60, left_right=-40)) == (0.6, 0.4)
    assert stick_of(joystick(forward_back=-300, left_right=300)) == (-1.0, -1.0)


def test_points_keep_their_order():
    point = protocol.message("Point3D")
    cloud = protocol.message("CameraPoints")(points=[point(x=1, y=2, z=3), point(x=4, y=5, z=6)])
    np.testing.assert_array_equal(points_of(cloud), [[1, 2, 3], [4, 5, 6]])
    assert points_of(protocol.message("CameraPoints")()).shape == (0, 3)


def driven(left, right, wheels=WHEELS, steps=100, duration=1.0):
    """Odometry after wheels that turn evenly by (left, right) degrees in all."""
    state = None
    for k in range(steps + 1):
        angles = (350.0 + left * k / steps) % 360.0, (10.0 + right * k / steps) % 360.0
        state = advanced(state, angles, duration * k / steps, wheels)
    return state


def test_straight_on_is_the_wheels_circumference():
    state = driven(360.0, 360.0)
    np.testing.assert_allclose(state.pose, [1.12, 0.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(state.twist, [1.12, 0.0, 0.0], atol=1e-9)


def test_a_half_turn_ends_a_diameter_to_the_left():
    # About a centre 1 m to the left: π m with a track of 0.56 m, each wheel its own radius.
    degrees = [360.0 * math.pi * (1.0 + side * 0.28) / 1.12 for side in (-1, 1)]
    state = driven(*degrees, steps=400, duration=4.0)
    np.testing.assert_allclose(state.pose[:2], [0.0, 2.0], atol=1e-6)
    assert abs(state.pose[2]) == pytest.approx(math.pi, abs=1e-6)
    assert state.twist[2] == pytest.approx(math.pi / 4.0)


def test_encoders_may_count_down_and_be_geared():
    wheels = Wheels(left_increases=False, gear_ratio=2.0)
    np.testing.assert_allclose(driven(-360.0, 360.0, wheels).pose, [0.56, 0, 0], atol=1e-9)


def test_angles_that_no_chair_can_turn_are_refused():
    state = driven(90.0, 90.0)
    with pytest.raises(ValueError, match="wheel angles"):
        advanced(state, (math.nan, 0.0), 1.1, Wheels())
    with pytest.raises(ValueError, match="wheel angles"):  # 0.56 m in 0.1 s
        advanced(state, (state.angles[0] + 179.0, state.angles[1] + 179.0), 1.1, Wheels())
    assert advanced(state, state.angles, state.time, Wheels()) is state


def test_the_speed_is_the_mean_of_the_window():
    state = driven(360.0, 360.0)
    last = state.angles
    for k in range(12):  # stands
        state = advanced(state, last, 1.0 + 0.01 * (k + 1), Wheels())
    assert sum(each[0] for each in state.steps) <= WINDOW + 0.01 + 1e-9
    np.testing.assert_allclose(state.twist, 0.0, atol=1e-9)
