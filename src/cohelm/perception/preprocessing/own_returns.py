"""Returns of the robot itself: its frame, its rider's knees, its own wheels."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.geometry import inside_polygon
from cohelm.messages import Scan

NEAREST = 0.15
"""Range up to which a return belongs to a robot of unknown outline, m: the housing of a scanner and
a leg's radius."""


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


@njit(cache=True)
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
