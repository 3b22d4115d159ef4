"""Findings about the inputs of a robot: what is missing or wrong, and what to do about it."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.config import nearest
from cohelm.geometry import compose, transform
from cohelm.maps import DistanceField, OccupancyGrid
from cohelm.messages import Scan
from cohelm.recordings.transforms import name
from cohelm.robots import NO_DROP_PROTECTION, Robot
from cohelm.ros2.clocks import RobotClock
from cohelm.ros2.inputs import Inputs, TopicStatistics
from cohelm.ros2.parameters import Ros2Parameters

MIN_RATES = {"scan": 5.0, "odometry": 10.0, "cloud": 5.0, "stick": 5.0, "people": 5.0}
"""Minimum messages per second."""
MAX_DELAY = 0.2
"""Maximum delay of a message, s: half of what the safety gate accepts."""
MIN_MATCH = 0.5
"""Share of a scan's returns near walls of the map from which pose, map and scan agree."""
NEAR = 0.15
"""Distance from a wall at which a return counts as near, m."""
_MOUNT_TOLERANCE = 0.1
"""Maximum distance between the mount in robot file and transforms, m."""
_MAX_BEAMS = 180
_NO_ROBOT = (
    "is the robot on? compare ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE there, and "
    "'dds.interface' in the file (loopback: lo)"
)


class CheckFinding(NamedTuple):
    """One line of the check."""

    fine: bool
    what: str
    """Input."""
    text: str
    """Measured facts, or the problem."""
    remedy: str = ""
    """Advice; empty if it is fine."""


def missing_inputs(parameters: Ros2Parameters, inputs: Inputs) -> list[str]:
    """Return the inputs without which the chair cannot move, each with its reason."""
    out = []
    if isinstance(inputs.clock, RobotClock) and inputs.clock.silent:
        out.append("no /clock")
    for _, topic in parameters.inputs:
        found = inputs.topics.get(topic)
        if found is None:
            out.append(f"no message on {topic}")
        elif found.problem:
            out.append(f"{topic}: {found.problem}")
    if not math.isfinite(inputs.odometry_time) and parameters.odometry in inputs.topics:
        out.append(f"no usable message on {parameters.odometry}")
    if inputs.odometry_problem:
        out.append(f"{parameters.odometry}: {inputs.odometry_problem}")
    frames = parameters.frames
    if inputs.localised() is None:
        out.append(f"no transform from '{frames.map}' to '{frames.odom}'")
    return out


def check_inputs(
    parameters: Ros2Parameters, inputs: Inputs, offered: dict[str, str]
) -> list[CheckFinding]:
    """Return the findings about clock, topics and frames.

    Args:
        parameters: Topics and frames.
        inputs: Inputs after a few seconds.
        offered: Type and reliability of each published topic, by name.
    """
    out = [_clock(inputs)]
    out += [_topic(kind, topic, inputs, offered) for kind, topic in parameters.inputs]
    out.append(_base(parameters, inputs))
    out.append(_localiser(parameters, inputs))
    return out


def check_base(parameters: Ros2Parameters, subscribers: int) -> CheckFinding:
    """Return the finding about the number of subscribers of the command topic."""
    kind, other = ("TwistStamped", "false") if parameters.stamped else ("Twist", "true")
    if subscribers:
        many = "subscribers" if subscribers > 1 else "subscriber"
        return CheckFinding(True, parameters.command, f"{kind}, {subscribers} {many}")
    return CheckFinding(
        False,
        parameters.command,
        f"nobody subscribes to {kind}",
        f"start the base driver; if it takes the other type, write 'stamped: {other}'",
    )


def missing_map(topic: str, offered: dict[str, str]) -> CheckFinding:
    """Return the finding about a map that did not come."""
    quality = offered.get(topic)
    if quality is not None and ("volatile" in quality or "best effort" in quality):
        return CheckFinding(
            False,
            topic,
            f"no map, though it is published as {quality}",
            "publish it reliable and transient local, as map_server does",
        )
    return _silent(topic, offered)


def _clock(inputs: Inputs) -> CheckFinding:
    clock = inputs.clock
    if not isinstance(clock, RobotClock):
        return CheckFinding(True, "clock", "this computer's")
    if clock.silent:
        return CheckFinding(
            False,
            "clock",
            "no message on /clock",
            "start the simulator, or remove 'use_sim_time: true'",
        )
    return CheckFinding(True, "clock", "/clock")


