"""Live ride as ROS messages for viewers: RViz on topics, Foxglove and Lichtblick on a socket."""

from __future__ import annotations

import io
from collections.abc import Iterator
from typing import Any

import numpy as np
from PIL import Image

from cohelm.live.messages import ChairState, PersonInfo, RouteUpdate, SceneInfo, ToPage
from cohelm.maps import OccupancyGrid
from cohelm.messages import People
from cohelm.recordings.rides import markers as draw
from cohelm.recordings.rides import ros_messages as ros
from cohelm.recordings.rides.ride import MAP, ROBOT

EVERY = 4
"""Control steps between two sets of markers: five a second."""
TYPES = {
    "route": "nav_msgs/msg/Path",
    "plan": "nav_msgs/msg/Path",
    "people": "visualization_msgs/msg/MarkerArray",
    "rider_authority": "std_msgs/msg/Float64",
    "status": "diagnostic_msgs/msg/DiagnosticArray",
    "odometry": "nav_msgs/msg/Odometry",
    "transform": "tf2_msgs/msg/TFMessage",
}
"""Type of each display."""


def displays(
    message: ToPage, time: float, *, frame: str = MAP, robot: str = ROBOT, name: str = "cohelm"
) -> Iterator[tuple[str, Any]]:
    """Yield (display, ROS message) of a message to all pages; others have none.

    Args:
        message: Message of the drive.
        time: Stamp, s.
        frame: Frame of the map.
        robot: Frame of the chair.
        name: Name of the sender in the status.
    """
    if isinstance(message, RouteUpdate):
        points = np.array(message.points).reshape(-1, 2)
        poses = np.column_stack([points, np.zeros(len(points))])
        yield "route", ros.path(time, frame, poses)
    if not isinstance(message, ChairState):
        return
    pose, twist = np.array(message.pose), np.array([message.speed, 0.0, message.turn_rate])
    there = np.array([pose[0], pose[1], 0.0, 0.0, 0.0, pose[2]])
    yield "transform", ros.transform(time, (frame, robot), there)
    yield "odometry", ros.odometry(time, (frame, robot), pose, twist)
    yield "rider_authority", ros.number(message.rider_authority)
    if message.seq % EVERY:
        return
    yield "plan", ros.path(time, frame, np.array(message.plan).reshape(-1, 3))
    shown = draw.people(time, people_of(message.people, time))
    for marker in shown.markers:
        marker.header = ros.header(time, frame)
    yield "people", shown
    yield "status", _status(message, time, name)


def floor_of_scene(scene: SceneInfo, png: bytes) -> OccupancyGrid:
    """Return the map of a scene from its image: 0 occupied, 128 unknown, 255 free."""
    with Image.open(io.BytesIO(png)) as image:
        grey = np.asarray(image.convert("L"))[::-1].astype(int)
    data = np.where(grey == 0, 100, np.where(grey == 255, 0, -1)).astype(np.int8)
    corner = np.array([scene.floor.x, scene.floor.y, 0.0])
    return OccupancyGrid(data=data, resolution=scene.floor.resolution, X_MG=corner)


def people_of(rows: tuple[PersonInfo, ...], time: float) -> People:
    """Return the tracked people of a state message."""
    n = len(rows)
    return People(
        time=time,
        id=np.array([each.id for each in rows], dtype=np.int64),
        mean=np.array([(p.x, p.y, p.vx, p.vy) for p in rows]).reshape(n, 4),
        covariance=np.zeros((n, 4, 4)),
        heading=np.array([each.axis for each in rows], dtype=float),
        radius=np.array([each.radius for each in rows], dtype=float),
        confidence=np.ones(n),
    )


def _status(state: ChairState, time: float, name: str) -> Any:
    reason = state.reason
    text = reason.text if reason is not None else "no limitation"
    facts = {
        "mode": state.mode.value,
        "link": state.link,
        "reason": reason.code if reason is not None else "",
        "eta": f"{state.rider_authority:.3f}",
    }
    return ros.status(time, name, text, facts, fine=reason is None)
