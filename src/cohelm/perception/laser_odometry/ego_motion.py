"""Ego motion of a sensor from its readings alone, for recordings without odometry.

A reading is matched with a map of earlier ones, not with the last one only, so that errors do not
accumulate. A sensor that has not clearly moved keeps exactly its pose.

Scan matching: the pose of a reading relative to known surroundings.

Face points are matched point to line (Censi, An ICP variant using a point-to-line metric, ICRA
2008), point features point to point, with robust weights that discount what does not fit: static
objects outvote walking people. A direction without constraints, as along a corridor, keeps the
initial guess (Zhang et al., ICRA 2016).
"""

from __future__ import annotations

import math
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, replace, value
from cohelm.config import Model
from cohelm.geometry import compose, inverse, wrap_angle
from cohelm.kernels import CACHED, callee
from cohelm.perception.laser_odometry.local_map import (
    CELL,
    Cells,
    FeatureMap,
    feature_map,
    has_neighbour,
    nearest,
    sorted_map,
)
from cohelm.perception.laser_odometry.scan_features import ScanFeatures
from cohelm.planar_fit import add_row, newton_step

CAP = 9.0
"""Squared misfit of a point, in standard deviations, above which it is unmatched."""
_PASSES = ((0.5, 0.2, 6), (0.25, 0.08, 8), (0.15, 0.04, 12))
"""From coarse to fine: largest distance of a neighbour, misfit with weight ¼, m, and iterations."""
_MIN_STEP = 1e-5
"""Shorter steps end a pass, m and rad."""
_MIN_SUPPORT = (4.0, 0.012)
"""Sum, and share, of the weights of the points that must constrain a direction."""
_LEVER_SQ = 4.0
"""Mean squared lever arm of so many points that constrain the heading, m²."""


@value
class ScanMatch:
    """Result of matching a reading."""

    pose: Annotated[Floats, Shape("3")]
    """Pose of the reading in the frame of the map."""
    overlap: float
    """Share of the weight of its points that lie on known features, 0…1."""
    misfit: float
    """Weighted mean of the squared distances in standard deviations, at most ``CAP`` each."""
    constrained: int
    """Number of directions that the surroundings constrain: 2, along a smooth corridor 1, and one
    less if they do not constrain the heading."""


def match_scan(known: FeatureMap, features: ScanFeatures, guess: Floats, noise: float) -> ScanMatch:
    """Find the pose near ``guess`` (3,) at which features fit best.

    Args:
        known: the surroundings.
        features: of the reading, in the robot's frame.
        guess: initial pose.
        noise: standard deviation of the misfit of one object seen twice, m.
    """
    if not len(features) or not len(known.features):
        return ScanMatch(pose=guess, overlap=0.0, misfit=CAP, constrained=0)
    pose, constrained = _align(known.cells, features.rows, guess)
    return evaluate_pose(known, features, pose, noise, int(constrained))


def evaluate_pose(
    known: FeatureMap, features: ScanFeatures, pose: Floats, noise: float, constrained: int = 2
) -> ScanMatch:
    """Evaluate the fit of features at a given pose; arguments as for :func:`match_scan`."""
    if not len(features) or not len(known.features):
        return ScanMatch(pose=pose, overlap=0.0, misfit=CAP, constrained=0)
    squared, weights = _misfits(known.cells, features.rows, pose, noise), features.rows[:, 4]
    return ScanMatch(
        pose=np.array([pose[0], pose[1], float(wrap_angle(pose[2]))]),
        overlap=float(np.average(squared < CAP, weights=weights)),
        misfit=float(np.average(squared, weights=weights)),
        constrained=constrained,
    )


