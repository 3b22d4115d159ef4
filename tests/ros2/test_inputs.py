"""Messages become one observation: frames, times, and what is missing."""

import math

import numpy as np
import pytest

from cohelm.geometry import compose
from cohelm.messages import RiderCommand
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.cdr import PEOPLE, types_of
from cohelm.ros2.findings import check_inputs, missing_inputs
from cohelm.ros2.inputs import MAX_READINGS, NEVER, Inputs
from cohelm.ros2.parameters import FrameNames, Ros2Parameters, StickParameters
from tests.recordings.bags import ROS2
from tests.ros2.messages import LASER_TF, odometry, scan, transforms


class Clock:
    """Time that a test sets, s; stamps are on it."""

    def __init__(self):
        self.time = 5.0

    def now(self):
        return self.time

    def of(self, stamp):
        return stamp


@pytest.fixture
def clock():
    return Clock()


@pytest.fixture
def inputs(clock):
    return Inputs(Ros2Parameters(), clock)


def feed(inputs, time=5.0, map_to_odom=(10.0, 0.0, 0.0, 0.0, 0.0, math.pi / 2.0)):
    inputs.take_transforms(transforms(0.0, ("base_link", "laser", LASER_TF)), static=True)
    inputs.take_transforms(transforms(time, ("map", "odom", map_to_odom)), static=False)
    inputs.take_odometry(odometry(time))
    inputs.take_scan("/scan", scan(time))


def test_the_pose_is_the_localiser_s_after_the_odometry_s(inputs):
    feed(inputs)
    seen = inputs.observation()
    # (1, 2) turned by 90° is (−2, 1); ten metres ahead of it (8, 1); the angles add.
    np.testing.assert_allclose(seen.pose, [8.0, 1.0, 0.5 + math.pi / 2.0])
    np.testing.assert_allclose(seen.twist, [0.4, 0.0, 0.2])
    assert seen.pose_time == seen.twist_time == seen.time == 5.0


def test_a_scan_is_given_once_with_the_mount_of_the_transforms(inputs):
    feed(inputs)
    (sweep,) = inputs.observation().scans
    np.testing.assert_allclose(sweep.mount, LASER_TF[[0, 1, 5]])
    assert inputs.observation().scans == ()


def test_a_late_navigator_gets_the_newest_scans_only(inputs, clock):
    feed(inputs)
    for k in range(2 * MAX_READINGS):
        inputs.take_scan("/scan", scan(5.0 + 0.1 * k))
    times = [each.time for each in inputs.observation().scans]
    assert times == pytest.approx([5.0 + 0.1 * k for k in range(MAX_READINGS, 2 * MAX_READINGS)])


def test_a_localiser_that_falls_silent_makes_the_pose_old(inputs, clock):
    feed(inputs)
    clock.time = 5.25
    inputs.take_odometry(odometry(5.25))
    assert inputs.observation().pose_time == 5.25
    clock.time = 5.4  # more than 0.25 s after the localiser's last transform
    inputs.take_odometry(odometry(5.4))
    assert inputs.observation().pose_time == NEVER


def test_a_localiser_that_stamps_into_the_future_is_not_from_the_future(inputs, clock):
    feed(inputs)
    inputs.take_transforms(transforms(6.0, ("map", "odom", np.zeros(6))), static=False)
    assert inputs.observation().pose_time == 5.0


def test_without_a_map_frame_the_odometry_is_the_pose(clock):
    inputs = Inputs(Ros2Parameters(frames=FrameNames(map=None)), clock)
    inputs.take_odometry(odometry(5.0))
    np.testing.assert_allclose(inputs.observation().pose, [1.0, 2.0, 0.5])


def test_an_odometry_of_another_frame_is_moved_to_the_base(inputs, clock):
    # The odometry's frame lies 0.5 m ahead of the base, so that the base is at −0.5 m in it.
    inputs.take_transforms(
        transforms(0.0, ("base_link", "wheels", [0.5, 0, 0, 0, 0, 0])), static=True
    )
    inputs.take_transforms(transforms(5.0, ("map", "odom", np.zeros(6))), static=False)
    inputs.take_odometry(odometry(5.0, twist=(0.4, 0.0, 0.2), frames=("odom", "wheels")))
    seen = inputs.observation()
    np.testing.assert_allclose(seen.pose, compose([1.0, 2.0, 0.5], [-0.5, 0.0, 0.0]))
    # v at −0.5 m: v_y = ω · (−0.5) = −0.1 m/s.
    np.testing.assert_allclose(seen.twist, [0.4, -0.1, 0.2])


