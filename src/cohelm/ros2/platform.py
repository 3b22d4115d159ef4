"""ROS 2 robot as a platform; no ROS installation is needed."""

from __future__ import annotations

import functools
import math
import time
from dataclasses import replace

from cohelm.messages import Decision, Observation
from cohelm.platforms import Capabilities, PlatformError
from cohelm.recordings.bags import ros_messages as ros
from cohelm.ros2.cdr import PEOPLE
from cohelm.ros2.clocks import Clock, RobotClock, WallClock
from cohelm.ros2.command_client import CommandClient
from cohelm.ros2.command_process import WheelCommand, publisher
from cohelm.ros2.findings import missing_inputs
from cohelm.ros2.inputs import NEVER, Inputs
from cohelm.ros2.parameters import Ros2Parameters
from cohelm.ros2.transport import SENSOR, STATIC, Reliability, RosNode, make_node
from cohelm.scenarios import RideSetup

_POLL = 0.05  # s
TF = Reliability(reliable=True, depth=100)


class Ros2:
    """Robot that speaks ROS 2: Nav2's topics and frames."""

    simulated = False

    class Parameters(Ros2Parameters):
        """Topics, frames and network."""

    def __init__(self, parameters: Ros2Parameters) -> None:
        self.parameters = parameters

    def open(self, setup: RideSetup) -> Ros2Platform:
        """Wait for all inputs, and return the robot.

        Raises:
            PlatformError: An input does not come; it says which, and what to do.
        """
        node = RobotNode(self.parameters)
        try:
            node.wait()
            return Ros2Platform(node)
        except BaseException:
            node.close()
            raise


class RobotNode:
    """Node with the subscriptions of a robot.

    Args:
        parameters: Topics, frames and network.
    """

    def __init__(self, parameters: Ros2Parameters) -> None:
        self.parameters = p = parameters
        self.clock: Clock = RobotClock() if p.use_sim_time else WallClock()
        self.inputs = Inputs(p, self.clock)
        self.dds: RosNode = make_node(p, p.name)
        take = self.inputs
        moved = functools.partial(take.take_transforms, static=False)
        fixed = functools.partial(take.take_transforms, static=True)
        self.dds.subscribe("/tf", ros.TRANSFORMS, TF, moved)
        self.dds.subscribe("/tf_static", ros.TRANSFORMS, STATIC, fixed)
        self.dds.subscribe(p.odometry, ros.ODOMETRY, SENSOR, take.take_odometry)
        for topic in p.scans:
            scan = functools.partial(take.take_scan, topic)
            self.dds.subscribe(topic, ros.SCAN, SENSOR, scan)
        for topic in p.clouds:
            cloud = functools.partial(take.take_cloud, topic)
            self.dds.subscribe(topic, ros.CLOUD, SENSOR, cloud)
        if p.people is not None:
            self.dds.subscribe(p.people, PEOPLE, SENSOR, take.take_people)
        for topic in p.page_sticks:
            self.dds.subscribe(topic, "sensor_msgs/msg/Joy", SENSOR, take.take_stick)
        if isinstance(self.clock, RobotClock):
            clock = self.clock
            self.dds.subscribe(
                "/clock",
                "rosgraph_msgs/msg/Clock",
                SENSOR,
                lambda message: clock.take(message.clock.sec + 1e-9 * message.clock.nanosec),
            )
        self.stop = publisher(self.dds, p)
        self.dds.start()

    def wait(self) -> None:
        """Wait until every input has come.

        Raises:
            PlatformError: One did not; see ``cohelm ros2 --check``.
        """
        end = time.monotonic() + self.parameters.wait
        missing = missing_inputs(self.parameters, self.inputs)
        while missing and time.monotonic() < end:
            time.sleep(_POLL)
            missing = missing_inputs(self.parameters, self.inputs)
        if missing:
            raise PlatformError("; ".join(missing) + "; see: cohelm ros2 FILE.yaml --check")

    def close(self) -> None:
        """End the node."""
        self.dds.close()


class Ros2Platform:
    """Robot with all inputs.

    Args:
        node: Node that gets them; the platform closes it.
    """

    def __init__(self, node: RobotNode) -> None:
        self._node, self._closed = node, False
        self._command = CommandClient(node.parameters, node.stop)
        name, wait = f"ROS 2 robot on {node.parameters.command}", node.inputs.leading.wait
        self._capabilities = Capabilities(name=name, wait=wait)

    @property
    def capabilities(self) -> Capabilities:
        """A leading scanner."""
        return self._capabilities

    @property
    def node(self) -> RobotNode:
        """Node of the robot."""
        return self._node

    @property
    def command_pid(self) -> int | None:
        """Id of the process that owns the command topic."""
        return self._command.pid

    def observe(self) -> Observation:
        """Return the newest inputs.

        The odometry counts as lost while no command reaches the robot or its clock is silent.
        """
        seen, clock = self._node.inputs.observation(), self._node.clock
        silent = isinstance(clock, RobotClock) and clock.silent
        return replace(seen, twist_time=NEVER) if self._command.late or silent else seen

    def apply(self, decision: Decision) -> None:
        """Send a command to the robot."""
        clock = self._node.clock
        x, y, turn = (float(each) for each in decision.twist)
        finite = all(map(math.isfinite, (x, y, turn)))
        twist = (x, y, turn) if finite else (0.0, 0.0, 0.0)
        self._command.send(WheelCommand(time.monotonic(), clock.stamp(clock.now()), twist))

    def close(self) -> None:
        """Stop the robot, and end node and process."""
        if self._closed:
            return
        self._closed = True
        self._command.close()
        self._node.close()
