"""DDS nodes of one process."""

import time

import pytest

pytest.importorskip("cyclonedds", reason="needs the extra ros2")

from cohelm.ros2.dds import DdsNode
from cohelm.ros2.transport import RELIABLE
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