def test_what_is_missing_is_named(inputs):
    assert missing_inputs(Ros2Parameters(), inputs) == [
        "no message on /scan",
        "no message on /odom",
        "no transform from 'map' to 'odom'",
    ]
    inputs.take_scan("/scan", scan(5.0, frame="lidar"))
    assert "/scan: no transform from 'base_link' to 'lidar'" in missing_inputs(
        Ros2Parameters(), inputs
    )
    feed(inputs)
    assert missing_inputs(Ros2Parameters(), inputs) == []


def test_a_tilted_planar_scanner_is_refused(inputs):
    tilted = [0.3, 0.0, 0.4, 0.0, math.radians(30.0), 0.0]
    inputs.take_transforms(transforms(0.0, ("base_link", "laser", tilted)), static=True)
    inputs.take_scan("/scan", scan(5.0))
    assert "tilted" in inputs.topics["/scan"].problem
    assert inputs.observation().scans == ()


def test_an_odometry_that_is_not_a_number_is_not_used(inputs):
    feed(inputs)
    inputs.take_odometry(odometry(5.1, twist=(math.nan, 0.0, 0.0)))
    assert inputs.observation().twist_time == 5.0
    assert "not finite" in inputs.topics["/odom"].problem


def test_rate_and_delay_are_measured(inputs, clock):
    feed(inputs)
    for k in range(1, 11):
        clock.time = 5.0 + 0.1 * k
        inputs.take_scan("/scan", scan(clock.time - 0.03))
    found = inputs.topics["/scan"]
    assert found.rate == pytest.approx(10.0)
    assert found.delay == pytest.approx(0.03)


def test_a_stick_without_a_dead_man_button_is_a_device_of_the_page(clock):
    inputs = Inputs(Ros2Parameters(stick=StickParameters()), clock)
    assert inputs.observation().rider.heartbeat == NEVER  # declared, and not here: it is lost
    inputs.take_stick(
        ros.joy("", RiderCommand(heartbeat=0.0, deflection=np.array([-0.2, 0.7])))
    )  # left is axis 0
    rider = inputs.observation().rider
    assert rider.heartbeat == 5.0
    np.testing.assert_allclose(rider.deflection, [0.7, -0.2], atol=1e-6)
    with_button = Inputs(Ros2Parameters(stick=StickParameters(dead_man=4)), clock)
    assert with_button.observation().rider is None


WITH_PEOPLE = Ros2Parameters(people="/people")


def people_message(time, frame="map", place=(2.0, 3.0), names=("ana",), velocity=(1.0, 0.0)):
    point = ros.of("geometry_msgs/msg/Point")
    person = types_of("humble").types["people_msgs/msg/Person"]
    rows = [
        person(name=each, position=point(*place, 0.9), velocity=point(*velocity, 0.0),
               reliability=0.8, tagnames=[], tags=[])
        for each in names
    ]  # fmt: skip
    header = ros.header(time, frame)
    return types_of("humble").types[PEOPLE](header=header, people=rows)


def test_people_of_another_node_are_in_the_map(clock):
    inputs = Inputs(WITH_PEOPLE, clock)
    feed(inputs)  # odom lies 10 m ahead of the map's origin, turned by 90°
    inputs.take_people(people_message(5.0, "odom", names=("ana", "ben")))
    people = inputs.observation().people
    np.testing.assert_allclose(people.mean[0], [7.0, 2.0, 0.0, 1.0], atol=1e-9)
    assert (people.time, people.source, people.id.tolist()) == (5.0, "ros2", [0, 1])
    assert people.confidence.tolist() == [0.8, 0.8]
    inputs.take_people(people_message(5.1, names=("ben",)))
    assert inputs.observation().people.id.tolist() == [1]  # a name keeps its number


def test_old_people_count_as_a_lost_sensor(clock):
    inputs = Inputs(WITH_PEOPLE, clock)
    feed(inputs)
    assert inputs.observation().scans == ()  # nobody has told yet who is there
    inputs.take_people(people_message(5.0))
    clock.time = 5.6
    inputs.take_scan("/scan", scan(5.6))
    seen = inputs.observation()
    assert (seen.people, seen.scans) == (None, ())


