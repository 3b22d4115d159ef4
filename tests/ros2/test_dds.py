"""DDS nodes of one process."""

import queue
import time

import numpy as np
import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from cohelm.recordings.bags.ros_messages import TRANSFORMS
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.transport import RELIABLE, STATIC
from tests.ros2.loopback import LOOPBACK

WATCH = 1.0  # s


@pytest.mark.parametrize("subscribes", [False, True])
def test_a_node_that_waits_needs_no_processor_time(subscribes):
    node = DdsNode(LOOPBACK.dds.model_copy(update={"domain": 75}), "idle")
    node.publisher("/cmd_vel", "geometry_msgs/msg/Twist", RELIABLE)
    if subscribes:
        node.subscribe("/scan", "sensor_msgs/msg/LaserScan", RELIABLE, lambda _: None)
    node.start()
    try:
        time.sleep(0.5)
        before = time.process_time()
        time.sleep(WATCH)
        assert time.process_time() - before < 0.05 * WATCH
    finally:
        node.close()


def test_a_late_subscriber_gets_all_static_transforms_of_a_publisher():
    dds, got = LOOPBACK.dds.model_copy(update={"domain": 75}), queue.SimpleQueue()
    first, second = DdsNode(dds, "first"), DdsNode(dds, "second")
    publish = first.publisher("/tf_static", TRANSFORMS, STATIC)
    first.start()
    frames = ["laser", "lidar", "camera"]
    for frame in frames:
        publish(ros.transform(1.0, ("base_link", frame), np.zeros(6)))
    try:
        second.subscribe("/tf_static", TRANSFORMS, STATIC, got.put)
        second.start()
        messages = [got.get(timeout=20.0) for _ in frames]
        assert [message.transforms[0].child_frame_id for message in messages] == frames
    finally:
        first.close()
        second.close()
