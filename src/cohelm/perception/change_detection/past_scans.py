"""Earlier scans, ever sparser with age, and the state of a place in one of them."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from numba import njit
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, SignedBytes, value
from cohelm.config import Model
from cohelm.geometry import compose
from cohelm.kernels import CACHED
from cohelm.messages import Scan
from cohelm.perception.sensor_clocks import CLOCK_RESET


class PastState(IntEnum):
    """State of a place in an earlier scan."""

    UNKNOWN = 0
    """Occluded or out of view."""
    OCCUPIED = 1
    """A beam ended there."""
    FREE = 2
    """Beams passed through it."""
    NO_RETURN = 3
    """No beam came back from that direction."""


class ChangeDetectionParameters(Model):
    """Parameters of the comparison with the past; assumed where no reason is given."""

    min_age: float = Field(0.25, gt=0.0, le=5.0)
    """Age from which a scan is compared, s: a swinging leg has left its place by then."""
    max_age: float = Field(300.0, gt=0.0, le=3600.0)
    """Age at which a scan is dropped, s."""
    age_ratio: float = Field(1.25, gt=1.0, le=10.0)
    """Ratio of the ages of stored scans, counted in scans: a pause costs no memory."""
    margin: float = Field(0.15, gt=0.0, le=1.0)
    """A return within this of an earlier one is the same object, m."""
    margin_growth: float = Field(0.015, ge=0.0, le=0.2)
    """Growth of that with range, m/m (1° of localisation error is 0.017)."""
    max_changed: float = Field(0.05, gt=0.0, le=1.0)
    """Share of the surroundings that may be new. Above it, the pose of the robot does not agree
    with the scans, and the earlier scan is ignored."""
    min_same: float = Field(0.85, gt=0.0, le=1.0)
    """Least share of the surroundings that was there before, for a scan of age 0."""
    same_decay: float = Field(0.2, ge=0.0, le=5.0)
    """Decrease of that share with age, 1/s: the view of a moving chair changes."""
    same_floor: float = Field(0.2, ge=0.0, le=1.0)
    """Least share at any age."""
    min_looks: int = Field(2, ge=1, le=20)
    """Earlier scans that must have observed the place."""
    min_returns: int = Field(3, ge=1, le=20)
    """Returns of something new: fewer may have passed between two beams."""
    no_return_weight: float = Field(0.35, ge=0.0, le=1.0)
    """Weight of a beam without a return against one that passed through: dark and glossy objects
    appear only now and then."""
    same_view: float = Field(0.05, ge=0.0, le=100.0)
    """Motion up to which a scanner without a map has the same view, m and rad. On a rocking robot,
    other views show furniture where nothing was seen before."""
    arrival_time: float = Field(1.5, gt=0.0, le=60.0)
    """An arrival longer ago than this is no evidence any more, s: the object is at rest."""
    rest_time: float = Field(5.0, gt=0.0, le=60.0)
    """Time after which an object that was always there gets the full ``static_log_odds``, s."""
    arrived_log_odds: float = Field(3.0, ge=0.0, le=10.0)
    """Log-odds of arrival where the place was free until recently."""
    mislocalised_log_odds: float = Field(-2.0, ge=-10.0, le=0.0)
    """Log-odds of arrival of everything while the pose of the robot does not agree with scans."""
    static_log_odds: float = Field(-2.0, ge=-10.0, le=0.0)
    """Log-odds of arrival where the place was occupied as often as it was observed."""


@value
class PastScan:
    """Stored scan."""

    scan: Scan
    X_MS: Annotated[Floats, Shape("3")]
    """Pose of its sensor."""
    number: int
    """Count of earlier scans of that sensor."""


PastScans = tuple[PastScan, ...]
"""Stored scans, the newest first."""


class PastBeams(NamedTuple):
    """A past scan for compiled code."""

    ranges: Floats
    """(b,) m."""
    angle_min: float
    increment: float
    range_max: float
    X_MS: Floats
    """(3,)."""


def remember_scan(
    past: PastScans, scan: Scan, X_MR: Floats, parameters: ChangeDetectionParameters | None = None
) -> PastScans:
    """Store a scan taken at robot pose ``X_MR``, and drop scans that are dense enough or too old.

    A clock reset clears the past; a scan or a pose that is not finite leaves it unchanged.
    """
    p = parameters or ChangeDetectionParameters()
    mount = scan.mount.tolist()
    given = [scan.time, *X_MR.tolist(), *mount, scan.angle_min, scan.angle_increment]
    if not all(map(math.isfinite, given)) or scan.angle_increment == 0.0 or not len(scan.ranges):
        return past
    if past and scan.time < past[0].scan.time - CLOCK_RESET:
        past = ()
    others = [each for each in past if each.scan.mount.tolist() != mount]
    before = [each for each in past if each.scan.mount.tolist() == mount]
    number = before[0].number + 1 if before else 0
    stored = [PastScan(scan=scan, X_MS=compose(X_MR, scan.mount), number=number)]
    for k, each in enumerate(before):
        older = before[k + 1].number if k + 1 < len(before) else -math.inf
        since = max(number - stored[-1].number, 2)
        sparse = p.age_ratio**2 * since < number - older
        if sparse and scan.time - each.scan.time <= p.max_age:
            stored.append(each)
    return tuple(sorted((*stored, *others), key=lambda each: -each.scan.time))


def past_beams(past: PastScan) -> PastBeams:
    """Convert a past scan for :func:`compare_places`."""
    scan = past.scan
    first, step, reach = float(scan.angle_min), float(scan.angle_increment), float(scan.range_max)
    return PastBeams(scan.ranges, first, step, reach, past.X_MS)


@njit(**CACHED)
def compare_places(
    points: Floats, width: Floats, beams: PastBeams, margin: tuple[float, float]
) -> SignedBytes:
    """State (p,) of the places of points in a past scan, a :class:`PastState` each.

    A place is occupied if a return lies within the margin. It is free if all of three beams about
    it end beyond the margin, as far as they return, and if they are so dense that at least two
    would hit the object that stands there now. Otherwise it was occluded or out of view.

    Args:
        points: (p, 2), map frame, m.
        width: (p,) of the object of each, m.
        beams: the past scan.
        margin: m, and its growth with range, m/m.
    """
    ranges, b, X_MS = beams.ranges, beams.ranges.shape[0], beams.X_MS
    out = np.zeros(points.shape[0], dtype=np.int8)
    cos, sin, step = math.cos(X_MS[2]), math.sin(X_MS[2]), abs(beams.increment)
    full_turn = (b + 1) * step >= 2.0 * math.pi
    for i in range(points.shape[0]):
        dx, dy = points[i, 0] - X_MS[0], points[i, 1] - X_MS[1]
        x, y = cos * dx + sin * dy, cos * dy - sin * dx
        distance = math.hypot(x, y)
        near = margin[0] + margin[1] * distance
        turned = math.atan2(y, x) - beams.angle_min
        turned = turned if beams.increment > 0.0 else -turned
        if not 0.0 <= turned < 2.0 * math.pi:  # the remainder is expensive
            turned %= 2.0 * math.pi
        beam = turned / step
        middle = round(beam)
        if distance < near:
            continue
        reach = min(int(near / (distance * step)) + 1, b // 2)
        occupied, clear, lost, count = False, distance + near <= beams.range_max, 0, 0
        # From the middle outwards: an object that is still there is found at once.
        for turn in range(2 * reach + 1):
            k = middle + (-(turn // 2) if turn % 2 == 0 else (turn + 1) // 2)
            inside = 0 <= k < b
            if not (full_turn or inside):
                continue
            r = ranges[k if inside else k % b]
            returned = r > 0.0 and r <= beams.range_max
            if returned:
                # Squared distance of the two, for a small angle between them.
                across = (k - beam) * step
                occupied = (r - distance) ** 2 + r * distance * across * across <= near * near
                if occupied:
                    break
            if abs(k - middle) <= 1:
                count += 1
                lost += not returned and not r > beams.range_max
                clear = clear and (not returned or r > distance + near)
        if occupied:
            out[i] = PastState.OCCUPIED
        elif clear and count == 3 and 2.0 * distance * step <= width[i]:
            out[i] = PastState.NO_RETURN if lost == 3 else PastState.FREE
    return out
