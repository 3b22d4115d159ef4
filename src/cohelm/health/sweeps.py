"""Checks of one scanner: each sweep against itself, the map, and an earlier sweep.

*By itself*: invalid readings, stuck values, a repeated sweep.

*Continuity*: a view that breaks off, after which less of it is on the map. A chair that is carried,
or whose localiser lies, sees another place from one moment to the next. The map alone may explain
that place nearly as well: corridors and rooms resemble each other, and what stands before a wall
may be people. Both together tell: the sweep does not continue the earlier one, and from then on
fewer beams end on mapped walls. People who pass hide walls slowly, and a map that is wrong does not
break the view.

*Vanished objects*, which stood free in a sweep and are nowhere in the next ones. A scanner that
goes blind in a sector, and reads it as free, shows an open floor: no map contradicts it where the
walls are out of reach. But whoever stood there cannot be gone. An object counts if it stands free
and near, so that several beams meet it; it has vanished if beams pass through its place and all
places that it could have reached, and nothing hides them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import between, compose, inverse, transform
from cohelm.health.agreement import ratio
from cohelm.health.map_fit import BeamTable, MapFit, SolidMap, fit_map
from cohelm.health.parameters import HealthParameters
from cohelm.health.scan_motion import ScanMotion, Sweep, scan_motion
from cohelm.kernels import CACHED, callee
from cohelm.messages import Scan

_FAR = 6.0
"""Distance up to which an object counts, m: farther ones return few beams."""
_NEAR = 0.8
"""Distance below which none counts, m: the chair's own parts and who leans on it."""
_BEAMS = 4
_STEP = 0.3
"""Largest step of the range between neighbouring beams of one object, m."""
_FREE = 0.5
"""Distance from its edges to what lies behind them, m."""
_WIDTH = (0.15, 1.0)
"""Of an object, m."""
_REACH = 0.9
"""Distance that it can move between some sweeps, and half its width, m."""
_KEPT = 1.2
"""Time since it was last seen whole for which it is remembered, s: so long takes a walker into a
blind sector."""
_CONFIRMED = 0.09
"""Time for which it must be gone, s: two sweeps."""
_PRESENT, _GONE, _HIDDEN = 0, 1, 2


class FreeObjects(NamedTuple):
    """Objects of the last sweeps."""

    rows: Floats
    """(n, 4): x, y in the odometry frame, m; time when it was last seen whole, and time since when
    it is gone, s, NaN: it is not."""

    def vanished(self, time: float) -> bool:
        """Check whether one is gone for long enough at a time, s."""
        return bool((time - self.rows[:, 3] >= _CONFIRMED - 1e-9).any())


NO_OBJECTS = FreeObjects(np.zeros((0, 4)))


def update_free_objects(
    before: FreeObjects, ranges: Floats, first: float, increment: float, X_OS: Floats, time: float
) -> FreeObjects:
    """Look for the objects of the last sweeps in a new one, and add its own.

    Args:
        before: objects of the last sweeps.
        ranges: of the new sweep (b,), m; +inf: free.
        first, increment: direction of the first beam and step to the next, rad.
        X_OS: pose (3,) of the scanner in the odometry frame.
        time: of the sweep, s.
    """
    known = before.rows[time - before.rows[:, 2] <= _KEPT]
    places = transform(inverse(X_OS), known[:, :2]) if len(known) else known[:, :2]
    found = _free_objects(ranges, first, increment)
    out = [np.array([*transform(X_OS, each), time, math.nan]) for each in found]
    for row, place in zip(known, places, strict=True):
        state, x, y = _look(ranges, first, increment, place[0], place[1])
        if state == _GONE:
            out.append(np.array([*row[:3], time if math.isnan(row[3]) else row[3]]))
        elif state == _PRESENT and not _is_near(found, place):
            out.append(np.array([*transform(X_OS, np.array([x, y])), row[2], math.nan]))
    return FreeObjects(np.array(out)) if out else NO_OBJECTS


