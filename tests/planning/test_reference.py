"""The reference is as fast as curves, goal and robot allow."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.geometry import nearest_on_polyline, resample
from cohelm.planning import ComfortLimits, ReferenceSettings, make_reference

from .floors import CHAIR, path_of

STILL = np.zeros(3)
STRAIGHT = path_of(resample(np.array([[0.0, 0.0], [20.0, 0.0]]), 0.1))
angles = np.linspace(0.0, 1.5 * np.pi, 60)
BEND = path_of(2.0 * np.stack([np.sin(angles), 1.0 - np.cos(angles)], axis=1))
"""A left turn of 2 m radius through 270°."""
figure = np.linspace(0.0, 2.0 * np.pi, 300)
EIGHT = path_of(4.0 * np.stack([np.sin(figure), np.sin(figure) * np.cos(figure)], axis=1))
"""Crosses itself in the origin, where it starts and ends."""


def follow(path, pose, twist=STILL, *, progress=None, **settings):
    pose, twist = np.asarray(pose, dtype=float), np.asarray(twist, dtype=float)
    given = {"steps": 30, "step": 0.1, "speed": 0.8, "robot": CHAIR, **settings}
    return make_reference(path, pose, twist, ReferenceSettings(**given), progress=progress)


def test_speeds_up_from_the_current_speed_within_the_robots_acceleration():
    ref, progress = follow(STRAIGHT, (3.0, 0.4, 0.0), (0.3, 0.0, 0.0))
    assert progress == pytest.approx(3.0)
    assert ref.poses[0].tolist() == pytest.approx([3.0, 0.0, 0.0])  # on the path, not at the robot
    assert ref.speeds[0] == pytest.approx(0.3)
    # Beside the path the robot has to turn atan(0.4) toward it first, which makes a start slower.
    assert (np.diff(ref.speeds) <= CHAIR.max_acceleration * 0.1 + 1e-12).all()
    assert ref.speeds[-1] == pytest.approx(0.8)


def test_on_the_path_the_ramp_is_the_robots_own():
    ref, _ = follow(STRAIGHT, (3.0, 0.0, 0.0))
    # 0.8 m/s² · 0.1 s = 0.08 m/s a step, up to 0.8 m/s
    assert np.allclose(ref.speeds[:11], 0.08 * np.arange(11))
    assert np.allclose(ref.speeds[10:], 0.8)


def test_positions_are_the_speeds_summed_up():
    ref, _ = follow(BEND, (0.0, 0.0, 0.0), steps=60)
    along = [nearest_on_polyline(BEND.points, x, y)[0] for x, y in ref.poses[:, :2]]
    middle = 0.5 * (ref.speeds[1:] + ref.speeds[:-1])
    assert np.allclose(np.diff(along), 0.1 * middle, atol=1e-6)


def test_brakes_in_comfort_and_ends_on_the_goal_at_rest():
    ref, _ = follow(STRAIGHT, (18.9, 0.0, 0.0), (0.8, 0.0, 0.0), steps=60)
    assert ref.poses[-1].tolist() == pytest.approx([20.0, 0.0, 0.0], abs=1e-12)
    assert ref.speeds[-1] == 0.0
    brake = ComfortLimits().deceleration
    left = 20.0 - ref.poses[:, 0]
    assert (ref.speeds <= np.sqrt(2.0 * brake * left) + 1e-6).all()
    assert np.diff(ref.speeds)[:-2].min() >= -brake * 0.1 - 0.025  # limits are kept at the points
    stopped = np.argmax(ref.speeds == 0.0)
    assert (ref.poses[stopped + 1 :] == ref.poses[-1]).all()
    # 0.8 m/s takes 0.8/0.6 = 1.3 s and 0.53 m to stop, after 0.57 m at 0.8 m/s: 2.04 s
    assert 0.1 * stopped == pytest.approx(2.04, abs=0.2)


def test_the_goal_itself_is_a_place_to_stand():
    ref, progress = follow(STRAIGHT, (20.3, 0.1, 0.0), (0.2, 0.0, 0.0))
    assert progress == pytest.approx(20.0)
    assert not ref.speeds.any()
    assert np.allclose(ref.poses, [20.0, 0.0, 0.0])


@pytest.mark.parametrize("radius", [0.3, 0.6, 1.0, 2.0, 5.0])
def test_curves_are_taken_within_lateral_acceleration_and_turn_rate(radius):
    count = max(int(2 * np.pi * radius / 0.05), 12)
    around = np.linspace(0.0, 2.0 * np.pi, count)
    curve = radius * np.stack([np.sin(around), 1.0 - np.cos(around)], axis=1)
    ref, _ = follow(path_of(curve), (0, 0, 0), (1.2, 0, 0), speed=1.2, steps=200)
    comfort = ComfortLimits()
    most = min(
        1.2,
        math.sqrt(comfort.lateral_acceleration * radius),
        comfort.turn_share * CHAIR.max_turn_rate * radius,
    )
    # Where the path begins and ends it counts as straight.
    inside = (ref.poses[:, 2] > 0.5) & (ref.poses[:, 2] < 2.0 * np.pi - 0.5)
    assert inside.any()
    assert ref.speeds[inside].max() <= most * 1.001
    assert ref.speeds[inside].max() >= most * 0.8


def test_never_faster_than_robot_or_request():
    for speed in (0.0, 0.4, 5.0):
        ref, _ = follow(STRAIGHT, (3, 0, 0), (1.2, 0, 0), speed=speed)
        assert ref.speeds.max() <= min(speed, CHAIR.max_speed) + 1e-12


@pytest.mark.parametrize("turns", [-3, -1, 0, 2])
def test_headings_stay_on_the_robots_branch(turns):
    heading = 1.4 * np.pi + 2.0 * np.pi * turns
    x, y = BEND.points[-5]
    ref, _ = follow(BEND, (x, y, heading))
    assert abs(ref.poses[0, 2] - heading) < np.pi
    assert np.abs(np.diff(ref.poses[:, 2])).max() < 0.5


@settings(max_examples=100, deadline=None)
@given(
    x=st.floats(-6, 6),
    y=st.floats(-6, 6),
    heading=st.floats(-20, 20),
    v=st.floats(-0.3, 1.2),
    w=st.floats(-1.2, 1.2),
)
def test_any_robot_gets_a_continuous_reference_on_the_path(x, y, heading, v, w):
    ref, progress = follow(BEND, (x, y, heading), (v, 0.0, w))
    _, distance = nearest_on_polyline(BEND.points, x, y)
    assert np.hypot(ref.poses[0, 0] - x, ref.poses[0, 1] - y) == pytest.approx(distance)
    assert 0.0 <= progress <= BEND.length + 1e-9
    on_path = [nearest_on_polyline(BEND.points, *p)[1] for p in ref.poses[:, :2]]
    assert max(on_path) < 1e-9
    assert np.abs(np.diff(ref.poses[:, 2])).max() < 0.2
    assert abs(ref.poses[0, 2] - heading) <= np.pi + 0.4 + 1e-9
    assert (ref.speeds >= 0.0).all()
    assert ref.speeds.max() <= 0.8 + 1e-12


def test_a_robot_that_faces_away_turns_before_the_reference_leaves():
    ahead, _ = follow(STRAIGHT, (3, 0, 0))
    away, _ = follow(STRAIGHT, (3, 0, 3.0))
    # It has to turn 3 rad at 0.96 rad/s: for the 1.5 s until it faces the path's side, creep.
    assert away.speeds[:14].max() <= ComfortLimits().creep + 1e-12
    assert away.poses[14, 0] - 3.0 < 0.1
    assert away.poses[-1, 0] < ahead.poses[-1, 0]
    assert away.poses[0, 2] == pytest.approx(0.0)


def test_a_turn_about_goes_on_the_way_it_began():
    # The tangent is at 0; the shorter way from −3.0 is left, but the robot already turns right.
    left, _ = follow(STRAIGHT, (3, 0, -3.0), (0, 0, 0.5))
    right, _ = follow(STRAIGHT, (3, 0, -3.0), (0, 0, -0.5))
    assert left.poses[0, 2] == pytest.approx(0.0)
    assert right.poses[0, 2] == pytest.approx(-2.0 * np.pi)


def test_a_robot_beside_the_path_is_waited_for():
    near, _ = follow(STRAIGHT, (3, 0.1, 0))
    far, _ = follow(STRAIGHT, (3, 3.0, 0))
    assert far.poses[10, 0] < near.poses[10, 0]


def test_progress_keeps_its_branch_where_the_path_crosses_itself():
    progress, last = 0.0, 0.0
    for point, ahead in zip(EIGHT.points[:-1], EIGHT.points[1:], strict=True):
        direction = ahead - point
        heading = math.atan2(direction[1], direction[0])
        ref, progress = follow(EIGHT, (*point, heading), (0.5, 0, 0), progress=progress)
        assert progress >= last - 1e-9
        assert progress - last < 0.2
        assert np.cos(ref.poses[0, 2] - heading) > 0.9
        last = progress
    assert progress > EIGHT.length - 0.2


def test_a_path_of_one_point_is_a_place_to_stand():
    path = path_of([[2.0, 3.0], [2.0, 3.0]])
    ref, progress = follow(path, (1.9, 3.0, 0.7), (0.2, 0, 0))
    assert progress == 0.0
    assert np.allclose(ref.poses, [2.0, 3.0, 0.7])
    assert not ref.speeds.any()


def test_a_turned_world_turns_the_reference():
    angle, pose, twist = 0.5 * np.pi, np.array([0.5, -0.3, 0.4]), np.array([0.4, 0.0, 0.1])
    ref, _ = follow(BEND, pose, twist)
    rotation = np.array([[0.0, -1.0], [1.0, 0.0]])
    turned = path_of(BEND.points @ rotation.T)
    ref_turned, _ = follow(turned, [*rotation @ pose[:2], pose[2] + angle], twist)
    assert np.allclose(ref_turned.speeds, ref.speeds, atol=1e-9)
    assert np.allclose(ref_turned.poses[:, :2], ref.poses[:, :2] @ rotation.T, atol=1e-9)
    assert np.allclose(ref_turned.poses[:, 2], ref.poses[:, 2] + angle, atol=1e-9)


@given(st.floats(-3.0, 3.0), st.floats(-0.3, 0.0), st.floats(-0.5, 0.5))
@settings(max_examples=30, deadline=None)
def test_a_path_is_driven_backwards_as_the_robot_turned_about_drives_it(heading, v, w):
    pose = np.array([1.0, 0.2, heading])
    back, at = follow(BEND, pose, (v, 0.0, w), backward=True, speed=CHAIR.max_reverse_speed)
    about = np.array([0.0, 0.0, np.pi])
    ahead, same = follow(BEND, pose + about, (-v, 0.0, w), speed=CHAIR.max_reverse_speed)
    assert at == same
    assert np.allclose(back.poses, ahead.poses - about)
    assert np.allclose(back.speeds, -ahead.speeds)


def test_no_more_than_the_speed_backwards_is_wanted():
    back, _ = follow(BEND, (0.0, 0.0, np.pi), (0.0, 0.0, 0.0), backward=True)
    assert back.speeds.min() == pytest.approx(-CHAIR.max_reverse_speed)
