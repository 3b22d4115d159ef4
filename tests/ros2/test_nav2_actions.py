"""FollowPath drives along a path, ComputePathToPose plans one; goals as Nav2's behaviour trees."""

import time
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from cohelm.live import Drive, DriveSetup
from cohelm.live.messages import (
    ChairState,
    Destination,
    Heartbeat,
    Notice,
    Rejected,
    ResumeCommand,
    RouteUpdate,
    SetGoal,
    SetMode,
    TakeControl,
)
from cohelm.messages import Mode
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2 import nav2_actions
from cohelm.ros2.nav2_actions import (
    MAX_POINTS,
    ComputePath,
    DriveClient,
    FollowPath,
    planner_of,
    thinned,
    with_headings,
)
from cohelm.scenarios import load_scenario

CODES = SimpleNamespace(
    UNKNOWN=100, TF_ERROR=102, INVALID_PATH=103, NO_VALID_CONTROL=106, GOAL_OCCUPIED=207
)
LINE = [(3.0, 5.0), (5.0, 5.2), (7.0, 5.0)]


class Page:
    """A drive that keeps what it receives."""

    def __init__(self):
        self.received, self.send = [], None

    def listen(self, callback):
        self.send = callback

    def receive(self, client, message):
        self.received.append(message)


def path_goal(points, frame="map"):
    poses = np.column_stack([np.array(points).reshape(-1, 2), np.zeros(len(points))])
    return SimpleNamespace(path=ros.path(1.0, frame, poses))


def state(goal=None, remaining=None):
    where = None if goal is None else Destination(name="", x=goal[0], y=goal[1])
    return ChairState(
        seq=1, time=1.0, pose=(1.0, 2.0, 0.0), speed=0.4, turn_rate=0.0, command=(0.4, 0.0),
        mode=Mode.AUTONOMOUS, pace="normal", rider_authority=0.0, goal=where, remaining=remaining,
    )  # fmt: skip


@pytest.fixture
def page():
    return Page()


@pytest.fixture
def client(page):
    return DriveClient(page, "ros2")


def test_a_path_is_a_destination_and_a_line_to_follow(page, client):
    job = FollowPath(path_goal(LINE), client, "map", CODES)
    (goal,) = page.received
    assert (type(goal), goal.point) == (SetGoal, (7.0, 5.0))
    (wish,) = goal.wishes
    assert wish.kind == "stroke"
    assert (wish.points[0], wish.points[-1]) == (LINE[0], LINE[-1])
    assert job.step() is None
    page.send(state(goal=(7.0, 5.0), remaining=3.5), None)
    assert job.step() is None
    assert job.feedback() == {"distance_to_goal": 3.5, "speed": 0.4}
    page.send(Notice(code="arrived", text=""), None)
    assert job.step().succeeded


def test_another_page_s_arrival_or_rejection_is_not_ours(page, client):
    page.send(Notice(code="arrived", text=""), None)
    job = FollowPath(path_goal(LINE), client, "map", CODES)
    page.send(Rejected(id=page.received[0].id, code="not_driver", text="theirs"), "a")
    assert job.step() is None
    page.send(Rejected(id=page.received[0].id, code="not_driver", text="Another drives."), "ros2")
    assert job.step().result == {"error_code": 106, "error_msg": "Another drives."}


def test_a_destination_that_the_rider_changes_ends_the_work(page, client):
    job = FollowPath(path_goal(LINE), client, "map", CODES)
    page.send(state(goal=(7.0, 5.0)), None)
    assert job.step() is None
    page.send(state(goal=(1.0, 1.0)), None)
    assert job.step().result["error_code"] == CODES.UNKNOWN


def test_a_way_that_stays_blocked_ends_the_work(page, client, monkeypatch):
    job = FollowPath(path_goal(LINE), client, "map", CODES)
    page.send(RouteUpdate(version=1, error="no route"), None)
    assert job.step() is None
    page.send(RouteUpdate(version=2), None)
    assert job.step() is None
    page.send(RouteUpdate(version=3, error="no route"), None)
    assert job.step() is None
    monkeypatch.setattr(nav2_actions, "NO_ROUTE_LIMIT", 0.0)
    time.sleep(0.01)
    assert job.step().result == {"error_code": 103, "error_msg": "no route"}


