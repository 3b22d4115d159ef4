"""A simulated robot behind ROS 2 topics: a plain rclpy node over Fast DDS, in its own process.

    python -m tests.ros2.robot_node SCENARIO SEED [key=value …]

It publishes /scan, /odom, /tf, /tf_static and /map, takes /cmd_vel as any base does (a command
older than 0.25 s is a stop), and writes one JSON object a line to stdout: what truly happened.
The world stands until the first command that moves the chair. With ``lockstep=1`` it publishes
/clock, and each step waits for the command with the stamp of that clock: rides do not depend on
the speed of the computer.
"""

import json
import math
import sys
import time

import numpy as np
import rclpy
from geometry_msgs.msg import Twist, TwistStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from cohelm.evaluation.episode.ride import GOAL_RADIUS
from cohelm.messages import Decision
from cohelm.recordings.bags.ros_messages import TRANSFORMS
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.parameters import DdsParameters
from cohelm.ros2.transport import RELIABLE, STATIC
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World, is_standing

STEP = 0.05
EPOCH = 100.0
COMMAND_TIMEOUT = 0.25
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class Robot:
    """The base driver, scanner and localiser of one simulated chair; ``faults`` alter them."""

    def __init__(self, scenario, seed, faults):
        self.lockstep, self.answered, self.scan_time, self.steps = (
            bool(faults.get("lockstep")),
            False,
            None,
            0,
        )
        self.faults, self.setup = faults, build_scenario(load_scenario(scenario), seed)
        self.world = World(self.setup.world, seed)
        self.node = node = rclpy.create_node("robot")
        self.command, self.command_at, self.started = np.zeros(3), -math.inf, False
        scan_topic = faults.get("scan_topic", "/scan")
        quality = qos_profile_sensor_data
        self.scan = node.create_publisher(LaserScan, scan_topic, quality)
        self.odom = node.create_publisher(Odometry, "/odom", 10)
        # No wheel has tf2_msgs for rclpy, so transforms come from cohelm's own node.
        self.dds = DdsNode(DdsParameters(interface="lo"), "robot_tf")
        self.tf = self.dds.publisher("/tf", TRANSFORMS, RELIABLE)
        self.static = self.dds.publisher("/tf_static", TRANSFORMS, STATIC)
        self.dds.start()
        latched = qos_profile_sensor_data if faults.get("volatile_map") else LATCHED
        self.map = node.create_publisher(OccupancyGrid, "/map", latched)
        if faults.get("twist"):
            node.create_subscription(Twist, "/cmd_vel", self.take, 10)
        else:
            node.create_subscription(TwistStamped, "/cmd_vel", self.take_stamped, 10)
        self.clock = node.create_publisher(Clock, "/clock", 10)
        self.hit = False
        self.arrived_at = None
        self.began = 0.0
        self.last_zero = None

    def now(self):
        """ROS time of what is published now, s."""
        now = EPOCH + self.world.truth.time if self.lockstep else time.time()
        return now - float(self.faults.get("old", 0.0))

    def take_stamped(self, message):
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        if self.lockstep:
            if abs(stamp - self.now()) < 0.5 * STEP:
                self.take(message.twist)
                self.answered = True
            return
        if abs(time.time() - stamp) > COMMAND_TIMEOUT:
            return
        self.take(message.twist)

    def take(self, twist):
        sign = -1.0 if self.faults.get("backwards") else 1.0
        self.command = np.array([sign * twist.linear.x, twist.linear.y, twist.angular.z])
        self.command_at = time.monotonic()
        if self.command.any() and not self.started:
            self.started, self.began = True, time.monotonic()

    def header(self, frame):
        out = Header(frame_id=frame)
        out.stamp.sec, out.stamp.nanosec = divmod(round(1e9 * self.now()), 10**9)
        return out

    def transform(self, publish, frames, pose):
        publish(ros.transform(self.now(), frames, pose))

    def announce(self):
        if not self.faults.get("no_laser_tf"):
            roll = math.radians(float(self.faults.get("roll", 0.0)))
            mount = np.array([0.0, 0.0, 0.4, roll, 0.0, 0.0])
            self.transform(self.static, ("base_link", "laser"), mount)
        grid, out = self.setup.grid, OccupancyGrid(header=self.header("map"))
        out.info.resolution = grid.resolution
        out.info.height, out.info.width = grid.shape
        out.info.origin.position.x, out.info.origin.position.y = map(float, grid.X_MG[:2])
        out.data = grid.data.ravel().tolist()
        if self.faults.get("open_map"):
            data = np.maximum(grid.data, 0)
            data[:4] = data[-4:] = data[:, :4] = data[:, -4:] = 0
            out.data = data.ravel().tolist()
        self.map.publish(out)

    def publish(self, scans):
        seen = self.world.observe()
        x, y, yaw = seen.pose.tolist()
        pose = np.array([x, y, 0.0, 0.0, 0.0, yaw])
        self.transform(self.tf, ("odom", "base_link"), pose)
        if not self.faults.get("no_map_tf"):
            self.transform(self.tf, ("map", "odom"), np.zeros(6))
        odometry = Odometry(header=self.header("odom"), child_frame_id="base_link")
        odometry.pose.pose.position.x, odometry.pose.pose.position.y = x, y
        odometry.pose.pose.orientation.z = math.sin(0.5 * yaw)
        odometry.pose.pose.orientation.w = math.cos(0.5 * yaw)
        odometry.twist.twist.linear.x = float(seen.twist[0])
        odometry.twist.twist.angular.z = float(seen.twist[2])
        self.odom.publish(odometry)
        for scan in scans:
            ranges = scan.ranges[::-1] if self.faults.get("mirrored") else scan.ranges
            out = LaserScan(header=self.header(self.faults.get("scan_frame", "laser")))
            if self.lockstep:
                out.header.stamp.sec, out.header.stamp.nanosec = divmod(
                    round(1e9 * (EPOCH + scan.time)), 10**9
                )
            out.angle_min, out.angle_increment = scan.angle_min, scan.angle_increment
            out.angle_max = scan.angle_min + (len(ranges) - 1) * scan.angle_increment
            out.range_min, out.range_max = 0.05, scan.range_max
            out.ranges = ranges.astype(np.float32).tolist()
            self.scan.publish(out)
            self.scan_time = scan.time
        if self.lockstep or self.faults.get("clock"):
            seconds, nanoseconds = divmod(round(1e9 * self.now()), 10**9)
            clock = Clock()
            clock.clock.sec, clock.clock.nanosec = seconds, nanoseconds
            self.clock.publish(clock)

    def wait_for_command(self):
        """Publish the present until its command has come, then advance."""
        self.publish(self.world.observe().scans)
        self.steps += 1
        self.answered = False
        yield self.row(self.command)
        since = time.monotonic()
        while not self.answered:
            rclpy.spin_once(self.node, timeout_sec=0.2)
            if self.steps == 1 and time.monotonic() - since > 0.2:  # nobody may have listened yet
                since = time.monotonic()
                self.publish(self.world.observe().scans)
        self.world.advance(Decision(twist=self.command))
        self.look()

    def step(self):
        stale = time.monotonic() - self.command_at > COMMAND_TIMEOUT
        twist = np.zeros(3) if stale else self.command
        if self.started:
            self.world.advance(Decision(twist=twist))
            self.publish(self.world.observe().scans)
        else:
            self.still = getattr(self, "still", -1) + 1
            self.publish(self.world.observe().scans if self.still % 2 == 0 else ())
        self.look()
        return self.row(twist)

    def look(self):
        truth = self.world.truth
        self.hit |= bool(truth.hit_moving.any()) or truth.hit_wall
        near = np.hypot(*(truth.pose[:2] - self.setup.arrival)) <= GOAL_RADIUS
        if near and bool(is_standing(truth.twist)) and self.arrived_at is None and self.started:
            self.arrived_at = truth.time

    def row(self, twist):
        truth = self.world.truth
        return {
            "steps": self.steps,
            "scan": self.scan_time,
            "time": truth.time,
            "pose": truth.pose.round(3).tolist(),
            "speed": round(float(truth.twist[0]), 4),
            "command": [float(each) for each in twist],
            "hit": self.hit,
            "arrived": self.arrived_at,
            "at": time.monotonic(),
        }


def main():
    scenario, seed = sys.argv[1], int(sys.argv[2])
    faults = dict(each.partition("=")[::2] for each in sys.argv[3:])
    rclpy.init()
    robot = Robot(scenario, seed, faults)
    robot.announce()
    write = lambda row: (sys.stdout.write(json.dumps(row) + "\n"), sys.stdout.flush())  # noqa: E731  # a short helper
    while robot.lockstep:
        for row in robot.wait_for_command():
            write(row)
    due = time.monotonic()
    while True:
        while time.monotonic() < due:
            rclpy.spin_once(robot.node, timeout_sec=max(due - time.monotonic(), 0.0))
        try:
            write(robot.step())
        except BrokenPipeError:
            return
        due += STEP


if __name__ == "__main__":
    main()