def _topic(kind: str, topic: str, inputs: Inputs, offered: dict[str, str]) -> CheckFinding:
    found = inputs.topics.get(topic)
    if found is None:
        return _silent(topic, offered)
    facts = f"{found.rate:.1f} Hz, frame '{found.frame}'"
    if math.isfinite(found.delay):
        facts += f", delay {1e3 * found.delay:.0f} ms"
    if found.problem:
        return CheckFinding(False, topic, f"{facts}: {found.problem}", _mount_remedy(found, inputs))
    if abs(found.delay) > 1.0:
        return CheckFinding(
            False,
            topic,
            f"{facts}: stamps are not of this clock",
            "synchronise the computers (chrony), or set 'use_sim_time: true' for a simulator",
        )
    if found.delay > MAX_DELAY:
        return CheckFinding(
            False,
            topic,
            f"{facts}: stamps are old",
            f"the driver must stamp when it measures, and send within {MAX_DELAY:g} s",
        )
    if found.rate < MIN_RATES[kind]:
        return CheckFinding(
            False, topic, f"{facts}: too slow", f"at least {MIN_RATES[kind]:g} Hz are needed"
        )
    return CheckFinding(True, topic, facts)


def _silent(topic: str, offered: dict[str, str]) -> CheckFinding:
    if topic in offered:
        return CheckFinding(
            False,
            topic,
            f"no message, though it is published as {offered[topic]}",
            "compare type and quality of service: ros2 topic info --verbose " + topic,
        )
    if not offered:
        return CheckFinding(False, topic, "nobody publishes it, nor any other topic", _NO_ROBOT)
    text = f"nobody publishes it{nearest(topic, list(offered))}"
    known = ", ".join(sorted(offered))
    remedy = f"start its driver, or name another topic in the file; published are: {known}"
    return CheckFinding(False, topic, text, remedy)


def _mount_remedy(found: TopicStatistics, inputs: Inputs) -> str:
    if "no transform" in found.problem:
        return _transform_remedy(inputs)
    if "tilted" in found.problem:
        return "correct the transform of the scanner; upside down is roll 180°"
    return "correct its driver"


def _transform_remedy(inputs: Inputs) -> str:
    known = ", ".join(inputs.frames.frames) or "none"
    return (
        "publish it (robot_state_publisher, static_transform_publisher), or correct 'frames'; "
        f"frames are: {known}"
    )


def _base(parameters: Ros2Parameters, inputs: Inputs) -> CheckFinding:
    frames, moving = parameters.frames, inputs.topics.get(parameters.odometry)
    if moving is None:
        return CheckFinding(False, "odometry frame", "unknown without odometry", "see above")
    if inputs.odometry_problem:
        remedy = _transform_remedy(inputs)
        return CheckFinding(False, "odometry frame", inputs.odometry_problem, remedy)
    taken = "" if moving.frame else "no child_frame_id, taken as "
    return CheckFinding(True, "odometry frame", f"{taken}'{name(moving.frame or frames.base)}'")


def _localiser(parameters: Ros2Parameters, inputs: Inputs) -> CheckFinding:
    frames = parameters.frames
    what = f"{frames.map or frames.odom} → {frames.odom}"
    if frames.map is None:
        return CheckFinding(True, "localiser", "none: odometry frame, no map, no destinations")
    found = inputs.localised()
    if found is None:
        return CheckFinding(
            False,
            what,
            "no transform",
            "start the localiser (AMCL) and give it an initial pose, or set 'frames.map: null'",
        )
    if found[1] > parameters.limits.localiser:
        return CheckFinding(
            False,
            what,
            f"the last transform came {found[1]:.1f} s ago",
            "the localiser must publish at least 5 a second; raise 'limits.localiser' if it does",
        )
    return CheckFinding(True, what, f"{1e3 * found[1]:.0f} ms old")


def check_map(
    grid: OccupancyGrid, walls: DistanceField, pose: Floats, scans: tuple[Scan, ...]
) -> list[CheckFinding]:
    """Return the findings about map, pose and scans.

    Args:
        grid: Map.
        walls: Distance to its walls.
        pose: X_MR, (3,).
        scans: Newest scan of each scanner.
    """
    out = []
    if not (grid.data < 0).any() and not _is_closed(grid):
        out.append(
            CheckFinding(
                False,
                "map",
                "open at its edge, and no cell is unknown: what nobody has seen counts as free",
                "save it in mode trinary with unknown cells, or close its outline with walls",
            )
        )
    cell = grid.cells(pose[None, :2])[0]
    inside = bool(grid.contains(pose[None, :2])[0])
    if not inside or grid.blocked()[int(cell[0]), int(cell[1])]:
        where = "outside the map" if not inside else "in a wall or in unknown space"
        remedy = "set an initial pose in the localiser"
        out.append(CheckFinding(False, "pose", f"the chair is {where}", remedy))
        return out
    return out + [_matching(scan, walls, pose) for scan in scans]


