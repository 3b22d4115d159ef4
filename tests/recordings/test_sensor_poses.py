"""Poses of the robot of a bag and of its sensors."""

import math

import numpy as np
import pytest

from cohelm.geometry import transform
from cohelm.recordings import open_recording
from cohelm.recordings.transforms import Transforms, fixed_axes, matrix, planar

from .bags import ROS1, ROS2, write

LEVEL = (0.0, 0.0, 0.0)


def ride(author, mount=((0.3, 0.1, 0.4), LEVEL), robot="base_link"):
    """1 m/s along y from (2, 0) of the map, which is turned by 90° against odom."""
    static = author.transforms((0.0, robot, "laser", *mount))
    messages = [("/tf_static", 10.0, static)]
    turned = ((2.0, 0.0, 0.0), (0.0, 0.0, math.pi / 2.0))
    for k in range(11):
        time = 10.0 + 0.2 * k
        moved = author.transforms(
            (time, "map", "odom", *turned), (time, "odom", robot, (0.2 * k, 0.0, 0.0), LEVEL)
        )
        messages.append(("/tf", time, moved))
    # the first scan comes before any transform of its time
    messages += [("/scan", t, author.scan(t, [1.0] * 5)) for t in (10.5, 11.1)]
    return sorted(messages, key=lambda message: message[1])


