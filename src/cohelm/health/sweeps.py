"""Checks of one scanner: each sweep against itself, the map, and an earlier sweep."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import compose, inverse
from cohelm.health.agreement import ratio
from cohelm.health.continuity import Continuity, update_continuity
from cohelm.health.map_fit import BeamTable, MapFit, SolidMap, fit_map
from cohelm.health.parameters import HealthParameters
from cohelm.health.scan_motion import ScanMotion, Sweep, scan_motion
from cohelm.health.scan_values import SweepCheck, check_sweep
from cohelm.health.vanished import NO_OBJECTS, FreeObjects, update_free_objects
from cohelm.messages import Scan

_MAX_AGE = 1.0
"""Age at which an earlier sweep is replaced, s."""
_MAX_SHIFT = (0.35, 0.45)
"""Motion after which it is replaced, m and rad."""
_MIN_SHIFT = (0.06, 0.05)
"""Motion from which sweeps are compared, m and rad; below, both tell nothing."""
_MIN_AGE = 0.35
"""Age from which they are compared in any case, s: the wheels may be wrong about the motion."""
_MIN_POINTS = 40


class EarlierSweep(NamedTuple):
    """Sweep with which the next ones are compared."""

    time: float
    ranges: Floats
    pose: Floats
    """Reported pose (3,) at the sweep."""
    odometry: Floats
    """Dead-reckoned pose (3,) at the sweep."""


class SweepAgreement(NamedTuple):
    """Motion between two sweeps against those of wheels and localiser; 1 is a contradiction."""

    wheels: float = 0.0
    pose: float = 0.0
    matched: bool = False
    """True if the sweeps fit each other."""
    torn: bool = False
    """True if one sweep does not continue the other at all."""
    inliers: float = math.nan
    """Share of the points that continue the earlier sweep; NaN: not compared."""


class ScannerState(NamedTuple):
    """Memory of one scanner, and its last results."""

    time: float
    ranges: Floats
    check: SweepCheck
    fit: MapFit
    beams: BeamTable
    agreement: SweepAgreement
    earlier: EarlierSweep
    continuity: Continuity = Continuity()
    objects: FreeObjects = NO_OBJECTS


class PosesAtSweep(NamedTuple):
    """Poses (3,) of the robot at the time of a sweep."""

    reported: Floats
    odometry: Floats
    jumped: bool = False
    """True if the localiser corrects itself: no break of the view."""


def update_scanner(
    memory: ScannerState | None,
    scan: Scan,
    at: PosesAtSweep,
    known: SolidMap,
    p: HealthParameters,
) -> ScannerState:
    """Check one sweep.

    Args:
        memory: of this scanner; None at first.
        scan: the sweep.
        at: poses of the robot at its time.
        known: the map.
        p: parameters.
    """
    check = check_sweep(scan.ranges, scan.range_max, memory.ranges if memory else None)
    stride = max(len(scan.ranges) // p.beams, 1)
    index = np.arange(0, len(scan.ranges), stride, dtype=np.float64)
    angles: Floats = np.asarray(scan.angle_min + scan.angle_increment * index, dtype=np.float64)
    beams = BeamTable(angles, scan.ranges[::stride].copy(), check.usable[::stride].copy())
    fit = fit_map(known, beams, compose(at.reported, scan.mount), scan.range_max, p.wall_tolerance)
    now = EarlierSweep(scan.time, scan.ranges, at.reported, at.odometry)
    earlier = memory.earlier if memory else now
    agreement, keep = _compare(earlier, now, scan, memory, p)
    usual = memory.continuity if memory and not at.jumped else Continuity()
    elapsed = scan.time - memory.time if memory else p.smoothing
    continuity = update_continuity(usual, agreement.inliers, fit, elapsed, scan.time, p)
    objects = update_free_objects(
        memory.objects if memory else NO_OBJECTS,
        scan.ranges,
        scan.angle_min,
        scan.angle_increment,
        compose(at.odometry, scan.mount),
        scan.time,
    )
    earlier = earlier if keep else now
    return ScannerState(
        scan.time, scan.ranges, check, fit, beams, agreement, earlier, continuity, objects
    )


def _compare(
    earlier: EarlierSweep,
    now: EarlierSweep,
    scan: Scan,
    memory: ScannerState | None,
    p: HealthParameters,
) -> tuple[SweepAgreement, bool]:
    """(agreement of the motion since the earlier sweep, True to keep that sweep)."""
    age = now.time - earlier.time
    if memory is None or age <= 0.0 or len(earlier.ranges) != len(now.ranges) or age > 2 * _MAX_AGE:
        return SweepAgreement(), False
    by_wheels = compose(inverse(earlier.odometry), now.odometry)
    by_pose = compose(inverse(earlier.pose), now.pose)
    far = max(math.hypot(each[0], each[1]) for each in (by_wheels, by_pose))
    turn = max(abs(by_wheels[2]), abs(by_pose[2]))
    keep = age < _MAX_AGE and far < _MAX_SHIFT[0] and turn < _MAX_SHIFT[1]
    if age < _MIN_AGE and far < _MIN_SHIFT[0] and turn < _MIN_SHIFT[1]:
        return memory.agreement, keep
    from_wheels = _motion(earlier, now, scan, by_wheels)
    from_pose = _motion(earlier, now, scan, by_pose)
    best = max(from_wheels.inliers, from_pose.inliers)
    if from_wheels.points < _MIN_POINTS:
        return SweepAgreement(), keep
    return SweepAgreement(
        wheels=_excess(from_wheels, scan.mount, by_wheels, p) if best >= p.min_inliers else 0.0,
        pose=_excess(from_pose, scan.mount, by_pose, p) if best >= p.min_inliers else 0.0,
        matched=best >= p.min_inliers,
        torn=best < p.lost_inliers,
        inliers=best,
    ), keep


def _motion(earlier: EarlierSweep, now: EarlierSweep, scan: Scan, motion: Floats) -> ScanMotion:
    """Motion between two sweeps near a motion (3,) of the robot."""
    guess = compose(inverse(scan.mount), compose(motion, scan.mount))
    first, step = scan.angle_min, scan.angle_increment
    return scan_motion(Sweep(earlier.ranges, first, step), Sweep(now.ranges, first, step), guess)


def _excess(found: ScanMotion, X_RS: Floats, motion: Floats, p: HealthParameters) -> float:
    """Difference of the motion between sweeps from ``motion`` (3,), 1 where it contradicts."""
    if found.inliers < p.min_inliers:
        return 0.0
    robot = compose(X_RS, compose(found.motion, inverse(X_RS)))
    return ratio(robot, motion, p.match_difference, p.turn_difference)
