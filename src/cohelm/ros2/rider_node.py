"""Rider and viewers on ROS 2 topics: they are one more page of the drive.

    /joy, /goal_pose            ─► heartbeats, confirmation, STOP, destination
    route, plan, people, status ◄─ messages to pages

A stick with a dead-man button takes control when it is pressed; another stick is a device of the
page that drives (``inputs``). A goal is accepted while no other page drives. A Joy that stops
coming stops the chair, as a lost page does.
"""

from __future__ import annotations

import logging
import math
import time
from typing import Any

from cohelm.live import Drive
from cohelm.live.messages import (
    Heartbeat,
    Rejected,
    ResumeCommand,
    SetGoal,
    StopCommand,
    TakeControl,
    ToPage,
)
from cohelm.live.page.display_messages import TYPES, displays
from cohelm.recordings.transforms import name
from cohelm.ros2.conversions import DeadManButton, StickPosition, is_pressed, stick_of
from cohelm.ros2.parameters import Ros2Parameters
from cohelm.ros2.transport import LATCHED, RELIABLE, SENSOR, make_node
from cohelm.scenarios import Scenario

CLIENT = "ros2"
"""Name of this page of the drive."""
_DISPLAYS = {
    "route": ("/cohelm/route", LATCHED),
    "plan": ("/cohelm/plan", RELIABLE),
    "people": ("/cohelm/people", RELIABLE),
    "rider_authority": ("/cohelm/rider_authority", RELIABLE),
    "status": ("/diagnostics", RELIABLE),
}
"""Topic of each display; the robot itself publishes transforms and odometry."""
_PAUSE = 0.3
"""Time between two Joy messages from which on the stick was away, s; as the link to the driver."""
_log = logging.getLogger(__name__)


class RiderNode:
    """Node of rider and viewers.

    Args:
        parameters: Topics.
        drive: Drive that it belongs to; started.
        scenario: Scenario of the drive.

    Raises:
        PlatformError: The network, or a message type, cannot be used.
    """

    def __init__(self, parameters: Ros2Parameters, drive: Drive, scenario: Scenario) -> None:
        self._parameters, self._drive = parameters, drive
        self._frame = parameters.frames.map or parameters.frames.odom
        self._seq, self._last = 0, StickPosition(0.0, 0.0, False, False)
        self._stop, self._heard = False, -math.inf
        self._button = DeadManButton()
        self._dds = make_node(parameters, f"{parameters.name}_rider")
        if parameters.stick is not None:
            self._dds.subscribe(
                parameters.stick.topic, "sensor_msgs/msg/Joy", SENSOR, self._take_stick
            )
        if parameters.goal is not None:
            kind = "geometry_msgs/msg/PoseStamped"
            self._dds.subscribe(parameters.goal, kind, RELIABLE, self._take_goal)
        if parameters.displays:
            self._displays = {
                shown: self._dds.publisher(topic, TYPES[shown], quality)
                for shown, (topic, quality) in _DISPLAYS.items()
            }
            drive.listen(self._show)
        drive.connect(CLIENT, "driver")
        self._actions = None
        if parameters.actions:
            from cohelm.ros2.nav2_actions import serve_nav2  # noqa: PLC0415 # needs ROS

            self._actions = serve_nav2(parameters, drive, CLIENT, scenario)
        self._dds.start()

    def close(self) -> None:
        """End the node; the chair stops if it drove."""
        if self._actions is not None:
            self._actions.close()
        self._dds.close()
        self._drive.disconnect(CLIENT)

    def _take_stick(self, message: Any) -> None:
        parameters = self._parameters.stick
        if parameters is None:
            return
        drive, arrival, last = self._drive, time.monotonic(), self._last
        stop = is_pressed(message, parameters.stop)
        # Of a stick that comes, or comes back, a button that is held may stop but never confirms.
        new = arrival - self._heard > _PAUSE
        if stop and (new or not self._stop):
            drive.receive(CLIENT, StopCommand(), arrival)
        self._stop, self._heard = stop, arrival
        self._button = self._button.after(message, arrival)
        self._last = now = stick_of(message, parameters)
        if parameters.dead_man is None:
            return
        # The button's own edge: one that is stuck does not take control with each renewal.
        if now.held and not last.held:
            drive.receive(CLIENT, TakeControl(), arrival)
        self._seq += 1
        beat = Heartbeat(
            seq=self._seq,
            sent=1000.0 * arrival,
            forward=now.forward,
            left=now.left,
            device="joystick",
            visible=now.held and not self._button.unchanged(arrival, parameters.renew),
        )
        drive.receive(CLIENT, beat, arrival)
        if now.confirm and not (new or last.confirm):
            drive.receive(CLIENT, ResumeCommand(), arrival)

    def _take_goal(self, message: Any) -> None:
        frame, spot = name(message.header.frame_id), message.pose.position
        if frame != self._frame:
            _log.warning("a goal in frame %r is ignored: goals are in %r", frame, self._frame)
        elif math.isfinite(spot.x) and math.isfinite(spot.y):
            self._drive.receive(CLIENT, SetGoal(point=(float(spot.x), float(spot.y))))

    def _show(self, message: ToPage, client: str | None) -> None:
        """Publish a message to pages; one for another page is not shown."""
        if client == CLIENT and isinstance(message, Rejected):
            _log.warning("%s", message.text)
        if client is not None:
            return
        name_ = self._parameters.name
        for shown, converted in displays(message, time.time(), frame=self._frame, name=name_):
            publish = self._displays.get(shown)
            if publish is not None:
                publish(converted)
