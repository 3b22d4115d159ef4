"""A simulated chair behind ROS 2 topics, without ROS: something to try `cohelm ros2` with.

    python examples/ros2_robot.py hospital --people 4        # needs cohelm[ros2]

It publishes /scan, /odom, /tf, /tf_static and /map on loopback, and follows /cmd_vel as a base
does: without a command for 0.25 s it stands. In another terminal:

    cohelm ros2 robot.yaml --check       # "Without a robot at hand" in docs/your-robot.md

Each command that arrives is printed as JSON: its stamp, its arrival, its speed.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from typing import Any

import numpy as np

from cohelm.messages import Decision, PointCloud
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.parameters import DdsParameters
from cohelm.ros2.transport import LATCHED, RELIABLE, SENSOR, STATIC
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World

STEP = 0.05  # s
TIMEOUT = 0.25
"""Age of the last command from which the base stands, s."""
CLOUD_POINTS = 5300  # 64 kB


class Robot:
    """Base, scanner and localiser of one simulated chair.

    Args:
        scenario: Name or file.
        people: Number of people; None: those of the scenario.
        seed: Random seed.
        domain: ROS domain; None: ROS_DOMAIN_ID.
    """

    def __init__(self, scenario: str, people: int | None, seed: int, domain: int | None) -> None:
        given = load_scenario(scenario)
        if people is not None:
            crowd = given.people.model_copy(update={"count": people})
            given = given.model_copy(update={"people": crowd})
        self._setup = build_scenario(given, seed)
        self._world = World(self._setup.world, seed)
        self._twist, self._commanded_at = np.zeros(3), 0.0
        self._node = node = DdsNode(DdsParameters(interface="lo", domain=domain), "robot")
        self._scan = node.publisher("/scan", "sensor_msgs/msg/LaserScan", SENSOR)
        self._odometry = node.publisher("/odom", "nav_msgs/msg/Odometry", SENSOR)
        self._points = node.publisher("/points", "sensor_msgs/msg/PointCloud2", SENSOR)
        self._tf = node.publisher("/tf", "tf2_msgs/msg/TFMessage", RELIABLE)
        self._static = node.publisher("/tf_static", "tf2_msgs/msg/TFMessage", STATIC)
        self._map = node.publisher("/map", "nav_msgs/msg/OccupancyGrid", LATCHED)
        node.subscribe("/cmd_vel", "geometry_msgs/msg/TwistStamped", RELIABLE, self._take)
        node.start()

    def serve(self, *, cloud: bool) -> None:
        """Move and publish until interrupted."""
        now = time.time()
        self._map(ros.grid(now, "map", self._setup.grid))
        for frame in ("laser", "lidar"):
            mount = np.array([0.0, 0.0, 0.4, 0.0, 0.0, 0.0])
            self._static(ros.transform(now, ("base_link", frame), mount))
        rng, due, step = np.random.default_rng(0), time.monotonic(), 0
        while True:
            if cloud and step % 2 == 0:
                self._points(_ceiling(rng))
            self._publish()
            stale = time.time() - self._commanded_at > TIMEOUT
            self._world.advance(Decision(twist=np.zeros(3) if stale else self._twist.copy()))
            step, due = step + 1, due + STEP
            time.sleep(max(due - time.monotonic(), 0.0))

    def _publish(self) -> None:
        seen, now = self._world.observe(), time.time()
        pose = np.array([*seen.pose[:2], 0.0, 0.0, 0.0, seen.pose[2]])
        self._tf(ros.transform(now, ("odom", "base_link"), pose))
        self._tf(ros.transform(now, ("map", "odom"), np.zeros(6)))
        self._odometry(ros.odometry(now, ("odom", "base_link"), seen.pose, seen.twist))
        for scan in seen.scans:
            self._scan(_stamped(ros.scan("laser", scan), "laser"))

    def _take(self, message: Any) -> None:
        speed, stamp = message.twist, message.header.stamp
        stamped_at, now = stamp.sec + 1e-9 * stamp.nanosec, time.time()
        if now - stamped_at > TIMEOUT:  # held back by a network that was cut
            return
        self._twist[:] = speed.linear.x, speed.linear.y, speed.angular.z
        self._commanded_at = now
        line = stamped_at, now, float(speed.linear.x)
        sys.stdout.write(json.dumps(line) + "\n")
        sys.stdout.flush()


def _ceiling(rng: np.random.Generator) -> Any:
    """Return a PointCloud2 of 64 kB that is in nobody's way."""
    points = rng.uniform(-8.0, 8.0, (CLOUD_POINTS, 3)).astype(np.float32)
    points[:, 2] = rng.uniform(2.5, 3.0, CLOUD_POINTS)
    cloud = PointCloud(time=0.0, mount=np.zeros(6), points=points, range_max=10.0)
    return _stamped(ros.cloud("lidar", cloud), "lidar")


def _stamped(message: Any, frame: str) -> Any:
    message.header = ros.header(time.time(), frame)
    return message


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("scenario")
    parser.add_argument("--people", type=int)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--domain", type=int)
    parser.add_argument("--cloud", action="store_true", help="add /points of 64 kB, 10 Hz")
    given = parser.parse_args()
    Robot(given.scenario, given.people, given.seed, given.domain).serve(cloud=given.cloud)


if __name__ == "__main__":
    main()
