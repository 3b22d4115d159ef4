"""Process that owns the command topic: whatever else fails, the robot gets a stop.

    command within MAX_AGE     it is published at once
    silence                    zeros, 20 a second
    the owner is gone          zeros for LAST_STOPS, then nothing
    this process is gone       the owner notices within ECHO_TIMEOUT and publishes zeros itself

It computes nothing and waits for nothing but its pipe.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, NamedTuple

from cohelm.processes import leave_interrupts
from cohelm.ros2.cdr import types_of
from cohelm.ros2.parameters import Ros2Parameters
from cohelm.ros2.transport import RELIABLE, RosNode, make_node

MAX_AGE = 0.15
"""Maximum time from a command to its publication, and until the next one comes, s."""
MAX_DELAY = 0.05
"""Delay of a command that lengthens the time until the next one must come, s: whatever its way
here took, it moves the robot for no longer than MAX_DELAY + MAX_AGE after it was made."""
NOBODY = -1.0
"""First answer of the process if nobody subscribes to the command topic."""
PERIOD = 0.05
"""Time between zeros, s."""
LAST_STOPS = 1.0
"""Time for which zeros follow after the owner has gone, s."""


class WheelCommand(NamedTuple):
    """Command on its way to the process."""

    made_at: float
    """Time by the monotonic clock that all processes share, s."""
    stamp: float
    """ROS time, s."""
    twist: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class CommandSetup:
    """Arguments of the process."""

    parameters: Ros2Parameters


class CommandLatch:
    """Newest command, and whether it may still be used; no clock and no network.

    Args:
        now: Monotonic time, s.
    """

    def __init__(self, now: float) -> None:
        self._last_at = -math.inf
        self._zero_at = now

    def accepts(self, command: WheelCommand, now: float) -> bool:
        """Take a command; returns False if it is too old, or not a number."""
        fresh = 0.0 <= now - command.made_at <= MAX_AGE
        if not fresh or not all(map(math.isfinite, command.twist)):
            return False
        self._last_at = min(now, command.made_at + MAX_DELAY)
        return True

    def needs_zero(self, now: float) -> bool:
        """Check that a zero is due, since no command came for :data:`MAX_AGE`."""
        if now - self._last_at <= MAX_AGE or now < self._zero_at:
            return False
        self._zero_at = now + PERIOD
        return True

    def timeout(self, now: float) -> float:
        """Time until the next zero may be due, s."""
        due = max(self._last_at + MAX_AGE, self._zero_at)
        return min(max(due - now, 0.001), PERIOD)


def publisher(node: RosNode, parameters: Ros2Parameters) -> Callable[[WheelCommand], None]:
    """Return the function that publishes commands as the robot takes them."""
    kind = "geometry_msgs/msg/TwistStamped" if parameters.stamped else "geometry_msgs/msg/Twist"
    publish = node.publisher(parameters.command, kind, RELIABLE)

    def send(command: WheelCommand) -> None:
        publish(_message(command, parameters))

    return send


def serve_commands(pipe: Connection, setup: CommandSetup) -> None:
    """Main function of the process."""
    leave_interrupts()
    parameters = setup.parameters
    node = make_node(parameters, f"{parameters.name}_command")
    publish = publisher(node, parameters)
    node.start()
    gc.collect()
    gc.freeze()
    end = time.monotonic() + parameters.wait
    while not node.subscribers(parameters.command) and time.monotonic() < end:
        time.sleep(PERIOD)
    if node.subscribers(parameters.command):
        pipe.send(time.monotonic())
        _serve(pipe, publish)
    else:
        pipe.send(NOBODY)
    node.close()


def _serve(pipe: Connection, publish: Callable[[WheelCommand], None]) -> None:
    latch = CommandLatch(time.monotonic())
    stamp_offset = time.time() - time.monotonic()  # until the first command tells the robot's time
    ends = math.inf
    while time.monotonic() < ends:
        command = None
        now = time.monotonic()
        if ends == math.inf:
            try:
                while pipe.poll(latch.timeout(now) if command is None else 0.0):
                    command = pipe.recv()
                if command is not None:  # an owner that stands reads no answers
                    pipe.send(command.made_at)
            except (EOFError, OSError):
                ends = now + LAST_STOPS
        else:
            time.sleep(PERIOD)
        now = time.monotonic()
        if command is not None:
            stamp_offset = command.stamp - command.made_at
            if latch.accepts(command, now):
                publish(command)
                continue
        if latch.needs_zero(now):
            publish(WheelCommand(now, now + stamp_offset, (0.0, 0.0, 0.0)))


def _message(command: WheelCommand, parameters: Ros2Parameters) -> Any:
    """Twist or TwistStamped; made here, since the packages with more messages start slowly."""
    of = types_of("humble").types
    x, y, turn = command.twist
    vector = of["geometry_msgs/msg/Vector3"]
    twist = of["geometry_msgs/msg/Twist"](
        linear=vector(x=x, y=y, z=0.0), angular=vector(x=0.0, y=0.0, z=turn)
    )
    if not parameters.stamped:
        return twist
    seconds, nanoseconds = divmod(max(round(1e9 * command.stamp), 0), 10**9)
    header = of["std_msgs/msg/Header"](
        stamp=of["builtin_interfaces/msg/Time"](sec=seconds, nanosec=nanoseconds),
        frame_id=parameters.frames.base,
    )
    return of["geometry_msgs/msg/TwistStamped"](header=header, twist=twist)
