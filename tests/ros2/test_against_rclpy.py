"""cohelm's DDS without ROS against a real rclpy over Fast DDS, in processes of their own."""

import os
import queue
import subprocess
import sys
import time

import numpy as np
import pytest

pytest.importorskip("rclpy", reason="needs rclpy, see CONTRIBUTING.md")

from cohelm.errors import PlatformError
from cohelm.evaluation import Outcome, run
from cohelm.maps import OccupancyGrid
from cohelm.messages import PointCloud, RiderCommand
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.cdr import encode
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.parameters import DdsParameters
from cohelm.ros2.rclpy_node import RclpyNode, rclpy_class
from cohelm.ros2.transport import Reliability, make_node
from cohelm.scenarios import load_scenario
from tests.ros2.lockstep import ride
from tests.ros2.loopback import LOOPBACK
from tests.ros2.messages import odometry, scan

pytestmark = [
    pytest.mark.ros,
    pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning"),  # lark, below rclpy
]
RELIABLE = Reliability(reliable=True, depth=100)
IN_FLIGHT = 20
"""Messages on the way at once."""
START = 60.0
"""Maximum time until both sides know each other, s."""


def cloud(rng):
    points = rng.normal(size=(5300, 3)).astype(np.float32)  # 64 kB
    return ros.cloud("lidar", PointCloud(time=1.5, mount=np.zeros(6), points=points, range_max=9.0))


def grid(rng):
    data = rng.choice(np.array([-1, 0, 100], dtype=np.int8), size=(100, 80))
    return ros.grid(
        1.5, "map", OccupancyGrid(data=data, resolution=0.05, X_MG=np.array([1.0, 2.0, 0.3]))
    )


def clock(rng):
    return ros.of("rosgraph_msgs/msg/Clock")(clock=ros.stamp(float(rng.uniform(0.0, 1e9))))


MADE = {
    "clock": clock,
    "float64": lambda rng: ros.number(rng.normal()),
    "joy": lambda rng: ros.joy("", RiderCommand(heartbeat=2.5, deflection=rng.uniform(-1, 1, 2))),
    "laserscan": lambda rng: scan(1.5, ranges=rng.uniform(0.1, 9.0, 720)),
    "occupancygrid": grid,
    "odometry": lambda rng: odometry(1.5, rng.normal(size=3), rng.normal(size=3)),
    "path": lambda rng: ros.path(1.5, "map", rng.normal(size=(30, 3))),
    "pointcloud2": cloud,
    "posestamped": lambda rng: ros.posed(1.5, "map", rng.normal(size=3)),
    "twist": lambda rng: ros.twist(rng.normal(size=3)),
    "twiststamped": lambda rng: ros.twisted(1.5, "base_link", rng.normal(size=3)),
}
"""A random message of each type, by the topic of the echo."""


@pytest.fixture(scope="module", params=["dds", "rclpy"])
def connection(request):
    """A node with a topic pair of each type, connected with an echo in another process."""
    environment = {**os.environ, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    process = subprocess.Popen([sys.executable, "-m", "tests.ros2.echo_node"], env=environment)
    parameters = LOOPBACK.model_copy(update={"transport": request.param})
    node, send, back = make_node(parameters, "cohelm"), {}, {}
    for name, make in MADE.items():
        kind = make(np.random.default_rng(0)).__msgtype__
        back[name] = queue.SimpleQueue()
        node.subscribe(f"/echo/{name}", kind, RELIABLE, back[name].put)
        send[name] = node.publisher(f"/{name}", kind, RELIABLE)
    node.start()
    try:
        end = time.monotonic() + START
        while time.monotonic() < end and not all(node.matched(f"/echo/{name}") for name in MADE):
            time.sleep(0.1)
        time.sleep(1.0)  # and the echo's subscriptions
        yield send, back
    finally:
        node.close()
        process.kill()
        process.wait()


def round_trips(connection, name, count):
    """Messages sent, and those that came back, in their order."""
    send, back, rng = connection[0][name], connection[1][name], np.random.default_rng(1)
    sent, received = [], []
    for _ in range(count):
        sent.append(MADE[name](rng))
        send(sent[-1])
        while len(sent) - len(received) > IN_FLIGHT:
            received.append(back.get(timeout=20.0))
    while len(received) < count:
        received.append(back.get(timeout=20.0))
    return sent, received


@pytest.mark.parametrize("name", MADE)
def test_messages_come_back_bit_for_bit(connection, name):
    sent, received = round_trips(connection, name, 30)
    assert [encode(each) for each in received] == [encode(each) for each in sent]


@pytest.mark.slow
@pytest.mark.parametrize("name", MADE)
def test_of_a_thousand_messages_none_is_lost_or_changed(connection, name):
    sent, received = round_trips(connection, name, 1000)
    assert [encode(each) for each in received] == [encode(each) for each in sent]


def test_a_message_type_that_ros_does_not_have_is_named():
    with pytest.raises(PlatformError, match="tf3-msgs"):
        rclpy_class("tf3_msgs/msg/TFMessage")


def test_rclpy_sees_what_others_publish_and_who_listens(connection):
    node = RclpyNode("seeing")
    node.publisher("/laserscan", "sensor_msgs/msg/LaserScan", RELIABLE)
    node.start()
    try:
        end = time.monotonic() + START
        while time.monotonic() < end and not (
            "/echo/laserscan" in node.published() and node.subscribers("/laserscan")
        ):
            time.sleep(0.2)
        found = node.published()["/echo/laserscan"]
        assert found == "sensor_msgs/msg/LaserScan, reliable, volatile"
        assert node.subscribers("/laserscan") == 1
        assert node.matched("/echo/laserscan") == 1
        assert node.subscribers("/nothing") == node.matched("/nothing") == 0
    finally:
        node.close()
        node.close()


def test_ros_sees_the_node_and_its_topics():
    rclpy = pytest.importorskip("rclpy")
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    context = rclpy.Context()
    rclpy.init(context=context)
    node = DdsNode(DdsParameters(interface="lo"), "cohelm_seen")
    node.subscribe("/scan", "sensor_msgs/msg/LaserScan", RELIABLE, lambda _: None)
    node.publisher("/cmd_vel", "geometry_msgs/msg/Twist", RELIABLE)
    node.start()
    observer = rclpy.create_node("observer", context=context)
    try:
        end = time.monotonic() + START
        while time.monotonic() < end and "cohelm_seen" not in observer.get_node_names():
            time.sleep(0.2)
        assert "cohelm_seen" in observer.get_node_names()
        by_node = observer.get_publisher_names_and_types_by_node("cohelm_seen", "/")
        assert ("/cmd_vel", ["geometry_msgs/msg/Twist"]) in by_node
        topics = dict(observer.get_topic_names_and_types())
        assert topics["/scan"] == ["sensor_msgs/msg/LaserScan"]
    finally:
        node.close()
        observer.destroy_node()
        rclpy.shutdown(context=context)


@pytest.mark.slow
def test_a_ride_through_topics_is_that_in_process():
    here = run(load_scenario("distracted"), 0)
    outcome, end, lost, _ = ride("distracted", 0)
    assert (outcome, lost) == (Outcome.REACHED, 0)
    assert here.outcome is Outcome.REACHED
    # Ranges have single precision on topics; the project's bound for a ride's time is 5 %.
    assert end == pytest.approx(float(here.time[-1]), rel=0.05)
