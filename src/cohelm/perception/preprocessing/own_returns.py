"""Returns of the robot itself: its frame, its rider's knees, its own wheels."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, replace, value
from cohelm.geometry import inside_polygon, wrap_angle
from cohelm.kernels import CACHED
from cohelm.messages import Scan

NEAREST = 0.15
"""Range up to which a return belongs to a robot of unknown outline, m: the housing of a scanner and
a leg's radius."""
REACH = 1.0
"""Range up to which a robot of unknown outline may see itself, m; assumed."""
_SAME, _AROUND = 0.1, 0.05
"""Difference in range, m, and in bearing, rad, of returns of one part: its edges flicker."""
_DRIVEN, _TURNED = 0.5, 0.5
"""Motion of a robot, m and rad, after which only its own parts are still where they were; a wall
stays beside a straight path, but not beside a turn."""


@value
class SteadyReturns:
    """Near returns of a scanner that have stayed where they are while the robot moved."""

    mount: Annotated[Floats, Shape("3")]
    """Of the scanner."""
    range: Annotated[Floats, Shape("b")]
    """First range of each beam's object, m; NaN without one near."""
    since: Annotated[Floats, Shape("b 3")]
    """Pose of the robot at that time."""
    own: Annotated[Booleans, Shape("b")]
    """True where it has moved along with the robot."""


def learn_own_returns(
    scan: Scan, X_MR: Floats, known: tuple[SteadyReturns, ...]
) -> tuple[Scan, tuple[SteadyReturns, ...]]:
    """Drop the returns of a robot of unknown outline; also return what is steady now.

    Whatever keeps its place before the scanner while the robot drives and turns is its own.

    Args:
        scan: the scan.
        X_MR: pose (3,) of the robot.
        known: of the scans before, one for each scanner.
    """
    b, seen = len(scan.ranges), scan.ranges
    if not b or not np.isfinite([*X_MR, *scan.mount, scan.angle_increment]).all():
        return scan, known
    others = tuple(each for each in known if not np.array_equal(each.mount, scan.mount))
    before = next((each for each in known if np.array_equal(each.mount, scan.mount)), None)
    if before is None or len(before.range) != b:
        first, since, own = np.full(b, np.nan), np.tile(X_MR, (b, 1)), np.zeros(b, dtype=np.bool_)
    else:
        first, since, own = before.range.copy(), before.since.copy(), before.own.copy()
    near = (seen > 0.0) & (seen < REACH)
    # No return says nothing, since own parts may be dark; beams at their edges see beyond them.
    changed = (seen > 0.0) & ~own & ~(np.abs(first - seen) <= _SAME)
    first[changed] = np.where(near, seen, np.nan)[changed]
    since[changed] = X_MR
    driven = np.hypot(*(since[:, :2] - X_MR[:2]).T)
    turned = np.abs(wrap_angle(since[:, 2] - X_MR[2]))
    own |= near & (driven >= _DRIVEN) & (turned >= _TURNED)
    steady = SteadyReturns(mount=scan.mount, range=first, since=since, own=own)
    return _without(scan, near & _near_own(scan, first, own)), (steady, *others)


def _near_own(scan: Scan, range_: Floats, own: Booleans) -> Booleans:
    """Mask (b,) of the returns beside own ones."""
    out = np.zeros(len(own), dtype=np.bool_)
    known = np.where(own, range_, np.nan)
    reach = min(int(_AROUND / max(abs(scan.angle_increment), 1e-6)), len(own) - 1)
    for shift in range(-reach, reach + 1) if own.any() else ():
        out |= np.abs(np.roll(known, shift) - scan.ranges) <= _SAME
    return out


def without_own_returns(scan: Scan, outline: Floats | None) -> Scan:
    """Scan in which the beams that end on the robot itself have no return (NaN).

    Args:
        scan: its ``mount`` is the scanner on the robot.
        outline: (k, 2) corners of the robot's footprint in its own frame, m; None: unknown.
    """
    beams = float(scan.angle_min), float(scan.angle_increment)
    if not all(map(math.isfinite, (*beams, *scan.mount.tolist()))):
        return scan
    if outline is None:
        own = (scan.ranges > 0.0) & (scan.ranges < NEAREST)
    else:
        own = _inside(scan.ranges, scan.mount, *beams, outline)
    return _without(scan, own)


def _without(scan: Scan, own: Booleans) -> Scan:
    """Scan in which some beams have no return."""
    return replace(scan, ranges=np.where(own, np.nan, scan.ranges)) if own.any() else scan


def _inside(
    ranges: Floats, mount: Floats, angle_min: float, increment: float, outline: Floats
) -> Booleans:
    """Mask (b,) of the beams that end within an outline (k, 2) in the robot's frame."""
    reach = float(np.hypot(*(outline - mount[:2]).T).max())
    own = np.zeros(len(ranges), dtype=np.bool_)
    near = np.flatnonzero((ranges > 0.0) & (ranges < reach))
    if len(near):
        own[near] = inside_polygon(outline, _ends(ranges, near, mount, angle_min, increment))
    return own


@njit(**CACHED)
def _ends(
    ranges: Floats, near: Integers, mount: Floats, angle_min: float, increment: float
) -> Floats:
    """Ends (k, 2) of some beams in the robot's frame, m."""
    out = np.empty((len(near), 2))
    for i in range(len(near)):
        angle = mount[2] + angle_min + increment * near[i]
        out[i, 0] = mount[0] + ranges[near[i]] * math.cos(angle)
        out[i, 1] = mount[1] + ranges[near[i]] * math.sin(angle)
    return out