@pytest.mark.parametrize("author", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_the_pose_is_interpolated_along_the_chain(tmp_path, author):
    file = write(tmp_path / "a.bag", ride(author), "bag" if author is ROS1 else "mcap")
    recording = open_recording(file)
    for frame in recording:
        seen = frame.observation
        assert seen.pose == pytest.approx([2.0, seen.time - 10.0, math.pi / 2.0])
        assert seen.twist == pytest.approx([1.0, 0.0, 0.0])
        assert seen.scans[0].mount == pytest.approx([0.3, 0.1, 0.0])
    assert recording.warnings == []


def test_a_footprint_lies_on_the_floor_and_a_link_at_an_unknown_height(tmp_path):
    for robot, height in (("base_footprint", 0.4), ("base_link", math.nan)):
        tilted = ((0.3, 0.0, 0.4), (0.05, 0.1, -0.2))
        messages = [m for m in ride(ROS1, tilted, robot) if m[0] != "/scan"]
        cloud = ROS1.plain_cloud(11.0, [[1, 2, 3]], frame="laser")
        file = write(tmp_path / f"{robot}.bag", [*messages, ("/points", 12.5, cloud)])
        (frame,) = open_recording(file)
        mount = frame.observation.clouds[0].mount
        assert mount == pytest.approx([0.3, 0.0, height, 0.05, 0.1, -0.2], nan_ok=True)


def test_a_scanner_upside_down_sees_what_is_on_the_other_side(tmp_path):
    # 5 beams from −0.5 to 0.5 rad; the first points to the right of a scanner that stands upright
    messages = [m for m in ride(ROS1, ((0.0, 0.0, 0.4), (math.pi, 0.0, 0.3))) if m[0] != "/scan"]
    messages.append(("/scan", 12.5, ROS1.scan(11.0, [1, 2, 3, 4, 5], angle_min=-0.4)))
    (frame,) = open_recording(write(tmp_path / "a.bag", messages))
    (scan,) = frame.observation.scans
    angles = scan.angle_min + scan.angle_increment * np.arange(5)
    got = scan.mount[2] + angles
    # the first beam at 0.3 + 0.4, the last at 0.3 − 0.6
    assert dict(zip(scan.ranges, got, strict=True)) == pytest.approx(
        {1: 0.7, 2: 0.45, 3: 0.2, 4: -0.05, 5: -0.3}
    )
    assert scan.angle_increment > 0.0


def test_odometry_tells_pose_and_twist_where_tf_does_not(tmp_path):
    messages = []
    for k in range(6):
        t = 5.0 + 0.1 * k
        messages.append(("/odom", t, ROS1.odometry(t, (0.1 * k, 0.0, 0.0), (1.0, 0.0, 0.2 * k))))
    messages.append(("/scan", 5.6, ROS1.scan(5.25, [1.0])))
    recording = open_recording(write(tmp_path / "a.bag", messages))
    (frame,) = recording
    assert frame.observation.pose == pytest.approx([0.25, 0.0, 0.0])
    assert frame.observation.twist == pytest.approx([1.0, 0.0, 0.5])
    # nobody says where the laser is on it
    assert any("'laser'" in text and "'base_link'" in text for text in recording.warnings)


def test_tf_counts_where_both_tell_the_pose(tmp_path):
    messages = ride(ROS1)
    wrong = [
        ("/odom", 10.0 + 0.1 * k, ROS1.odometry(10.0 + 0.1 * k, (9.0, 9.0, 1.0), (0.7, 0.0, 0.1)))
        for k in range(20)
    ]
    frames = list(open_recording(write(tmp_path / "a.bag", [*wrong, *messages])))
    assert frames[0].observation.pose == pytest.approx([2.0, 0.5, math.pi / 2.0])
    # what the wheels measure is better than a difference
    assert frames[0].observation.twist == pytest.approx([0.7, 0.0, 0.1])


def test_without_any_of_it_no_frame_has_a_pose(tmp_path):
    recording = open_recording(write(tmp_path / "a.bag", [("/s", 1.0, ROS1.scan(1.0, [1.0]))]))
    (frame,) = recording
    assert frame.observation.pose.tolist() == frame.observation.twist.tolist() == [0, 0, 0]
    assert not frame.posed
    assert any("no pose of" in text for text in recording.warnings)


def test_a_sensor_in_the_map_is_its_own_robot(tmp_path):
    held = ROS1.transforms((1.0, "odom", "lidar", (3.0, 4.0, 1.0), (0.1, 0.0, 0.5)))
    messages = [("/tf", 1.0, held), ("/p", 1.0, ROS1.plain_cloud(1.0, [[1, 0, 0]]))]
    (frame,) = open_recording(write(tmp_path / "a.bag", messages))
    assert frame.observation.pose == pytest.approx([3.0, 4.0, 0.5])
    expected = [0.0, 0.0, math.nan, 0.1, 0.0, 0.0]
    assert frame.observation.clouds[0].mount == pytest.approx(expected, nan_ok=True)


def test_labels_are_told_in_the_map(tmp_path):
    messages = [m for m in ride(ROS1) if m[0] != "/scan"]
    messages += [
        ("/leg_cluster_positions", 12.5, ROS1.poses(0.0, [(1.0, 0.0)])),
        ("/scan", 12.5, ROS1.scan(11.0, [1.0])),
    ]
    (frame,) = open_recording(write(tmp_path / "a.bag", messages))
    # the laser 0.3 m ahead and 0.1 m left of (2, 1), which faces y: (1.9, 1.3)
    assert frame.labels.position[0] == pytest.approx([1.9, 2.3])


def test_a_turn_takes_the_shorter_arc_at_a_constant_rate():
    places = Transforms()
    for time, yaw in ((0.0, 3.0), (1.0, -3.0)):
        # the second quaternion has the other sign
        q = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        places.add("a", "b", time, (0.0, 0.0, 0.0, *q))
    # from 3.0 to 2π − 3.0
    for share in (0.25, 0.5, 0.75):
        yaw = planar(places.at("a", "b", share))[2] % math.tau
        assert yaw == pytest.approx(3.0 + share * (math.tau - 6.0))


def test_transforms_cancel_along_any_chain(rng):
    places = Transforms()
    for parent, child in (("root", "a"), ("a", "b"), ("root", "c"), ("c", "d")):
        places.add(parent, child, -math.inf, (*rng.normal(size=3), *rng.normal(size=4)))
    there = places.at("b", "d", 0.0)
    assert there @ places.at("d", "b", 5.0) == pytest.approx(np.eye(4), abs=1e-12)
    assert places.at("b", "a", 0.0) @ places.at("a", "d", 0.0) == pytest.approx(there)
    assert places.connected("b", "d")
    assert not places.connected("b", "elsewhere")


def test_rings_second_parents_and_no_numbers_are_left_out():
    places = Transforms()
    still = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    places.add("/a", "b", 0.0, still)
    places.add("b", "c", 0.0, still)
    for parent, child in (("c", "a"), ("a", "a"), ("x", "b")):
        places.add(parent, child, 0.0, still)
    assert set(places.frames) == {"a", "b", "c"}
    for wrong in ((math.nan, *still[1:]), (*still[:6], 0.0)):
        places.add("c", "d", 0.0, wrong)
    assert not places.has_parent("d")


def test_axes_are_those_of_rep_103(rng):
    for _ in range(20):
        x = np.array([*rng.normal(size=3), *rng.uniform(-1.5, 1.5, 3)])
        turned = ROS1.turn(*x[3:])
        X = matrix((*x[:3], turned.x, turned.y, turned.z, turned.w))
        assert fixed_axes(X) == pytest.approx(x)
    # planar poses agree with the plane geometry of the project
    X = matrix((1.0, 2.0, 0.0, 0.0, 0.0, math.sin(0.4), math.cos(0.4)))
    assert (X @ [3.0, 4.0, 0.0, 1.0])[:2] == pytest.approx(transform(planar(X), [3.0, 4.0]))
