"""Nav2's own action types over the wire, from a real client to the servers of the ride."""

import os
import threading
import time

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy, see CONTRIBUTING.md")
pytest.importorskip("nav2_msgs", reason="needs nav2_msgs, see CONTRIBUTING.md")

import rclpy
from action_msgs.msg import GoalStatus
from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import ComputePathToPose, FollowPath
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor

from cohelm.live.messages import Notice
from cohelm.ros2.nav2_actions import serve_nav2
from cohelm.scenarios import load_scenario
from tests.ros2.loopback import LOOPBACK
from tests.ros2.test_nav2_actions import Page, state

pytestmark = [
    pytest.mark.ros,
    pytest.mark.slow,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark, below rclpy
]
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
TIMEOUT = 60.0


@pytest.fixture(scope="module")
def page():
    return Page()


@pytest.fixture(scope="module")
def clients(page):
    """A client of each action; the servers belong to a drive that a test plays."""
    parameters = LOOPBACK.model_copy(update={"transport": "rclpy", "actions": True})
    servers = serve_nav2(parameters, page, "ros2", load_scenario("empty"))
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("behaviour_tree", context=context)
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    made = (
        ActionClient(node, FollowPath, "/follow_path"),
        ActionClient(node, ComputePathToPose, "/compute_path_to_pose"),
    )
    ends = threading.Event()

    def spin():
        while not ends.is_set():
            executor.spin_once(timeout_sec=0.05)

    thread = threading.Thread(target=spin, daemon=True)
    thread.start()
    assert all(client.wait_for_server(TIMEOUT) for client in made)
    yield made
    ends.set()
    thread.join()
    executor.shutdown()
    node.destroy_node()
    rclpy.shutdown(context=context)
    servers.close()


def wait(future):
    end = time.monotonic() + TIMEOUT
    while not future.done():
        assert time.monotonic() < end
        time.sleep(0.01)
    return future.result()


def pose(x, y, frame="map"):
    out = PoseStamped()
    out.header.frame_id, out.pose.position.x, out.pose.position.y = frame, x, y
    return out


def follow(client, goal, feedback=None):
    return wait(client.send_goal_async(goal, feedback_callback=feedback))


def test_compute_path_to_pose_returns_a_path(clients):
    goal = ComputePathToPose.Goal(start=pose(2.0, 7.0), goal=pose(8.0, 7.0), use_start=True)
    answer = wait(follow(clients[1], goal).get_result_async())
    assert answer.status == GoalStatus.STATUS_SUCCEEDED
    points = [(each.pose.position.x, each.pose.position.y) for each in answer.result.path.poses]
    assert np.hypot(*np.diff(points, axis=0).T).sum() == pytest.approx(6.0, abs=0.1)
    assert answer.result.error_code == ComputePathToPose.Result.NONE


def test_compute_path_to_pose_names_a_blocked_goal(clients):
    goal = ComputePathToPose.Goal(start=pose(2.0, 7.0), goal=pose(-50.0, 7.0), use_start=True)
    answer = wait(follow(clients[1], goal).get_result_async())
    assert answer.status == GoalStatus.STATUS_ABORTED
    codes = ComputePathToPose.Result
    assert answer.result.error_code in {codes.GOAL_OUTSIDE_MAP, codes.GOAL_OCCUPIED}
    assert answer.result.error_msg


def test_follow_path_gives_feedback_and_ends_with_the_arrival(clients, page):
    goal, told = FollowPath.Goal(), []
    goal.path.header.frame_id = "map"
    goal.path.poses = [pose(3.0, 5.0), pose(5.0, 5.2), pose(7.0, 5.0)]
    handle = follow(clients[0], goal, lambda message: told.append(message.feedback))
    assert handle.accepted
    end = time.monotonic() + TIMEOUT
    while not told and time.monotonic() < end:
        page.send(state(goal=(7.0, 5.0), remaining=3.5), None)
        time.sleep(0.05)
    assert told[-1].distance_to_goal == pytest.approx(3.5)
    page.send(Notice(code="arrived", text="You have arrived."), None)
    answer = wait(handle.get_result_async())
    assert answer.status == GoalStatus.STATUS_SUCCEEDED


def test_follow_path_names_a_wrong_frame(clients):
    goal = FollowPath.Goal()
    goal.path.header.frame_id, goal.path.poses = "odom", [pose(3.0, 5.0, "odom")]
    answer = wait(follow(clients[0], goal).get_result_async())
    assert answer.status == GoalStatus.STATUS_ABORTED
    assert answer.result.error_code == FollowPath.Result.TF_ERROR
    assert "odom" in answer.result.error_msg


def test_a_cancelled_path_stops_the_trip(clients, page):
    goal = FollowPath.Goal()
    goal.path.header.frame_id, goal.path.poses = "map", [pose(3.0, 5.0), pose(7.0, 5.0)]
    handle = follow(clients[0], goal)
    page.received.clear()
    wait(handle.cancel_goal_async())
    assert wait(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED
    assert [message.type for message in page.received] == ["set_goal", "remove_wish"]
