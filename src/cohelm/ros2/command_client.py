"""Owner's end of the process of the command topic."""

from __future__ import annotations

import contextlib
import time
from collections import deque
from collections.abc import Callable
from typing import Any

from cohelm.errors import PlatformError
from cohelm.live.control.worker_process import ProcessGone, WorkerProcess
from cohelm.ros2.command_process import (
    LAST_STOPS,
    NOBODY,
    CommandSetup,
    WheelCommand,
    serve_commands,
)
from cohelm.ros2.parameters import Ros2Parameters

ECHO_TIMEOUT = 0.2
"""Age of a command without an answer from which the owner publishes zeros itself, s."""
LOST_AFTER = 1.0
"""Age from which the process counts as lost, s."""
START_TIMEOUT = 60.0
"""Maximum time for the process to start, s."""


class CommandClient:
    """Owner's end of the process.

    Args:
        parameters: Robot.
        fallback: Publishes a command if the process is lost.
    """

    def __init__(
        self, parameters: Ros2Parameters, fallback: Callable[[WheelCommand], None]
    ) -> None:
        self._fallback = fallback
        # A value of a light module, so that the process imports little and starts fast.
        plain = Ros2Parameters.model_validate(parameters.model_dump())
        self._process = WorkerProcess(serve_commands, CommandSetup(plain), "cohelm-command")
        self._parameters = parameters
        self._wait_for_start()
        self._unanswered: deque[float] = deque()  # times of commands without an answer, s
        self.late = False
        """True if the process did not answer at the last command: the robot got a zero."""

    @property
    def pid(self) -> int | None:
        """Process id."""
        return self._process.pid

    def send(self, command: WheelCommand) -> None:
        """Send a command to the robot.

        Raises:
            PlatformError: The process is lost; zeros have been published in its place.
        """
        try:
            self._process.send(command)
            self._unanswered.append(command.made_at)
            while (answered := self._process.receive(0.0)) is not None:
                while self._unanswered and self._unanswered[0] <= answered:
                    self._unanswered.popleft()
        except ProcessGone as cause:
            self._stop(command)
            raise PlatformError(f"the process of the command topic is lost ({cause})") from None
        # By its own silence the owner proves nothing about the process.
        silence = command.made_at - self._unanswered[0] if self._unanswered else 0.0
        self.late = silence > ECHO_TIMEOUT
        if self.late:
            self._stop(command)
        if silence > LOST_AFTER:
            raise PlatformError("the process of the command topic does not answer")

    def close(self) -> None:
        """End the process; it sends zeros for a second."""
        self._process.close(timeout=LAST_STOPS + 2.0)

    def _stop(self, command: WheelCommand) -> None:
        for _ in range(3):
            with contextlib.suppress(Exception):  # nothing else can be done for the robot
                self._fallback(command._replace(twist=(0.0, 0.0, 0.0)))

    def _wait_for_start(self) -> None:
        end = time.monotonic() + START_TIMEOUT
        while time.monotonic() < end:
            try:
                first: Any = self._process.receive(0.1)
            except ProcessGone as cause:
                raise PlatformError(f"no process for the command topic ({cause})") from None
            if first == NOBODY:
                self._process.close()
                topic, kind = self._parameters.command, "TwistStamped"
                kind = kind if self._parameters.stamped else "Twist"
                raise PlatformError(f"nobody subscribes to {topic} as {kind}")
            if first is not None:
                return
        self._process.kill()
        raise PlatformError("the process of the command topic does not start")