def test_beside_people_an_old_scanner_is_watched_again(clock):
    inputs = Inputs(WITH_PEOPLE, clock)
    feed(inputs)
    clock.time = 5.6
    inputs.take_people(people_message(5.6))
    seen = inputs.observation()
    assert seen.people is None
    inputs.take_scan("/scan", scan(5.6))
    assert len(inputs.observation().people) == 1


@pytest.mark.parametrize(
    ("message", "problem"),
    [
        (people_message(5.0, "camera"), "no transform"),
        (people_message(5.0, place=(math.nan, 0.0)), "not finite"),
        (people_message(5.0, names=[str(k) for k in range(501)]), "at most 500"),
    ],
)
def test_people_that_cannot_be_used_are_refused(clock, message, problem):
    inputs = Inputs(WITH_PEOPLE, clock)
    feed(inputs)
    inputs.take_people(message)
    assert problem in inputs.topics["/people"].problem
    assert inputs.observation().people is None


@pytest.mark.parametrize("row", [0, 2, 24, 48])
def test_a_live_cloud_needs_no_right_row_step(clock, row):
    inputs = Inputs(Ros2Parameters(scans=(), clouds=("/points",)), clock)
    feed(inputs)
    points = np.arange(1.0, 13.0, dtype="<f4").reshape(4, 3)
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)]
    about = {"height": 2, "width": 2, "point_step": 12, "row_step": row}
    cloud = ROS2.cloud(5.0, points.tobytes(), fields, "laser", **about)
    inputs.take_cloud("/points", cloud)
    (seen,) = inputs.observation().clouds
    np.testing.assert_array_equal(seen.points, points)
    inputs.take_cloud("/points", ROS2.cloud(5.0, bytes(47), fields, "laser", **about))
    needed = max(48, row + 24)
    assert f"row_step {row}, needs {needed} bytes and has 47" in inputs.topics["/points"].problem


def test_every_declared_input_is_needed(inputs):
    declared = Ros2Parameters(people="/people", stick=StickParameters(), clouds=("/points",))
    missing = missing_inputs(declared, inputs)
    for topic in ("/scan", "/points", "/odom", "/joy", "/people"):
        assert f"no message on {topic}" in missing


@pytest.mark.parametrize(
    ("named", "declared", "problem"),
    [
        (("odom", "base_link"), {}, ""),
        (("odom", ""), {}, ""),
        (("", "base_link"), {}, ""),
        (("", ""), {}, ""),
        (("/odom", "/base_link"), {}, ""),
        (("odom", "base_link"), {"odom": "/odom", "base": "/base_link"}, ""),
        (("", ""), {"odom": "/odom", "base": "/base_link"}, ""),
        (("odom", "base_footprint"), {}, "from 'base_footprint' to 'base_link'"),
        (("chair/odom", "base_link"), {}, "from 'odom' to 'chair/odom'"),
        (("chair/odom", "chair/base_link"), {}, "from 'odom' to 'chair/odom'"),
        (("odom", "/chair/base_link"), {}, "from 'chair/base_link' to 'base_link'"),
    ],
)
def test_check_and_drive_agree_on_the_odometry_s_frames(clock, named, declared, problem):
    parameters = Ros2Parameters(frames=FrameNames(**declared))
    inputs = Inputs(parameters, clock)
    feed(inputs)
    inputs.take_odometry(odometry(5.0, frames=named))
    found = {each.what: each for each in check_inputs(parameters, inputs, {})}["odometry frame"]
    refusals = missing_inputs(parameters, inputs)
    assert found.fine == (refusals == []) == (problem == "")
    assert problem in found.text
    assert problem in " ".join(refusals)
    seen = inputs.observation()
    assert (seen.pose_time == seen.twist_time == 5.0) == (problem == "")


def test_the_odometry_may_stand_in_another_frame_that_is_connected(inputs):
    feed(inputs, map_to_odom=(0.0,) * 6)
    wheels = transforms(5.0, ("odom", "wheels", (3.0, 0.0, 0.0, 0.0, 0.0, 0.0)))
    inputs.take_transforms(wheels, static=True)
    inputs.take_odometry(odometry(5.0, frames=("wheels", "base_link")))
    np.testing.assert_allclose(inputs.observation().pose, [4.0, 2.0, 0.5])