def _is_near(found: Floats, place: Floats) -> bool:
    return len(found) > 0 and bool(np.hypot(*(found - place).T).min() < _REACH)


@njit(**CACHED)
def _free_objects(ranges: Floats, first: float, increment: float) -> Floats:
    """Centres (n, 2) of the objects that stand free, in the scanner's frame, m."""
    b = len(ranges)
    out, n = np.empty((b, 2)), 0
    start = 0
    while start < b and _joined(ranges, start - 1, start):
        start += 1
    k = 0
    while k < b and start < b:
        i, length = (start + k) % b, 1
        if not 0.05 < ranges[i] < _FAR:
            k += 1
            continue
        while k + length < b and _joined(ranges, (i + length - 1) % b, (i + length) % b):
            length += 1
        last = (i + length - 1) % b
        behind = min(ranges[i - 1] - ranges[i], ranges[(last + 1) % b] - ranges[last])
        width = ranges[i] * abs(increment) * (length - 1)
        if length >= _BEAMS and _WIDTH[0] < width < _WIDTH[1] and behind > _FREE:
            x, y = 0.0, 0.0
            for j in range(length):
                a, r = first + increment * ((i + j) % b), ranges[(i + j) % b]
                x, y = x + r * math.cos(a) / length, y + r * math.sin(a) / length
            out[n, 0], out[n, 1] = x, y
            n += 1
        k += length
    return out[:n]


@callee()
def _joined(ranges: Floats, i: int, j: int) -> bool:
    """Check that two neighbouring beams meet one object."""
    one, other = ranges[i], ranges[j]
    returned: bool = 0.05 < one < 1e3 and 0.05 < other < 1e3
    return returned and bool(abs(one - other) < _STEP)


@njit(**CACHED)
def _look(
    ranges: Floats, first: float, increment: float, x: float, y: float
) -> tuple[int, float, float]:
    """State of an object that was at a place of the scanner's frame, and its place now, m."""
    far, beams, returns, at_x, at_y = math.hypot(x, y), 0, 0, 0.0, 0.0
    if far < _NEAR:
        return _HIDDEN, x, y
    half, middle = math.atan2(_REACH, far), math.atan2(y, x)
    for i in range(len(ranges)):
        a, r = first + increment * i, ranges[i]
        if abs((a - middle + math.pi) % (2.0 * math.pi) - math.pi) > half:
            continue
        beams += 1
        if not r > 0.05 or r < far - _REACH:
            return _HIDDEN, x, y
        px, py = r * math.cos(a), r * math.sin(a)
        if r < 1e3 and math.hypot(px - x, py - y) < _REACH:
            returns, at_x, at_y = returns + 1, at_x + px, at_y + py
    if returns:
        return _PRESENT, at_x / returns, at_y / returns
    whole = beams * abs(increment) >= 2.0 * half - 2.0 * abs(increment)
    return (_GONE if whole and beams >= _BEAMS else _HIDDEN), x, y


_MIN_BEAMS = 30
"""Beams with an expectation without which a sweep tells nothing about walls."""
_WATCHED = 1.0
"""Time after a break within which fewer beams on walls are due to it, s; also the time for which as
many as before must end on walls until it is forgotten."""


class Continuity(NamedTuple):
    """Usual shares, and the last break; NaN: not known yet."""

    inliers: float = math.nan
    """Usual share of a sweep that continues the earlier one."""
    on_walls: float = math.nan
    """Usual share of the beams that end on mapped walls."""
    broken: float = -math.inf
    """Time of the last sweep that broke off, or showed less of the map after one that did, s."""
    fall: float = 0.0
    """Fall of the share on walls below what was usual before the break; 0 without a break."""


