"""Change detection for clouds: check that the place of a detection was ever seen empty.

Parts of a wall appear and disappear with the viewpoint, and seem to walk along it. A real person
walks where the floor was seen before. A cloud is stored as a planar scan of its upright columns,
see ``past_scans``.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.messages import Scan
from cohelm.perception.api import Detections
from cohelm.perception.change_detection.past_scans import (
    FREE,
    OCCUPIED,
    ChangeDetectionParameters,
    PastScans,
    beams_of,
    compare_places,
    remember_scan,
)

_BEAMS = 720
"""Beams of the stored scan (0.5° each)."""
_UPRIGHT = 0.5
"""Height from which a column is stored, m: legs and low objects do not hide the floor behind."""
_UNPROVEN = -0.9
"""Log-odds of motion of a detection whose place was never seen empty: nothing has walked there, but
it may be a standing person."""
_ARRIVED = 0.5
"""Log-odds of motion of a detection at a place where mostly floor was seen before."""
_MAX_OCCUPIED, _MIN_LOOKS, _MOSTLY = 0.35, 2, 0.6
"""Largest occupied share of an empty place; number of scans that must show it empty; share of all
scans that makes it mostly empty."""
_GROWTH, _CERTAIN_SHARE = 0.02, 0.94
"""Growth with range of the margin of one place, m/m (a localisation error of 1°); and share of the
distance to the farthest floor that is certainly empty: depth cameras are inaccurate beyond."""
_NO_VIEW = 1e-3
"""Range of directions without returns, m: a camera did not look there, and a laser's beam may have
been lost."""
_DEFAULTS = ChangeDetectionParameters()


def detect_cloud_changes(found: Detections, past: PastScans) -> Detections:
    """Add ``moved`` to ``found``: above 0 where the place was empty, below 0 where it never was."""
    d = len(found.position)
    mine = np.flatnonzero(found.owner >= 0)
    if found.heights is not None:
        mine = mine[found.heights.high[mine] > _UPRIGHT]
    owner = found.owner[mine]
    width = 2.0 * found.ellipse[found.cluster[mine], 2]
    margin = np.array([_DEFAULTS.margin, _GROWTH])
    looks, empties = np.zeros(d), np.zeros(d)
    for each in past if len(mine) else ():
        if not _DEFAULTS.min_age <= found.time - each.scan.time <= _DEFAULTS.max_age:
            continue
        was = compare_places(found.points[mine], width, beams_of(each), margin)
        occupied = np.bincount(owner[was == OCCUPIED], minlength=d)
        empty = np.bincount(owner[was == FREE], minlength=d)
        looks += occupied + empty > 0
        empties += (empty > 0) & (occupied <= _MAX_OCCUPIED * (occupied + empty))
    moved = np.where(empties >= _MOSTLY * looks, _ARRIVED, 0.0)
    return replace(found, moved=np.where(empties >= _MIN_LOOKS, moved, _UNPROVEN))


def remember_cloud(past: PastScans, found: Detections) -> PastScans:
    """Store the upright columns and the floor of a cloud as a planar scan."""
    if found.heights is None or not len(found.points):
        return past
    upright = found.heights.high > _UPRIGHT
    floor = found.heights.floor.astype(float) - found.origin
    scan = Scan(
        time=found.time,
        mount=np.zeros(3),
        angle_min=-math.pi,
        angle_increment=2.0 * math.pi / _BEAMS,
        range_max=100.0,
        ranges=_ranges(found.points[upright] - found.origin, floor),
    )
    return remember_scan(past, scan, np.array([*found.origin, 0.0]))


@njit(cache=True)
def _ranges(upright: Floats, floor: Floats) -> Floats:
    """Nearest column in each direction, else the farthest floor, else ``_NO_VIEW``; m.

    A direction between two of the sensor's gets the shorter range of its neighbours.
    """
    near, far = np.full(_BEAMS, np.inf), np.zeros(_BEAMS)
    for i in range(upright.shape[0]):
        k = _beam(upright[i, 0], upright[i, 1])
        near[k] = min(near[k], math.hypot(upright[i, 0], upright[i, 1]))
    for i in range(floor.shape[0]):
        k = _beam(floor[i, 0], floor[i, 1])
        far[k] = max(far[k], math.hypot(floor[i, 0], floor[i, 1]))
    for k in range(_BEAMS):
        if near[k] == np.inf and far[k] > 0.0:
            near[k] = _CERTAIN_SHARE * far[k]
    out = near.copy()
    for k in range(_BEAMS):
        if near[k] == np.inf:
            beside = min(near[k - 1], near[(k + 1) % _BEAMS])
            out[k] = beside if beside < np.inf else _NO_VIEW
    return out


@njit(cache=True)
def _beam(x: float, y: float) -> int:
    """Index of the beam nearest to a direction."""
    return math.floor((math.atan2(y, x) + math.pi) * _BEAMS / (2.0 * math.pi) + 0.5) % _BEAMS
