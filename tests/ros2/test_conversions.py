"""Messages to values: exact, and wrong ones are refused."""

import math

import numpy as np
import pytest

from cohelm.config import validate
from cohelm.errors import ConfigError
from cohelm.maps import OccupancyGrid
from cohelm.messages import RiderCommand
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.conversions import DeadManButton, grid_of, moving, stick_of, twist_at_base
from cohelm.ros2.inputs import FrameTree
from cohelm.ros2.parameters import Ros2Parameters, StickParameters
from tests.ros2.messages import odometry


def test_a_map_comes_back_as_it_was_sent():
    rng = np.random.default_rng(0)
    data = rng.choice(np.array([-1, 0, 100], dtype=np.int8), size=(7, 11))
    sent = OccupancyGrid(data=data, resolution=0.05, X_MG=np.array([-3.0, 2.0, 0.3]))
    got = grid_of(ros.grid(1.0, "map", sent))
    np.testing.assert_array_equal(got.data, data)
    np.testing.assert_allclose(got.X_MG, sent.X_MG)
    assert got.resolution == 0.05


def test_a_map_whose_data_do_not_fit_is_refused():
    message = ros.grid(
        0.0, "map", OccupancyGrid(data=np.zeros((2, 3), np.int8), resolution=0.1, X_MG=np.zeros(3))
    )
    message.data = message.data[:-1]
    with pytest.raises(ValueError, match="2 × 3"):
        grid_of(message)


def test_an_odometry_comes_back_as_it_was_sent():
    found = moving(odometry(3.25))
    assert (found.frame, found.child, found.time) == ("odom", "base_link", 3.25)
    np.testing.assert_allclose(found.twist, [0.4, 0.0, 0.2])
    np.testing.assert_allclose(found.X_OC[:2, 3], [1.0, 2.0])


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.0])
def test_a_twist_moves_every_point_of_a_rigid_body_alike(yaw):
    # Velocity of the base's origin by finite differences of the rigid motion of the other frame.
    twist, X_CB = np.array([0.3, 0.1, 0.4]), np.eye(4)
    X_CB[:2, 3] = 0.2, -0.5
    X_CB[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    dt, at = 1e-6, X_CB[:2, 3]
    turned = np.array(
        [
            [math.cos(twist[2] * dt), -math.sin(twist[2] * dt)],
            [math.sin(twist[2] * dt), math.cos(twist[2] * dt)],
        ]
    )
    velocity = (turned @ at + twist[:2] * dt - at) / dt
    expected = X_CB[:2, :2].T @ velocity
    np.testing.assert_allclose(twist_at_base(twist, X_CB)[:2], expected, atol=1e-5)


def joy(axes, buttons):
    message = ros.joy("", RiderCommand(heartbeat=0.0, deflection=np.zeros(2)))
    message.axes = np.array(axes, dtype=np.float32)
    message.buttons = np.array(buttons, dtype=np.int32)
    return message


def test_a_stick_has_axes_and_buttons():
    chosen = StickParameters(dead_man=2)
    found = stick_of(joy([0.25, 0.5], [1, 0, 1]), chosen)
    assert found == (0.5, 0.25, True, True)
    assert not stick_of(joy([0.25, 0.5], [0, 0, 0]), chosen).held


def test_a_message_that_is_repeated_is_no_sign_of_the_rider():
    button, held = DeadManButton(), joy([0.0, 0.5, math.nan], [0, 0, 1])
    for k in range(100):
        button = button.after(held, 0.1 * k)
    assert not button.unchanged(4.9, 5.0)
    assert button.unchanged(5.1, 5.0)
    assert not button.after(joy([0.0, 0.51, math.nan], [0, 0, 1]), 10.0).unchanged(14.9, 5.0)


@pytest.mark.parametrize(
    ("axes", "buttons", "text"),
    [([0.1], [0, 0, 0], "axis 1"), ([math.nan, 0.0], [0, 0, 0], "number"), ([0, 0], [0], "2 is")],
)
def test_a_stick_that_lacks_something_is_refused(axes, buttons, text):
    with pytest.raises(ValueError, match=text):
        stick_of(joy(axes, buttons), StickParameters(dead_man=2))


def test_transforms_form_a_tree():
    tree, half_turn = FrameTree(), (0.0, 0.0, 1.0, 0.0)
    add = lambda a, b, t: tree.add(a, b, t, time=0.0, arrival=0.0)  # noqa: E731  # a short helper
    assert add("map", "odom", (1.0, 0.0, 0.0, *half_turn))
    assert add("/odom", "base", (2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0))
    assert not add("base", "map", (0.0, 0.0, 0.0, *half_turn))  # a cycle
    assert not add("map", "zero", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert not add("map", "nan", (math.nan, 0.0, 0.0, *half_turn))
    found = tree.pose("map", "base")
    np.testing.assert_allclose(found[:2, 3], [-1.0, 0.0], atol=1e-12)  # 1 m, turned, 2 m back
    np.testing.assert_allclose(found @ tree.pose("base", "map"), np.eye(4), atol=1e-12)
    assert tree.pose("map", "elsewhere") is None


@pytest.mark.parametrize(
    ("given", "text"),
    [
        ({"scan": "/scan"}, "scans"),
        ({"scans": ["scan"]}, "/scan"),
        ({"scans": []}, "scans or clouds"),
        ({"frames": {"bse": "base"}}, "base"),
        ({"dds": {"domain": 900}}, "domain"),
    ],
)
def test_a_wrong_file_is_refused_with_the_remedy(given, text):
    with pytest.raises(ConfigError, match=text):
        validate(Ros2Parameters, given, prefix="platform")
