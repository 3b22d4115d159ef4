"""Ego motion of a sensor from its readings alone, for recordings without odometry.

A reading is matched, point to line, with a keyframe: an earlier reading that is replaced only when
the sensor has clearly moved or sees something else. A sensor at rest keeps exactly its pose.
"""

from __future__ import annotations

import math
from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.geometry import compose, inverse
from cohelm.health.scan_motion import ScanMotion, Sweep, scan_motion
from cohelm.messages import Observation
from cohelm.perception.preprocessing.merged_cloud import merge_clouds

MIN_INLIERS = 0.4
"""Share of the points that must fit with the keyframe."""
MIN_POINTS = 30
"""Points to compare; with fewer, a sensor keeps its pose."""
GAP = 1.0
"""Time between two readings above which the last motion says nothing, s."""
MIN_MOTION = (0.02, 0.007)
"""Least motion from a keyframe, m and rad; a smaller one is none."""
GAIN = 0.03
"""Share of the points that fit only with a motion, for a sensor at rest to have moved."""
KEYFRAME = (0.2, 0.15, 0.75)
"""Motion from a keyframe that replaces it, m and rad, and share of inliers below which it is."""
_TURNS = np.linspace(-0.6, 0.6, 7)
"""Turns from which a match is tried again, rad."""
_FAR = 0.1
"""Distance from the guess that calls for another match, m."""
_AZIMUTHS, _REACH = 240, 30.0
_LOW, _HIGH = 0.3, 2.0
"""Slice of a cloud, m over the floor."""


class MatchStatus(StrEnum):
    """Certainty of the ego motion."""

    OK = "ok"
    HELD = "held"
    """The reading shows too little: the sensor keeps its pose."""
    RESTARTED = "restarted"
    """It matches nothing: a new segment begins at an unknown pose relative to the last one."""


@value
class EgoMotion:
    """Pose of a sensor's robot, and the keyframe for the next reading."""

    time: float
    """Of the last reading, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR; M is the robot's frame at the first reading."""
    twist: Annotated[Floats, Shape("3")]
    """Since the previous reading, robot frame."""
    status: MatchStatus
    segment: int
    """Number of restarts."""
    length: float
    """Travelled distance, m."""
    keyframe: Sweep
    """In the sensor's frame."""
    X_MK: Annotated[Floats, Shape("3")]
    """Pose of the sensor at the keyframe."""


def update_ego_motion(last: EgoMotion | None, observation: Observation) -> EgoMotion:
    """Update the ego motion with a reading of one sensor.

    Args:
        last: the last state; None: this is the first reading, at (0, 0, 0).
        observation: one scan or cloud.
    """
    sweep, X_RS = _sweep(observation)
    time, still = observation.time, np.zeros(3)
    if last is None:
        return EgoMotion(
            time=time, pose=still, twist=still, status=MatchStatus.OK, segment=0, length=0.0,
            keyframe=sweep, X_MK=X_RS,
        )  # fmt: skip
    gap = time - last.time
    if -GAP <= gap <= 0.0:
        return last
    guess = last.pose if not 0.0 < gap <= GAP else compose(last.pose, last.twist * gap)
    match = _match(last, sweep, compose(guess, X_RS))
    if match.points < MIN_POINTS:
        return replace(last, time=time, twist=still, status=MatchStatus.HELD)
    if match.inliers < MIN_INLIERS or gap < 0.0:
        return replace(
            last, time=time, twist=still, status=MatchStatus.RESTARTED, keyframe=sweep,
            segment=last.segment + (gap > 0.0), X_MK=compose(last.pose, X_RS),
        )  # fmt: skip
    distance, turned = math.hypot(*match.motion[:2]), abs(float(match.motion[2]))
    moved = distance > MIN_MOTION[0] or turned > MIN_MOTION[1]
    if not last.twist.any():
        moved &= match.inliers > match.inliers_guess + GAIN
    X_MS = compose(last.X_MK, match.motion) if moved else last.X_MK
    pose = compose(X_MS, inverse(X_RS))
    change = compose(inverse(last.pose), pose)
    renewed = distance > KEYFRAME[0] or turned > KEYFRAME[1] or match.inliers < KEYFRAME[2]
    return replace(
        last,
        time=time,
        pose=pose,
        twist=change / gap if gap <= GAP else still,
        status=MatchStatus.OK,
        length=last.length + math.hypot(*change[:2]),
        keyframe=sweep if renewed else last.keyframe,
        X_MK=X_MS if renewed else last.X_MK,
    )


def _match(last: EgoMotion, sweep: Sweep, X_MS: Floats) -> ScanMotion:
    """Motion of the sensor since the keyframe, near ``X_MS`` or, failing that, turned from it."""
    guess = compose(inverse(last.X_MK), X_MS)
    found = scan_motion(last.keyframe, sweep, guess)
    if found.points >= MIN_POINTS and found.inliers < MIN_INLIERS:
        turned = [np.array([*guess[:2], guess[2] + turn]) for turn in _TURNS]
        tries = [scan_motion(last.keyframe, sweep, each) for each in turned]
        found = max(found, *tries, key=lambda each: each.inliers)
    if math.dist(found.motion[:2], guess[:2]) < _FAR:
        return found
    # Once more, free of the pull of the guess.
    again = scan_motion(last.keyframe, sweep, found.motion)
    return again._replace(inliers_guess=found.inliers_guess)


def _sweep(observation: Observation) -> tuple[Sweep, Floats]:
    """Nearest returns by direction, and X_RS (3,) of the sensor."""
    for scan in observation.scans:
        return Sweep(scan.ranges, scan.angle_min, scan.angle_increment), scan.mount
    seen = merge_clouds(observation.clouds, np.zeros((len(observation.clouds), 3)), _REACH)
    points = seen.points[(seen.points[:, 2] >= _LOW) & (seen.points[:, 2] <= _HIGH)]
    step, ranges = math.tau / _AZIMUTHS, np.full(_AZIMUTHS, np.inf)
    direction = np.arctan2(points[:, 1], points[:, 0]) + math.pi
    beam = np.rint(direction / step).astype(int) % _AZIMUTHS
    np.minimum.at(ranges, beam, np.hypot(points[:, 0], points[:, 1]))
    return Sweep(ranges, -math.pi, step), seen.X_MS
