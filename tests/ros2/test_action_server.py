"""The action protocol against a real client: goal, feedback, result, cancel, preemption."""

import os
import threading
import time
from typing import ClassVar

import pytest

pytest.importorskip("rclpy", reason="needs rclpy, see CONTRIBUTING.md")
pytest.importorskip("test_msgs", reason="needs ros-test-msgs, see CONTRIBUTING.md")

import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from test_msgs.action import Fibonacci

from cohelm.errors import PlatformError
from cohelm.ros2.nav2_actions import ActionOutcome, ActionServers
from cohelm.ros2.rclpy_node import rclpy_class

pytestmark = [
    pytest.mark.ros,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark, below rclpy
]
os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
TIMEOUT = 20.0


class Counting:
    """One more number in each step; an order of 0 fails, and a negative one raises."""

    jobs: ClassVar = []

    def __init__(self, goal):
        self.order, self.sequence, self.cancelled = goal.order, [0, 1], False
        Counting.jobs.append(self)

    def step(self):
        if self.order < 0:
            raise RuntimeError("a negative order")
        if self.order == 0:
            return ActionOutcome(False, {"sequence": [], "error_msg": "left out"})
        if len(self.sequence) >= self.order:
            return ActionOutcome(True, {"sequence": self.sequence})
        self.sequence = [*self.sequence, sum(self.sequence[-2:])]
        return None

    def feedback(self):
        return {"sequence": self.sequence}

    def cancel(self):
        self.cancelled = True


@pytest.fixture(scope="module")
def client():
    servers = ActionServers("serving")
    servers.add(Fibonacci, "/counting", Counting)
    servers.start()
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("asking", context=context)
    made = ActionClient(node, Fibonacci, "/counting")
    executor = SingleThreadedExecutor(context=context)
    executor.add_node(node)
    thread = threading.Thread(target=executor.spin, daemon=True)
    thread.start()
    assert made.wait_for_server(timeout_sec=TIMEOUT)
    yield made
    servers.close()
    servers.close()
    executor.shutdown()
    thread.join(TIMEOUT)
    node.destroy_node()
    rclpy.shutdown(context=context)


def wait(future):
    end = time.monotonic() + TIMEOUT
    while not future.done() and time.monotonic() < end:
        time.sleep(0.01)
    assert future.done()
    return future.result()


def send(client, order, told=None):
    handle = wait(client.send_goal_async(Fibonacci.Goal(order=order), feedback_callback=told))
    assert handle.accepted
    return handle


def test_a_goal_has_feedback_and_a_result(client):
    told = []
    end = wait(send(client, 6, told.append).get_result_async())
    assert end.status == GoalStatus.STATUS_SUCCEEDED
    assert list(end.result.sequence) == [0, 1, 1, 2, 3, 5]
    assert list(told[0].feedback.sequence) == [0, 1, 1]
    assert [len(each.feedback.sequence) for each in told] == [3, 4, 5, 6]


@pytest.mark.parametrize("order", [0, -1])
def test_work_that_fails_is_aborted(client, order):
    end = wait(send(client, order).get_result_async())
    assert end.status == GoalStatus.STATUS_ABORTED


def test_a_client_may_cancel(client):
    handle = send(client, 1000)
    time.sleep(0.3)
    assert wait(handle.cancel_goal_async()).goals_canceling
    assert wait(handle.get_result_async()).status == GoalStatus.STATUS_CANCELED
    assert Counting.jobs[-1].cancelled


def test_a_new_goal_ends_the_old_one_without_cancelling_the_new(client):
    old = send(client, 1000)
    time.sleep(0.3)
    first, new = Counting.jobs[-1], send(client, 5)
    assert wait(old.get_result_async()).status == GoalStatus.STATUS_ABORTED
    assert wait(new.get_result_async()).status == GoalStatus.STATUS_SUCCEEDED
    assert not first.cancelled  # else it would take away the new destination


def test_a_type_that_ros_does_not_have_is_named():
    with pytest.raises(PlatformError, match="nav3-msgs"):
        rclpy_class("nav3_msgs/action/FollowPath")