def update_continuity(
    before: Continuity,
    inliers: float,
    fit: MapFit,
    elapsed: float,
    time: float,
    p: HealthParameters,
) -> Continuity:
    """Add a sweep; the usual shares stay as they were before a break while it is watched.

    Args:
        before: continuity before.
        inliers: share of the sweep that continues an earlier one; NaN: not comparable.
        fit: of the sweep to the map.
        elapsed: time since the last sweep, s.
        time: of the sweep, s.
        p: parameters.
    """
    expected = fit.hit + fit.short + fit.through + fit.missing
    on_walls = fit.hit / expected if expected else 0.0
    breaks = before.inliers - inliers >= p.break_drop
    if breaks or time - before.broken <= _WATCHED:
        known = expected >= _MIN_BEAMS and not math.isnan(before.on_walls)
        fall = before.on_walls - on_walls if known else 0.0
        broken = time if breaks or fall >= p.break_fall else before.broken
        return before._replace(broken=broken, fall=fall)
    share = 1.0 - math.exp(-elapsed / p.smoothing)
    return Continuity(
        _towards(before.inliers, inliers, share), _towards(before.on_walls, on_walls, share)
    )


def _towards(usual: float, now: float, share: float) -> float:
    """Mean that forgets; what is not known changes nothing."""
    if math.isnan(now):
        return usual
    return now if math.isnan(usual) else usual + share * (now - usual)


SAME_RANGE = 1e-3
"""Difference below which neighbouring beams read the same value, m: a tenth of the noise of a
scanner."""
SAME_BEAMS = 20
"""Length of a run of equal values from which they are stuck; also a share of the beams, below."""
SAME_SHARE = 0.1


class SweepCheck(NamedTuple):
    """Result of :func:`check_sweep`."""

    usable: Booleans
    """Beams (b,) with a return or a free path that may be believed."""
    invalid: float
    """Share of the beams without a believable reading."""
    stuck: float
    """Share of the beams that belong to a run of one value."""
    repeated: float
    """Share of the returns that equal the sweep before to the last bit; 0 without one."""


def check_sweep(ranges: Floats, range_max: float, before: Floats | None) -> SweepCheck:
    """Check the ranges (b,) of a sweep, m, against themselves and the sweep before."""
    past = before if before is not None and len(before) == len(ranges) else ranges[:0]
    return SweepCheck(*_check(ranges, range_max, past))


@njit(**CACHED)
def _check(
    ranges: Floats, range_max: float, before: Floats
) -> tuple[Booleans, float, float, float]:
    b = len(ranges)
    usable = np.zeros(b, dtype=np.bool_)
    least = max(SAME_BEAMS, int(SAME_SHARE * b))
    # +inf is a free path (REP-117); NaN, −inf, 0 and beyond the sensor's range are no readings.
    for i in range(b):
        r = ranges[i]
        usable[i] = r == math.inf or (r > 0.0 and r <= range_max)
    # Runs of returns with one value: noise makes them impossible.
    stuck, i = 0, 0
    while i < b:
        j = i + 1
        if math.isfinite(ranges[i]) and usable[i]:
            while j < b and abs(ranges[j] - ranges[i]) <= SAME_RANGE:
                j += 1
            if j - i >= least:
                stuck += j - i
                usable[i:j] = False
        i = j
    equal, returns = 0, 0
    if len(before):
        for i in range(b):
            if math.isfinite(ranges[i]):
                returns += 1
                equal += ranges[i] == before[i]
    repeated = equal / returns if returns >= SAME_BEAMS else 0.0
    return usable, 1.0 - usable.sum() / max(b, 1), stuck / max(b, 1), repeated


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
    by_wheels = between(earlier.odometry, now.odometry)
    by_pose = between(earlier.pose, now.pose)
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
    guess = between(scan.mount, compose(motion, scan.mount))
    first, step = scan.angle_min, scan.angle_increment
    return scan_motion(Sweep(earlier.ranges, first, step), Sweep(now.ranges, first, step), guess)


def _excess(found: ScanMotion, X_RS: Floats, motion: Floats, p: HealthParameters) -> float:
    """Difference of the motion between sweeps from ``motion`` (3,), 1 where it contradicts."""
    if found.inliers < p.min_inliers:
        return 0.0
    robot = compose(X_RS, compose(found.motion, inverse(X_RS)))
    return ratio(robot, motion, p.match_difference, p.turn_difference)
