"""Content of a recorded ride: facts about the navigator, every tick, and the topics."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from cohelm.arrays import value
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, Decision, Observation, Request
from cohelm.navigation import Tick
from cohelm.robots import Robot

FORMAT = 2
"""Version of the recording; grows with every incompatible change."""
RIDE_TOPIC = "/cohelm/ride"
"""A :class:`RideFacts`, packed by :mod:`.exact`; the first message."""
TICK_TOPIC = "/cohelm/tick"
"""A :class:`RideTick` each, packed by :mod:`.exact`."""
DRAWN = 0.2
"""Interval of drawings, s; numbers are recorded at every tick."""

MAP, ROBOT = "map", "base_footprint"
"""Frames (REP-105, REP-120): the robot's lies on the floor under its drive axle."""


class Topic(NamedTuple):
    """Type, rate and content of a topic."""

    type: str
    when: str
    content: str


TOPICS: dict[str, Topic] = {
    "/map": Topic("nav_msgs/msg/OccupancyGrid", "once", "map of the navigator"),
    "/robot": Topic("visualization_msgs/msg/MarkerArray", "once", "the chair's footprint"),
    "/tf": Topic("tf2_msgs/msg/TFMessage", "every tick", "X_MR as the localiser gives it"),
    "/tf_static": Topic("tf2_msgs/msg/TFMessage", "a new sensor", "X_RS of every sensor"),
    "/odom": Topic("nav_msgs/msg/Odometry", "every tick", "that pose and the measured twist"),
    "/scan": Topic("sensor_msgs/msg/LaserScan", "every sweep", "of the planar scanner"),
    "/points": Topic("sensor_msgs/msg/PointCloud2", "every sweep", "of the 3-D sensor"),
    "/imu": Topic("sensor_msgs/msg/Imu", "every tick", "of the inertial unit; yaw is 0"),
    "/rider": Topic("sensor_msgs/msg/Joy", "every tick", "the stick: axes forward and left, −1…1"),
    "/goal": Topic("geometry_msgs/msg/PoseStamped", "a change", "destination"),
    "/wishes": Topic("visualization_msgs/msg/MarkerArray", "a change", "points, zones, strokes"),
    "/plan": Topic("nav_msgs/msg/Path", "a change", "the route"),
    "/local_plan": Topic("nav_msgs/msg/Path", "5 Hz", "poses over the local planner's horizon"),
    "/people": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "tracked people"),
    "/predictions": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "most likely predictions"),
    "/social_spaces": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "personal spaces, now"),
    "/groups": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "group spaces, now"),
    "/cmd_vel": Topic("geometry_msgs/msg/TwistStamped", "every tick", "command to the wheels"),
    "/eta": Topic("std_msgs/msg/Float64", "every tick", "η, the rider's authority, 0…1"),
    "/status": Topic(
        "diagnostic_msgs/msg/DiagnosticArray",
        "5 Hz and a change",
        "mode, η, reason (code and sentence), route error, status of the plan",
    ),
    "/truth/odom": Topic("nav_msgs/msg/Odometry", "5 Hz", "true pose of the chair"),
    "/truth/people": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "true people"),
    RIDE_TOPIC: Topic("std_msgs/msg/UInt8MultiArray", "once", "parts of the navigator"),
    TICK_TOPIC: Topic(
        "std_msgs/msg/UInt8MultiArray",
        "every tick",
        "the observation, the request and the decision, exact to the bit",
    ),
}
"""All topics. With several sensors of a kind, the name follows: ``/scan/rear``."""


@value
class RideFacts:
    """Everything needed to set up the same navigator again, without any other file."""

    format: int = FORMAT
    name: str
    """Name of the scenario."""
    seed: int
    versions: Mapping[str, str]
    """Versions of cohelm and its numerical libraries; ``code`` is a digest of cohelm's code."""
    scenario: Mapping[str, Any]
    """The whole scenario, as in its YAML file."""
    robot: Robot
    grid: OccupancyGrid
    """Map of the navigator."""
    filters: tuple[CostmapFilter, ...] = ()
    heat: Crowding | None = None


@value
class RideTick:
    """Input and decision of the navigator at one tick."""

    number: int
    """Number of the tick, from 0 without gaps."""
    observation: Observation
    request: Request | None = None
    """None: the request of the previous tick."""
    decision: Decision
    digest: str
    """See :func:`digest_of`."""


def digest_of(tick: Tick) -> str:
    """Digest of the intermediate results: people, predictions, route, references, η and plan.

    Equal commands may follow from different inputs; equal digests practically do not.
    """
    people, plan, futures = tick.people, tick.plan, tick.predictions
    arrays = [people.id, people.mean, people.covariance, people.heading]
    if futures is not None:
        arrays += [futures.weight, futures.mean]
    if tick.path is not None:
        arrays.append(tick.path.points)
    arrays += [each.poses for each in (tick.reference, tick.shared, plan) if each is not None]
    if plan is not None:
        arrays += [plan.inputs, plan.command]
    if tick.authority is not None:
        arrays += [np.array(tick.authority.eta), tick.authority.twist]
    digest = hashlib.blake2b(digest_size=8)
    for array in arrays:
        digest.update(repr(array.shape).encode())
        digest.update(np.ascontiguousarray(array).data)
    return digest.hexdigest()
