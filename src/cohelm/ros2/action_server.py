"""ROS 2 actions on ``rclpy``: goals become jobs, one at a time, and a new goal ends the old one.

Services of ROS 2 do not cross the border between DDS vendors (rmw_cyclonedds#184), and an action
is three services. So actions need ``rclpy``, with the middleware that its clients use.
"""

from __future__ import annotations

import importlib
import logging
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from cohelm.errors import PlatformError
from cohelm.ros2.rclpy_node import RclpyNode

PERIOD = 0.1
"""Time between two feedback messages, s."""
_THREADS = 4
"""Two actions with their cancel and result services at the same time."""
_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class ActionOutcome:
    """End of a job."""

    succeeded: bool
    result: dict[str, Any] = field(default_factory=dict)
    """Fields of the action's result; those that this version of the type lacks are left out."""


class ActionJob(Protocol):
    """Work for one goal."""

    def step(self) -> ActionOutcome | None:
        """Return the end of the work; None: it goes on."""
        ...

    def feedback(self) -> dict[str, Any]:
        """Return fields of the feedback; empty: there is none."""
        ...

    def cancel(self) -> None:
        """Give up: the client cancelled, or has another goal."""
        ...


class ActionServers:
    """Node with action servers.

    Args:
        name: Name of the node.
        domain: ROS domain; None: that of the environment.

    Raises:
        PlatformError: There is no ROS installation.
    """

    def __init__(self, name: str, domain: int | None = None) -> None:
        self._node = RclpyNode(name, domain, threads=_THREADS)
        self._ends = threading.Event()

    def add(self, action: Any, name: str, begin: Callable[[Any], ActionJob]) -> None:
        """Serve an action.

        Args:
            action: Class of the action, as ``nav2_msgs.action.FollowPath``.
            name: Its name, as ``follow_path``.
            begin: Starts the work for a goal.
        """
        server = _Server(action, begin, self._ends)
        self._node.serve_action(action, name, server.execute)

    def start(self) -> None:
        """Start to serve."""
        self._node.start()

    def close(self) -> None:
        """End all goals and the node; may be called twice."""
        self._ends.set()
        self._node.close()


class _Server:
    def __init__(
        self, action: Any, begin: Callable[[Any], ActionJob], ends: threading.Event
    ) -> None:
        self._action, self._begin, self._ends = action, begin, ends
        self._newest: Any = None

    def execute(self, handle: Any) -> Any:
        """Work on a goal until its end; runs in a thread of the executor."""
        self._newest = handle
        try:
            outcome = self._run(handle, self._begin(handle.request))
        except Exception:  # the client must get an answer
            _log.exception("an action has failed")
            outcome = ActionOutcome(False)
        if outcome is None:
            handle.canceled()
        elif outcome.succeeded:
            handle.succeed()
        else:
            handle.abort()
        return _filled(self._action.Result(), outcome.result if outcome is not None else {})

    def _run(self, handle: Any, job: ActionJob) -> ActionOutcome | None:
        """Return the end of the job; None: the client has cancelled it."""
        while not self._ends.is_set() and handle is self._newest:
            if handle.is_cancel_requested:
                job.cancel()
                return None
            outcome = job.step()
            if outcome is not None:
                return outcome
            told = job.feedback()
            if told:
                handle.publish_feedback(_filled(self._action.Feedback(), told))
            time.sleep(PERIOD)
        if handle is self._newest:
            job.cancel()
        return ActionOutcome(False)


def action_class(type_: str) -> Any:
    """Return the class of an action, as ``nav2_msgs/action/FollowPath``.

    Raises:
        PlatformError: Its package is not installed.
    """
    package, _, name = type_.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.action"), name)
    except (ImportError, AttributeError) as cause:
        install = f"ros-$ROS_DISTRO-{package.replace('_', '-')}"
        raise PlatformError(f"no {type_} for rclpy ({cause}): install {install}") from None


def _filled(message: Any, fields: dict[str, Any]) -> Any:
    for name, value in fields.items():
        if hasattr(message, name):
            setattr(message, name, value)
    return message
