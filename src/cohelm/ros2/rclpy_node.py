"""Node on ``rclpy``, for computers with a ROS installation; messages stay CDR bytes of ours.

``rclpy`` needs the packages of the message types, which a ROS installation has. Domain, network and
middleware are those of its environment.
"""

from __future__ import annotations

import contextlib
import functools
import importlib
import threading
from collections.abc import Callable
from typing import Any

from cohelm.errors import PlatformError
from cohelm.ros2.cdr import encode
from cohelm.ros2.transport import Reliability, deliver, quality_text

_POLL = 0.2
"""Maximum time between two looks at the end flag, s."""


class RclpyNode:
    """Node with its own thread for subscriptions; see ``transport.RosNode``.

    Args:
        name: Name of the node.
        domain: ROS domain; None: that of the environment.
        threads: Number of threads; more than one for callbacks that wait.

    Raises:
        PlatformError: ``rclpy`` is not installed, or cannot start.
    """

    def __init__(self, name: str, domain: int | None = None, *, threads: int = 1) -> None:
        try:
            self._rclpy = importlib.import_module("rclpy")
            self._context = self._rclpy.Context()
            self._rclpy.init(context=self._context, domain_id=domain)
            self._node = self._rclpy.create_node(name, context=self._context)
        except ImportError as cause:
            text = "source the setup file of a ROS installation first, or use transport dds"
            raise PlatformError(f"no rclpy ({cause}): {text}") from None
        self.name = name
        executors = self._rclpy.executors
        self._executor = (
            executors.SingleThreadedExecutor(context=self._context)
            if threads == 1
            else executors.MultiThreadedExecutor(threads, context=self._context)
        )
        self._executor.add_node(self._node)
        self._publishers: dict[str, list[Any]] = {}
        self._ends, self._lock = threading.Event(), threading.Lock()
        self._thread = threading.Thread(target=self._serve, name=f"rclpy-{name}", daemon=True)

    def subscribe(
        self, topic: str, type_: str, quality: Reliability, take: Callable[[Any], None]
    ) -> None:
        """Call ``take`` with every message of a topic, in the node's thread.

        Raises:
            PlatformError: The package of the type is not installed.
        """
        receive = functools.partial(deliver, type_=type_, take=take)
        self._node.create_subscription(
            rclpy_class(type_), topic, receive, self._profile(quality), raw=True
        )

    def publisher(self, topic: str, type_: str, quality: Reliability) -> Callable[[Any], None]:
        """Return the function that publishes a message; it may be called from any thread.

        Raises:
            PlatformError: The package of the type is not installed.
        """
        made = self._node.create_publisher(rclpy_class(type_), topic, self._profile(quality))
        self._publishers.setdefault(topic, []).append(made)

        def publish(message: Any) -> None:
            with self._lock:
                made.publish(encode(message))

        return publish

    def serve_action(self, action: Any, name: str, execute: Callable[[Any], Any]) -> None:
        """Serve an action; ``execute`` gets each goal's handle, and may wait."""
        importlib.import_module("rclpy.action").ActionServer(
            self._node,
            action,
            name,
            execute_callback=execute,
            cancel_callback=lambda _: self._rclpy.action.CancelResponse.ACCEPT,
            callback_group=self._rclpy.callback_groups.ReentrantCallbackGroup(),
        )

    def matched(self, topic: str) -> int:
        """Return the number of publishers that a subscription is connected with."""
        return int(self._node.count_publishers(topic))

    def subscribers(self, topic: str) -> int:
        """Return the number of subscriptions that a publisher is connected with."""
        return sum(int(made.get_subscription_count()) for made in self._publishers.get(topic, []))

    def published(self) -> dict[str, str]:
        """Return type and quality of service of each topic that others publish, by topic."""
        qos, out = self._rclpy.qos, {}
        for topic, kinds in self._node.get_topic_names_and_types():
            for found in self._node.get_publishers_info_by_topic(topic):
                if found.node_name == self.name:
                    continue
                profile = found.qos_profile
                reliable = profile.reliability != qos.ReliabilityPolicy.BEST_EFFORT
                kept = profile.durability != qos.DurabilityPolicy.VOLATILE
                out[str(topic)] = quality_text(kinds[0], reliable=reliable, kept=kept)
        return out

    def start(self) -> None:
        """Start the thread."""
        self._thread.start()

    def close(self) -> None:
        """End the thread; may be called twice."""
        if self._ends.is_set():
            return
        self._ends.set()
        if self._thread.is_alive():
            self._thread.join()
        self._executor.shutdown()
        self._node.destroy_node()
        with contextlib.suppress(Exception):  # a signal has shut it down already
            self._rclpy.shutdown(context=self._context)

    def _serve(self) -> None:
        while not self._ends.is_set() and self._context.ok():
            with contextlib.suppress(self._rclpy.executors.ExternalShutdownException):
                self._executor.spin_once(timeout_sec=_POLL)

    def _profile(self, quality: Reliability) -> Any:
        qos = self._rclpy.qos
        return qos.QoSProfile(
            depth=quality.depth,
            reliability=qos.ReliabilityPolicy.RELIABLE
            if quality.reliable
            else qos.ReliabilityPolicy.BEST_EFFORT,
            durability=qos.DurabilityPolicy.TRANSIENT_LOCAL
            if quality.transient
            else qos.DurabilityPolicy.VOLATILE,
        )


def rclpy_class(type_: str) -> Any:
    """Return the class of ``rclpy`` for a message or action, as ``nav_msgs/msg/Path``.

    Raises:
        PlatformError: Its package is not installed.
    """
    package, kind, name = type_.split("/")
    try:
        return getattr(importlib.import_module(f"{package}.{kind}"), name)
    except (ImportError, AttributeError) as cause:
        install = f"ros-$ROS_DISTRO-{package.replace('_', '-')}"
        raise PlatformError(f"no {type_} for rclpy ({cause}): install {install}") from None


def to_rclpy(message: Any) -> Any:
    """Return the message of ``rclpy`` that is equal to one of ``rosbags``.

    Raises:
        PlatformError: The package of the type is not installed.
    """
    serialization = importlib.import_module("rclpy.serialization")
    return serialization.deserialize_message(encode(message), rclpy_class(message.__msgtype__))