@pytest.mark.parametrize(
    ("goal", "code"),
    [
        (path_goal(LINE, "odom"), "TF_ERROR"),
        (path_goal([]), "INVALID_PATH"),
        (path_goal([(np.nan, 1.0)]), "INVALID_PATH"),
    ],
)
def test_a_path_that_cannot_be_driven_is_refused(page, client, goal, code):
    outcome = FollowPath(goal, client, "map", CODES).step()
    assert outcome.result["error_code"] == getattr(CODES, code)
    assert page.received == []


def test_cancelling_cancels_the_trip(page, client):
    job = FollowPath(path_goal(LINE), client, "map", CODES)
    job.cancel()
    goal = page.received[-1]
    assert (goal.point, goal.place, goal.wishes) == (None, None, ())


def test_a_line_keeps_its_ends_and_few_points():
    angle = np.linspace(0.0, 20.0, 5000)
    spiral = np.column_stack([angle * np.cos(angle), angle * np.sin(angle)])
    line = thinned(spiral)
    assert len(line) <= MAX_POINTS
    np.testing.assert_allclose(line[[0, -1]], spiral[[0, -1]])
    assert len(thinned(np.zeros((3, 2)))) == 1


def test_headings_point_along_the_line():
    poses = with_headings(np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]))
    np.testing.assert_allclose(poses[:, 2], [0.0, np.pi / 2, np.pi / 2])


def pose_goal(goal, start=None, frame="map"):
    posed = lambda point: ros.posed(1.0, frame, np.array([*point, 0.0]))  # noqa: E731  # a short helper
    return SimpleNamespace(
        goal=posed(goal), start=posed(start or (0, 0)), use_start=start is not None
    )


def computed(goal, here=(2.0, 5.0), plan=None):
    plan = plan or planner_of(load_scenario("empty"))
    here = None if here is None else np.array(here)
    return ComputePath(goal, plan, here, "map", CODES, lambda each: each).step()


def test_a_path_is_planned_from_the_chair_or_from_the_given_start():
    for start, here in ((None, (2.0, 5.0)), ((2.0, 5.0), None)):
        outcome = computed(pose_goal((9.0, 5.0), start), here)
        poses = outcome.result["path"].poses
        ends = [(each.pose.position.x, each.pose.position.y) for each in (poses[0], poses[-1])]
        np.testing.assert_allclose(ends, [(2.0, 5.0), (9.0, 5.0)], atol=0.05)
        assert outcome.result["path"].header.frame_id == "map"
        assert outcome.succeeded


@pytest.mark.parametrize(
    ("goal", "here", "code"),
    [
        (pose_goal((9.0, 5.0), frame="odom"), (2.0, 5.0), "TF_ERROR"),
        (pose_goal((9.0, 5.0)), None, "TF_ERROR"),
        (pose_goal((np.inf, 5.0)), (2.0, 5.0), "UNKNOWN"),
        (pose_goal((0.05, 0.05)), (2.0, 5.0), "GOAL_OCCUPIED"),
    ],
)
def test_a_pose_without_a_path_has_nav2_s_code(goal, here, code):
    assert computed(goal, here).result["error_code"] == getattr(CODES, code)


@pytest.mark.slow
def test_a_followed_path_is_driven_while_the_rider_holds_the_button(tmp_path):
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path))
    client = DriveClient(drive, "ros2")
    drive.start()
    try:
        drive.connect("ros2", "driver")
        drive.receive("ros2", TakeControl())
        drive.receive("ros2", SetMode(mode=Mode.AUTONOMOUS))
        job, outcome, tracked, seq, end = None, None, [], 0, time.monotonic() + 240.0
        while outcome is None and time.monotonic() < end:
            seq += 1
            now = time.monotonic()
            drive.receive("ros2", Heartbeat(seq=seq, sent=1000.0 * now, device="joystick"), now)
            if client.state is not None and client.state.link == "confirm":
                drive.receive("ros2", ResumeCommand())
            if drive.health.ready and client.state is not None:
                here = np.array(client.state.pose[:2])
                if job is None:
                    begin, ahead = here, here + np.array([4.0, 0.0])
                    bend = np.array([begin, begin + np.array([2.0, 1.5]), ahead])
                    job = FollowPath(path_goal(bend), client, "map", CODES)
                tracked.append(here)
                outcome = job.step()
            time.sleep(0.1)
        assert outcome is not None
        assert outcome.succeeded, outcome.result
        assert np.hypot(*(tracked[-1] - ahead)) < 0.4
        # Half of the bend, as a drawn line pulls the route; straight on would be 0.
        assert max(point[1] - begin[1] for point in tracked) > 0.75
    finally:
        drive.close()
