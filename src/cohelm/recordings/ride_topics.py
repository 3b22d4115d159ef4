"""The topics of a recorded ride, each with the ROS 2 type that usual viewers know."""

from __future__ import annotations

from typing import NamedTuple

from cohelm.recordings.ride import RIDE_TOPIC, TICK_TOPIC

DRAWN = 0.2
"""Between two drawings of what moves, s; numbers are recorded at every tick."""

MAP, ROBOT = "map", "base_footprint"
"""Frames, after REP-105 and REP-120: the robot's lies on the floor under its drive axle."""


class Topic(NamedTuple):
    """What is said on a topic."""

    type: str
    when: str
    says: str


TOPICS: dict[str, Topic] = {
    "/map": Topic("nav_msgs/msg/OccupancyGrid", "once", "the map as the navigator has it"),
    "/robot": Topic("visualization_msgs/msg/MarkerArray", "once", "the chair's footprint"),
    "/tf": Topic("tf2_msgs/msg/TFMessage", "every tick", "X_MR as the localiser gives it"),
    "/tf_static": Topic("tf2_msgs/msg/TFMessage", "a new sensor", "X_RS of every sensor"),
    "/odom": Topic("nav_msgs/msg/Odometry", "every tick", "that pose and the measured twist"),
    "/scan": Topic("sensor_msgs/msg/LaserScan", "every sweep", "of the planar scanner"),
    "/points": Topic("sensor_msgs/msg/PointCloud2", "every sweep", "of the 3-D sensor"),
    "/rider": Topic("sensor_msgs/msg/Joy", "every tick", "the stick: axes forward and left, −1…1"),
    "/goal": Topic("geometry_msgs/msg/PoseStamped", "a change", "where the ride is to end"),
    "/wishes": Topic("visualization_msgs/msg/MarkerArray", "a change", "points, zones, strokes"),
    "/plan": Topic("nav_msgs/msg/Path", "a change", "the route"),
    "/local_plan": Topic("nav_msgs/msg/Path", "5 Hz", "poses over the local planner's horizon"),
    "/people": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "who is believed to be there"),
    "/predictions": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "their likeliest futures"),
    "/social_spaces": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "of each person, now"),
    "/groups": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "the spaces of groups, now"),
    "/cmd_vel": Topic("geometry_msgs/msg/TwistStamped", "every tick", "what goes to the wheels"),
    "/eta": Topic("std_msgs/msg/Float64", "every tick", "η, how much the rider steers, 0…1"),
    "/status": Topic(
        "diagnostic_msgs/msg/DiagnosticArray",
        "5 Hz and a change",
        "mode, η, the reason as a code and in words, why there is no route, the plan's status",
    ),
    "/truth/odom": Topic("nav_msgs/msg/Odometry", "5 Hz", "where the chair truly was"),
    "/truth/people": Topic("visualization_msgs/msg/MarkerArray", "5 Hz", "who truly was there"),
    RIDE_TOPIC: Topic("std_msgs/msg/UInt8MultiArray", "once", "what the navigator was made of"),
    TICK_TOPIC: Topic(
        "std_msgs/msg/UInt8MultiArray",
        "every tick",
        "the observation, the request and the decision, exact to the bit",
    ),
}
"""All of them. Of several scanners or 3-D sensors each has its name behind: ``/scan/rear``."""