def _is_closed(grid: OccupancyGrid) -> bool:
    """Check that the outer cells of a map are blocked."""
    blocked = grid.blocked()
    edges = (blocked[0], blocked[-1], blocked[:, 0], blocked[:, -1])
    return all(bool(each.all()) for each in edges)


def _matching(scan: Scan, walls: DistanceField, pose: Floats) -> CheckFinding:
    upright = match(scan.ranges, scan, walls, pose)
    mirrored = match(scan.ranges[::-1], scan, walls, pose)
    what = f"scan at ({scan.mount[0]:.2f}, {scan.mount[1]:.2f}) and map"
    if mirrored > max(upright + 0.15, MIN_MATCH):
        return CheckFinding(
            False,
            what,
            f"mirrored: {mirrored:.0%} of its returns are near walls, as it is {upright:.0%}",
            "the scanner is upside down: give its transform roll 180°, or reverse its driver",
        )
    if upright < MIN_MATCH:
        return CheckFinding(
            False,
            what,
            f"only {upright:.0%} of its returns are near walls",
            "check the initial pose, the scanner's transform (yaw) and the map",
        )
    return CheckFinding(True, what, f"{upright:.0%} of its returns are near walls")


def match(ranges: Floats, scan: Scan, walls: DistanceField, pose: Floats) -> float:
    """Return the share of a scan's returns within 0.15 m of a wall; NaN without returns."""
    step = max(len(ranges) // _MAX_BEAMS, 1)
    angles = scan.angle_min + scan.angle_increment * np.arange(len(ranges))
    kept = np.isfinite(ranges)
    r, a = ranges[kept][::step], angles[kept][::step]
    if not len(r):
        return math.nan
    points = transform(compose(pose, scan.mount), np.column_stack([r * np.cos(a), r * np.sin(a)]))
    return float((walls.at(points) <= NEAR).mean())


def check_motion(commanded: float, before: Floats, after: Floats) -> CheckFinding:
    """Return the finding about a short test drive.

    Args:
        commanded: Distance that was commanded, m, forwards.
        before, after: X_MR by localiser and odometry, (3,).
    """
    ahead = np.array([math.cos(before[2]), math.sin(before[2])])
    moved = float((after[:2] - before[:2]) @ ahead)
    if moved < -0.3 * commanded:
        return CheckFinding(
            False,
            "motion",
            f"a forward command moved the base {-moved:.2f} m backwards",
            "correct the sign in the base driver: linear.x > 0 is forward (REP-103)",
        )
    if moved < 0.3 * commanded:
        return CheckFinding(
            False,
            "motion",
            f"a command of {commanded:.2f} m moved the base {moved:.2f} m",
            "check emergency stop, motor power and the command topic's name and type",
        )
    return CheckFinding(True, "motion", f"{moved:.2f} m for {commanded:.2f} m")


def check_sensors(
    parameters: Ros2Parameters, robot: Robot, scans: tuple[Scan, ...]
) -> list[CheckFinding]:
    """Return the finding about the scanners that the robot's file declares."""
    declared = len(robot.lasers) + len(robot.cloud_mounts)
    topics = len(parameters.scans) + len(parameters.clouds)
    if declared != topics:
        return [
            CheckFinding(
                False,
                "robot file",
                f"{robot.name} has {declared} scanners, the file lists {topics} topics",
                "give 'robot:' a file whose lasers and clouds are those of the robot",
            )
        ]
    out = []
    for scan in scans:
        mounts = np.array([laser.pose for laser in robot.lasers])
        apart = np.hypot(*(mounts[:, :2] - scan.mount[:2]).T).min() if len(mounts) else math.inf
        if apart > _MOUNT_TOLERANCE:
            out.append(
                CheckFinding(
                    False,
                    "robot file",
                    f"its scanner is {apart:.2f} m away from that of the transforms",
                    f"write pose: [{scan.mount[0]:.2f}, {scan.mount[1]:.2f}, {scan.mount[2]:.2f}]",
                )
            )
    out = out or [CheckFinding(True, "robot file", robot.name)]
    if not robot.sees_floor:
        out.append(CheckFinding(True, "floor", NO_DROP_PROTECTION))
    return out