def search_pose(
    known: FeatureMap, features: ScanFeatures, guess: Floats, reach: float, turn: float
) -> Floats:
    """Search a coarse grid about a guess for the pose (3,) with most points in occupied cells.

    Args:
        known: the surroundings.
        features: of the reading.
        guess: middle of the grid.
        reach: half its breadth, m.
        turn: half the range of its headings, rad.
    """
    if not len(features) or not len(known.features):
        return guess
    points = features.points[:: max(len(features) // 150, 1)]
    occupied = np.diff(known.cell_start).reshape(-1, known.n_cols) > 0
    best = _search(occupied, known.origin, points, guess, (reach, turn))
    pose: Floats = compose(
        np.array([guess[0] + best[0], guess[1] + best[1], guess[2]]), [0, 0, best[2]]
    )
    return pose


@njit(**CACHED)
def _align(cells: Cells, seen: Floats, guess: Floats) -> tuple[Floats, int]:
    """(pose (3,), constrained directions) by reweighted least squares, Geman-McClure weights."""
    known, pose = cells.known, guess.copy()
    k, place, constrained = seen.shape[0], np.empty(4), 0
    support = max(_MIN_SUPPORT[0], _MIN_SUPPORT[1] * seen[:, 4].sum())
    for radius, scale, most in _PASSES:
        for _ in range(most):
            c, s = math.cos(pose[2]), math.sin(pose[2])
            # Normal equations of all matched points.
            H, g = np.zeros((3, 3)), np.zeros(3)
            for i in range(k):
                rx, ry = c * seen[i, 0] - s * seen[i, 1], s * seen[i, 0] + c * seen[i, 1]
                place[0], place[1] = pose[0] + rx, pose[1] + ry
                place[2] = c * seen[i, 2] - s * seen[i, 3]
                place[3] = s * seen[i, 2] + c * seen[i, 3]
                j = nearest(cells, place, radius)
                if j < 0:
                    continue
                dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
                nx, ny = known[j, 2], known[j, 3]
                is_point = nx == 0.0 and ny == 0.0
                error = dx * dx + dy * dy if is_point else (nx * dx + ny * dy) ** 2
                weight = seen[i, 4] / (1.0 + error / (scale * scale)) ** 2
                for axis in range(2 if is_point else 1):
                    if is_point:
                        nx, ny = 1.0 - axis, 1.0 * axis
                    across = -nx * ry + ny * rx
                    e = nx * dx + ny * dy
                    add_row(H, g, nx, ny, across, e, weight)
            constrained = _hold_unconstrained(H, g, pose, guess, support)
            step = newton_step(H + 1e-6 * np.eye(3), g)
            pose += step
            if np.abs(step).max() < _MIN_STEP:
                break
    return pose, constrained


@callee()
def _hold_unconstrained(H: Floats, g: Floats, pose: Floats, guess: Floats, support: float) -> int:
    """Fix directions with too little support to the guess; return the number of the others."""
    half = math.hypot(0.5 * (H[0, 0] - H[1, 1]), H[0, 1])
    middle = 0.5 * (H[0, 0] + H[1, 1])
    along = 0.5 * math.atan2(2.0 * H[0, 1], H[0, 0] - H[1, 1])
    constrained, stiff = 2, 1e4
    for large in range(2):
        eigenvalue = middle + half if large else middle - half
        if eigenvalue >= support:
            continue
        constrained -= 1
        angle = along if large else along + 0.5 * math.pi
        vx, vy = math.cos(angle), math.sin(angle)
        off = vx * (pose[0] - guess[0]) + vy * (pose[1] - guess[1])
        H[0, 0] += stiff * vx * vx
        H[0, 1] += stiff * vx * vy
        H[1, 1] += stiff * vy * vy
        g[0] += stiff * vx * off
        g[1] += stiff * vy * off
    # What is left for the heading after the position has been fitted.
    a, b, c, d, e = H[0, 0], H[0, 1], H[1, 1], H[0, 2], H[1, 2]
    explained = (c * d * d - 2.0 * b * d * e + a * e * e) / (a * c - b * b)
    if H[2, 2] - explained < support * _LEVER_SQ:
        H[2, 2] += stiff
        g[2] += stiff * (pose[2] - guess[2])
        constrained = max(constrained - 1, 0)
    return constrained


@njit(**CACHED)
def _misfits(cells: Cells, seen: Floats, pose: Floats, noise: float) -> Floats:
    """(k,) squared distances to the nearest face or point feature, in ``noise``, up to ``CAP``."""
    known, out = cells.known, np.full(seen.shape[0], CAP)
    c, s = math.cos(pose[2]), math.sin(pose[2])
    place = np.empty(4)
    for i in range(seen.shape[0]):
        place[0] = pose[0] + c * seen[i, 0] - s * seen[i, 1]
        place[1] = pose[1] + s * seen[i, 0] + c * seen[i, 1]
        place[2] = c * seen[i, 2] - s * seen[i, 3]
        place[3] = s * seen[i, 2] + c * seen[i, 3]
        j = nearest(cells, place, 0.25)
        if j < 0:
            continue
        dx, dy = place[0] - known[j, 0], place[1] - known[j, 1]
        nx, ny = known[j, 2], known[j, 3]
        is_point = nx == 0.0 and ny == 0.0
        squared = dx * dx + dy * dy if is_point else (nx * dx + ny * dy) ** 2
        out[i] = min(squared / (noise * noise), CAP)
    return out


@njit(**CACHED)
def _search(
    occupied: Booleans, origin: Floats, points: Floats, guess: Floats, limits: tuple[float, float]
) -> Floats:
    """(dx, dy, turn) with the most points in occupied cells; the smallest among equals."""
    rows, columns = occupied.shape
    step, turn = 0.8 * CELL, 0.03
    reach, turns = int(limits[0] / step + 0.5), int(limits[1] / turn + 0.5)
    best, found = -np.inf, np.zeros(3)
    n = points.shape[0]
    x, y = np.empty(n), np.empty(n)
    for t in range(-turns, turns + 1):
        c, s = math.cos(guess[2] + t * turn), math.sin(guess[2] + t * turn)
        for i in range(n):
            x[i] = (guess[0] + c * points[i, 0] - s * points[i, 1] - origin[0]) / CELL
            y[i] = (guess[1] + s * points[i, 0] + c * points[i, 1] - origin[1]) / CELL
        for a in range(-reach, reach + 1):
            for b in range(-reach, reach + 1):
                dx, dy = a * step / CELL, b * step / CELL
                score = -1e-3 * (abs(t) + abs(a) + abs(b))
                for i in range(n):
                    column, row = math.floor(x[i] + dx), math.floor(y[i] + dy)
                    inside = 0 <= column < columns and 0 <= row < rows
                    if inside and occupied[int(row), int(column)]:
                        score += 1.0
                if score > best:
                    best = score
                    found[0], found[1], found[2] = a * step, b * step, t * turn
    return found


class MatchStatus(StrEnum):
    """Certainty of the ego motion."""

    OK = "ok"
    """The reading matches the map."""
    PARTIAL = "partial"
    """It matches, but at least one direction is unconstrained; the last motion continues there."""
    HELD = "held"
    """It does not match for a moment, or shows too little: a resting sensor stays at rest."""
    RESTARTED = "restarted"
    """It does not match: a new segment begins at an unknown pose relative to the last one."""


class EgoMotionParameters(Model):
    """Parameters of the ego motion; assumed where no reason is given."""

    noise: float = Field(0.02, gt=0.0, le=0.5)
    """Standard deviation of one object seen twice, m."""
    min_points: int = Field(25, ge=3, le=1000)
    """Points that a reading must show; with less evidence, a resting sensor stays at rest."""
    min_overlap: float = Field(0.5, gt=0.0, le=1.0)
    """Share of the weight of its points that must match the map."""
    overlap_after_gap: float = Field(0.65, gt=0.0, le=1.0)
    """That share after a gap, or among few objects, which may all be people."""
    gap: float = Field(1.0, gt=0.0, le=60.0)
    """Time between two readings above which it is a gap, s."""
    patience: float = Field(1.0, ge=0.0, le=60.0)
    """Time for which the view of a resting sensor may be covered, s."""
    min_shift: float = Field(0.02, ge=0.0, le=0.5)
    """Least motion of a resting sensor, m."""
    min_turn: float = Field(0.007, ge=0.0, le=0.5)
    """Least turn of a resting sensor, rad (0.4°)."""
    gain: float = Field(0.15, ge=0.0, le=5.0)
    """Least improvement of the mean squared misfit, in squared standard deviations, for a resting
    sensor to have moved."""
    min_objects: int = Field(6, ge=0, le=100)
    """Objects whose whole misfit such an improvement must exceed in sum: fewer may be people."""
    sure_gain: float = Field(0.6, ge=0.0, le=9.0)
    """Improvement for which a single reading is enough; otherwise two are needed."""
    changed: float = Field(0.8, gt=0.0, le=1.0)
    """Overlap below which the reference of a resting sensor is renewed."""
    refresh: float = Field(5.0, gt=0.0, le=600.0)
    """Least time between two renewals, s: if they were frequent, slow objects would carry the pose
    along."""
    calm: float = Field(0.6, gt=0.0, le=10.0)
    """Time without motion after which a sensor is at rest, s."""
    keyframe: float = Field(0.25, gt=0.0, le=5.0)
    """Motion after which a reading is added to the map, m."""
    keyframe_turn: float = Field(0.2, gt=0.0, le=3.0)
    """Turn after which a reading is added to the map, rad."""
    keyframes: int = Field(25, ge=1, le=1000)
    """Points not seen in this many keyframes are dropped."""
    spacing: float = Field(0.05, gt=0.0, le=1.0)
    """Points this near to the map are not added, m."""
    reach: float = Field(1.6, ge=0.0, le=10.0)
    """Half the breadth of the search about the expected position, m."""
    turn: float = Field(0.5, ge=0.0, le=3.1)
    """Half the range of its headings, rad."""


@value
class LocalMap:
    """Features of the keyframes."""

    known: FeatureMap
    number: Annotated[Integers, Shape("k")]
    """Keyframe in which each point was last seen."""
    latest: int
    """Number of the newest keyframe."""
    X_MR: Annotated[Floats, Shape("3")]
    """Pose of the newest keyframe."""


@value
class EgoMotion:
    """Pose of a sensor's robot, and the map for the next reading."""

    time: float
    """Time of the last reading, s."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR; M is the robot's frame at the first reading."""
    twist: Annotated[Floats, Shape("3")]
    """Since the previous reading, robot frame."""
    status: MatchStatus
    overlap: float
    """Share of the reading that matches the map, 0…1."""
    segment: int
    """Number of restarts."""
    length: float
    """Travelled distance, m."""
    resting: bool
    surroundings: LocalMap
    reference: FeatureMap
    """Features at the beginning of the rest, renewed when much has changed."""
    reference_time: float
    """Time of the reference, s."""
    matched_time: float
    """Time of the last reading that matched, s."""
    suspect: bool
    """True if the last reading indicated that the sensor has moved."""
    recent: Annotated[Floats, Shape("h 4")]
    """(time, x, y, heading) of the last readings."""


class _Located(NamedTuple):
    """Located reading."""

    fit: ScanMatch
    resting: bool
    suspect: bool = False


def update_ego_motion(
    last: EgoMotion | None,
    features: ScanFeatures,
    time: float,
    parameters: EgoMotionParameters | None = None,
) -> EgoMotion:
    """Update the ego motion with one reading.

    Args:
        last: the last state; None: this is the first reading, taken at rest at (0, 0, 0).
        features: of the reading, in the robot's frame.
        time: of the reading, s.
        parameters: thresholds.
    """
    p = parameters or EgoMotionParameters()
    if last is None:
        return _started(features, time, np.zeros(3))
    gap = time - last.time
    # A clock reset, which trackers handle themselves, is no new segment.
    if gap < -p.gap:
        return replace(_restarted(last, features, time), segment=last.segment)
    if not gap > 0.0:
        return last
    if not last.resting:
        # Static surroundings have shown that it drives, so that every object counts in full.
        features = replace(features, weights=None)
    found = _locate(last, features, gap, p)
    if found is not None:
        return _accept_match(last, features, time, found, p)
    few = features.evidence < p.min_points
    if last.resting and (few or time - last.matched_time <= p.patience):
        matched = time if few else last.matched_time
        return replace(last, time=time, status=MatchStatus.HELD, overlap=0.0, matched_time=matched)
    return _restarted(last, features, time)


def _restarted(last: EgoMotion, features: ScanFeatures, time: float) -> EgoMotion:
    return replace(
        _started(features, time, last.pose),
        status=MatchStatus.RESTARTED,
        overlap=0.0,
        segment=last.segment + 1,
        length=last.length,
    )


def _started(features: ScanFeatures, time: float, pose: Floats) -> EgoMotion:
    """State at rest without a past."""
    known = feature_map(features.transformed(pose))
    number = np.zeros(len(features), dtype=np.int64)
    return EgoMotion(
        time=time,
        pose=pose,
        twist=np.zeros(3),
        status=MatchStatus.OK,
        overlap=1.0,
        segment=0,
        length=0.0,
        resting=True,
        surroundings=LocalMap(known=known, number=number, latest=0, X_MR=pose),
        reference=known,
        reference_time=time,
        matched_time=time,
        suspect=False,
        recent=np.array([[time, *pose]]),
    )


def _locate(
    last: EgoMotion, features: ScanFeatures, gap: float, p: EgoMotionParameters
) -> _Located | None:
    """Locate a reading; None if it matches nowhere."""
    if len(features) < p.min_points:
        return None
    if last.resting:
        found = _locate_at_rest(last, features, p)
        if found is not None:
            return found
    sure = gap <= p.gap and features.evidence >= p.min_points
    least = p.min_overlap if sure else p.overlap_after_gap
    guess = _extrapolated(last, gap) if gap <= p.gap else last.pose
    known = last.surroundings.known
    fit = match_scan(known, features, guess, p.noise)
    if fit.overlap < least:
        guess = search_pose(known, features, guess, p.reach, p.turn)
        again = match_scan(known, features, guess, p.noise)
        # What the surroundings do not constrain would be a guess of the search.
        fit = again if again.constrained == 2 and again.overlap > fit.overlap else fit
    if fit.overlap < least:
        return None
    here = evaluate_pose(known, features, last.pose, p.noise)
    if last.resting and not _is_better(
        here, fit, features, p
    ):  # much is occluded, the rest has not moved
        return _Located(replace(fit, pose=last.pose), resting=True)
    return _Located(fit, resting=False)


def _locate_at_rest(
    last: EgoMotion, features: ScanFeatures, p: EgoMotionParameters
) -> _Located | None:
    """Exact pose of a resting sensor; None if it has moved or is uncertain."""
    here = evaluate_pose(last.reference, features, last.pose, p.noise)
    there = match_scan(last.reference, features, last.pose, p.noise)
    if here.overlap < p.min_overlap:
        return None
    seems_moved = _is_better(here, there, features, p)
    if seems_moved and (last.suspect or here.misfit - there.misfit > p.sure_gain):
        return None
    fit = replace(here, pose=last.pose, constrained=there.constrained)
    return _Located(fit, resting=True, suspect=seems_moved)


def _is_better(
    here: ScanMatch, there: ScanMatch, features: ScanFeatures, p: EgoMotionParameters
) -> bool:
    """Check that a motion from here to there explains a reading clearly better."""
    distance, turned = _difference(there.pose, here.pose)
    gain = here.misfit - there.misfit
    # More than the people in view could, were they alone to move.
    explained = gain * features.evidence > p.min_objects * CAP
    return (distance > p.min_shift or turned > p.min_turn) and gain > p.gain and explained


def _accept_match(
    last: EgoMotion, features: ScanFeatures, time: float, found: _Located, p: EgoMotionParameters
) -> EgoMotion:
    """State after a reading that was located."""
    pose, gap = found.fit.pose, time - last.time
    recent = np.vstack([last.recent[last.recent[:, 0] >= time - 2.0 * p.calm], [time, *pose]])
    resting = found.resting or _is_calm(recent, p)
    reference, since, surroundings = last.reference, last.reference_time, last.surroundings
    changed = found.fit.overlap < p.changed and time - since >= p.refresh and not found.suspect
    if resting and (changed or not last.resting):
        reference, since = feature_map(features.transformed(pose)), time
    if changed or not resting:
        surroundings = _with_keyframe(surroundings, features, found.fit, p)
    twist = np.zeros(3) if resting else _twist(last.pose, pose, gap)
    return EgoMotion(
        time=time,
        pose=pose,
        twist=twist if gap <= p.gap else np.zeros(3),
        status=MatchStatus.OK if found.fit.constrained == 2 else MatchStatus.PARTIAL,
        overlap=found.fit.overlap,
        segment=last.segment,
        length=last.length + _difference(pose, last.pose)[0],
        resting=resting,
        surroundings=surroundings,
        reference=reference,
        reference_time=since,
        matched_time=time,
        suspect=found.suspect,
        recent=recent,
    )


def _is_calm(recent: Floats, p: EgoMotionParameters) -> bool:
    """Check that the last readings were all taken at one pose."""
    since = recent[recent[:, 0] >= recent[-1, 0] - p.calm - 1e-6]
    if len(since) < 4 or recent[0, 0] > recent[-1, 0] - p.calm + 1e-6:
        return False
    turned = np.abs(wrap_angle(since[:, 3] - since[-1, 3]))
    distance = np.hypot(*(since[:, 1:3] - since[-1, 1:3]).T)
    return bool((distance <= 0.75 * p.min_shift).all() and (turned <= 0.75 * p.min_turn).all())


def _with_keyframe(
    before: LocalMap, features: ScanFeatures, fit: ScanMatch, p: EgoMotionParameters
) -> LocalMap:
    """Add the new points of a reading, if it was taken away from the newest keyframe."""
    off = _difference(fit.pose, before.X_MR)
    if off[0] < p.keyframe and off[1] < p.keyframe_turn and fit.overlap > 0.8:
        return before
    seen, old = features.transformed(fit.pose), before.known.features
    new = ~has_neighbour(before.known, seen, p.spacing)
    again = has_neighbour(feature_map(seen), old, 2.0 * p.spacing)
    latest = before.latest + 1
    last_seen = np.where(again, latest, before.number)
    stays = last_seen > latest - p.keyframes
    points = np.concatenate([old.points[stays], seen.points[new]])
    normals = np.concatenate([old.normals[stays], seen.normals[new]])
    number = np.concatenate([last_seen[stays], np.full(int(new.sum()), latest)])
    known, order = sorted_map(ScanFeatures(points=points, normals=normals))
    return LocalMap(known=known, number=number[order], latest=latest, X_MR=fit.pose)


def _extrapolated(last: EgoMotion, gap: float) -> Floats:
    """Pose after the last motion has continued for ``gap``."""
    dx, dy, turn = last.twist * gap
    half: Floats = compose([0.0, 0.0, 0.5 * turn], [dx, dy, 0.5 * turn])
    return compose(last.pose, half)


def _twist(before: Floats, now: Floats, gap: float) -> Floats:
    """Mean twist between two poses of a robot that turns uniformly."""
    change = compose(inverse(before), now)
    half: Floats = compose([0.0, 0.0, -0.5 * change[2]], [change[0], change[1], 0.0])
    return np.array([half[0], half[1], change[2]]) / gap


def _difference(a: Floats, b: Floats) -> tuple[float, float]:
    """(m, rad)."""
    return math.dist(a[:2], b[:2]), abs(float(wrap_angle(a[2] - b[2])))
