"""Parts of a simulated ROS 2 robot: `python benchmarks/ros2_parts.py PART` serves as one.

base        the chair with its odometry; prints each command and, ten times a second, its motion
scanner     /scan, from the base's /raw_scan
localiser   map → odom, 20 times a second
stick       /joy with a dead-man button; reads `{"forward": 0.5, "left": 0, "confirm": false}`
cohelm      the whole live ride, driven by /joy; prints its state when it changes

Each prints JSON lines. The environment variable COHELM_INTERFACE names the network interface.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.messages import Decision, Mode, RiderCommand
from cohelm.recordings.rides import ros_messages as ros
from cohelm.ros2.dds import DdsNode
from cohelm.ros2.parameters import DdsParameters, Ros2Parameters, StickParameters
from cohelm.ros2.transport import RELIABLE, SENSOR, STATIC

SCENARIO = "empty"
STEP = 0.05  # s
BASE_TIMEOUT = 0.25
"""Age of the last command from which the base stands, s."""
WAIT = 120.0
"""Maximum time for the robot's topics, s."""
NETWORK = DdsParameters(interface=os.environ.get("COHELM_INTERFACE", "lo"))
SCAN, JOY = "sensor_msgs/msg/LaserScan", "sensor_msgs/msg/Joy"


def say(*values: Any) -> None:
    """Print a line of JSON."""
    sys.stdout.write(json.dumps(values) + "\n")
    sys.stdout.flush()


def serve_base() -> None:
    """Move as commanded, and send odometry and raw scans."""
    # Here, since the small parts shall start fast.
    from cohelm.scenarios import build_scenario, load_scenario
    from cohelm.simulation import World

    world = World(build_scenario(load_scenario(SCENARIO), 0).world, 0)
    twist, at = np.zeros(3), 0.0
    node = DdsNode(NETWORK, "base")
    odometry = node.publisher("/odom", "nav_msgs/msg/Odometry", SENSOR)
    raw = node.publisher("/raw_scan", SCAN, SENSOR)
    tf = node.publisher("/tf", "tf2_msgs/msg/TFMessage", RELIABLE)
    static = node.publisher("/tf_static", "tf2_msgs/msg/TFMessage", STATIC)

    def take(message: Any) -> None:
        nonlocal at
        stamp, speed = message.header.stamp, message.twist
        # After a cut the middleware may deliver a command that it had held back.
        if time.time() - stamp.sec - 1e-9 * stamp.nanosec > BASE_TIMEOUT:
            say("dropped")
            return
        twist[:] = speed.linear.x, speed.linear.y, speed.angular.z
        at = time.monotonic()
        say("command", at, bool(twist.any()))

    node.subscribe("/cmd_vel", "geometry_msgs/msg/TwistStamped", RELIABLE, take)
    node.start()
    static(ros.transform(time.time(), ("base_link", "laser"), np.array([0.0, 0.0, 0.4, 0, 0, 0])))
    due = time.monotonic()
    for k in range(10**9):
        seen, now = world.observe(), time.time()
        pose = np.array([*seen.pose[:2], 0.0, 0.0, 0.0, seen.pose[2]])
        tf(ros.transform(now, ("odom", "base_link"), pose))
        odometry(ros.odometry(now, ("odom", "base_link"), seen.pose, seen.twist))
        for scan in seen.scans:
            message = ros.scan("laser", scan)
            message.header = ros.header(now, "laser")
            raw(message)
        stale = time.monotonic() - at > BASE_TIMEOUT
        world.advance(Decision(twist=np.zeros(3) if stale else twist.copy()))
        if k % 2 == 0:
            say("motion", float(world.truth.pose[0]), float(world.truth.twist[0]))
        due += STEP
        time.sleep(max(due - time.monotonic(), 0.0))


def serve_scanner() -> None:
    """Pass on the raw scans."""
    node = DdsNode(NETWORK, "scanner")
    publish = node.publisher("/scan", SCAN, SENSOR)
    node.subscribe("/raw_scan", SCAN, SENSOR, publish)
    node.start()
    threading.Event().wait()


def serve_localiser() -> None:
    """Send map → odom."""
    node = DdsNode(NETWORK, "localiser")
    publish = node.publisher("/tf", "tf2_msgs/msg/TFMessage", RELIABLE)
    node.start()
    while True:
        publish(ros.transform(time.time(), ("map", "odom"), np.zeros(6)))
        time.sleep(STEP)


def serve_stick() -> None:
    """Send the position that stdin tells, with the dead-man button held."""
    node, state = DdsNode(NETWORK, "stick"), {"forward": 0.0, "left": 0.0, "confirm": False}
    publish = node.publisher("/joy", JOY, SENSOR)
    node.start()

    def listen() -> None:
        for line in sys.stdin:
            state.update(json.loads(line))

    threading.Thread(target=listen, daemon=True).start()
    for k in range(10**9):
        command = RiderCommand(heartbeat=time.time(), deflection=np.array([state["forward"], 0.0]))
        message = ros.joy("", command)
        # A hand is never quite at rest: without a change the dead-man button ends after a while.
        left = state["left"] + 1e-3 * (k % 2)
        message.axes = np.array([left, state["forward"]], dtype=np.float32)
        message.buttons = np.array([state["confirm"], False, True], dtype=np.int32)
        publish(message)
        time.sleep(STEP)


def serve_cohelm() -> None:
    """Drive."""
    from cohelm.live import Drive, DriveSetup
    from cohelm.live.messages import ChairState, SetMode, ToPage
    from cohelm.ros2.rider_node import CLIENT, RiderNode
    from cohelm.scenarios import load_scenario

    stick = StickParameters(forward_axis=1, left_axis=0, dead_man=2, confirm=0, stop=1)
    parameters = Ros2Parameters(dds=NETWORK, stick=stick, wait=WAIT)
    platform = {"use": "ros2", "dds": NETWORK.model_dump(), "wait": WAIT}
    limits = {"scan_limit": 0.25, "pose_limit": 0.25}  # as docs/your-robot.md recommends
    given = load_scenario(SCENARIO)
    update = {"platform": platform, "gate": given.gate.model_copy(update=limits)}
    with tempfile.TemporaryDirectory() as folder:
        setup = DriveSetup(scenario=given.model_copy(update=update), folder=Path(folder))
        drive, last = Drive(setup), ("", "", 0)

        def hear(message: ToPage, _: str | None) -> None:
            nonlocal last
            if isinstance(message, ChairState):
                reason = message.reason.code if message.reason else ""
                now = (message.link, reason, drive.navigator_pid or 0)
                if now != last:
                    last = now
                    say("state", *now)

        drive.listen(hear)
        drive.start()
        RiderNode(parameters, drive, setup.scenario)
        drive.receive(CLIENT, SetMode(mode=Mode.ASSISTED))
        threading.Event().wait()


PARTS = {
    "base": serve_base,
    "scanner": serve_scanner,
    "localiser": serve_localiser,
    "stick": serve_stick,
    "cohelm": serve_cohelm,
}
if __name__ == "__main__":
    PARTS[sys.argv[1]]()
