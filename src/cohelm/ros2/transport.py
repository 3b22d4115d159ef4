"""Network of a node: Cyclone DDS from its wheel, or ``rclpy`` where ROS is installed.

node = make_node(parameters, "cohelm")
node.subscribe("/scan", SCAN, SENSOR, on_scan)      # called in the node's thread
publish = node.publisher("/plan", PATH, RELIABLE)
node.start()
"""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

from cohelm.ros2.cdr import decode
from cohelm.ros2.parameters import Ros2Parameters

_log = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True)
class Reliability:
    """Quality of service of a topic."""

    reliable: bool
    transient: bool = False
    """Late subscribers get the last message."""
    depth: int = 10


SENSOR = Reliability(reliable=False, depth=5)
"""Sensor data, REP-2003."""
RELIABLE = Reliability(reliable=True)
LATCHED = Reliability(reliable=True, transient=True, depth=1)
"""Maps, static transforms."""
STATIC = Reliability(reliable=True, transient=True, depth=100)
"""Static transforms of several publishers."""


class RosNode(Protocol):
    """Node with its own thread for subscriptions."""

    def subscribe(
        self, topic: str, type_: str, quality: Reliability, take: Callable[[Any], None]
    ) -> None:
        """Call ``take`` with every message of a topic, in the node's thread.

        Args:
            topic: ROS name, as ``/scan``.
            type_: As ``sensor_msgs/msg/LaserScan``.
            quality: Requested quality of service.
            take: Gets the decoded message; it must not wait.
        """
        ...

    def publisher(self, topic: str, type_: str, quality: Reliability) -> Callable[[Any], None]:
        """Return the function that publishes a message; it may be called from any thread."""
        ...

    def matched(self, topic: str) -> int:
        """Return the number of publishers that a subscription is connected with."""
        ...

    def subscribers(self, topic: str) -> int:
        """Return the number of subscriptions that a publisher is connected with."""
        ...

    def published(self) -> dict[str, str]:
        """Return type and quality of service of each topic that others publish, by topic."""
        ...

    def start(self) -> None:
        """Start the thread, after all subscriptions and publishers have been made."""
        ...

    def close(self) -> None:
        """End the thread; may be called twice."""
        ...


def make_node(parameters: Ros2Parameters, name: str) -> RosNode:
    """Return a node on the robot's transport.

    Raises:
        PlatformError: The network or the ROS installation cannot be used.
    """
    if parameters.transport == "rclpy":
        from cohelm.ros2.rclpy_node import RclpyNode  # noqa: PLC0415 # needs ROS

        return RclpyNode(name, parameters.dds.domain)
    from cohelm.ros2.dds import DdsNode  # noqa: PLC0415 # needs the extra

    return DdsNode(parameters.dds, name)


def deliver(data: bytes, type_: str, take: Callable[[Any], None]) -> None:
    """Decode a message and pass it on; a faulty one is logged and ignored."""
    try:
        take(decode(data, type_))
    except ValueError as error:
        _log.warning("a message is ignored: %s", error)
    except Exception:  # a faulty message must not end the node
        _log.exception("a %s could not be processed", type_)


def quality_text(kind: str, *, reliable: bool, kept: bool) -> str:
    """Return type and quality of service of a topic as a sentence's part."""
    return (
        f"{kind}, {'reliable' if reliable else 'best effort'}, "
        f"{'transient local' if kept else 'volatile'}"
    )
