"""Change detection for clouds: check that the place of a detection was ever seen empty.

Parts of a wall appear and disappear with the viewpoint, and seem to walk along it. A real person
walks where the floor was seen before. A cloud is stored as a virtual planar scan of its upright
columns and its floor, so that clouds and scans share one memory, see ``past_scans``.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, read_only, replace
from cohelm.kernels import CACHED, callee
from cohelm.messages import Scan
from cohelm.perception.api import ColumnHeights, Detections
from cohelm.perception.change_detection.past_scans import (
    ChangeDetectionParameters,
    PastScans,
    PastState,
    compare_places,
    past_beams,
    remember_scan,
)

_BEAMS = 720
"""Beams of a virtual scan (0.5° each)."""
_UPRIGHT = 0.5
"""Height from which a column is stored, m: legs and low objects do not hide the floor behind."""
_UNPROVEN = -0.9
"""Log-odds of arrival of a detection whose place was never seen empty: nothing has walked there,
but it may be a standing person. The tracker punishes less than −1 only (``static_penalty``)."""
_ARRIVED = 0.5
"""Log-odds of arrival of a detection at a place where mostly floor was seen before."""
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
    """Add ``arrival_log_odds`` to ``found``.

    They are above 0 where the place was seen empty before, and below 0 where it never was.
    """
    d = len(found.position)
    # Only columns that a virtual scan would store can be compared with earlier ones.
    compared = np.flatnonzero(found.detection_of_return >= 0)
    if found.heights is not None:
        compared = compared[found.heights.high[compared] > _UPRIGHT]
    detection = found.detection_of_return[compared]
    width = 2.0 * found.ellipse[found.cluster_of_return[compared], 2]
    places = read_only(found.points[compared])
    looks, empties = np.zeros(d), np.zeros(d)
    for each in past if len(compared) else ():
        if not _DEFAULTS.min_age <= found.time - each.scan.time <= _DEFAULTS.max_age:
            continue
        was = compare_places(places, width, past_beams(each), (_DEFAULTS.margin, _GROWTH))
        occupied = np.bincount(detection[was == PastState.OCCUPIED], minlength=d)
        empty = np.bincount(detection[was == PastState.FREE], minlength=d)
        looks += occupied + empty > 0
        empties += (empty > 0) & (occupied <= _MAX_OCCUPIED * (occupied + empty))
    arrived = np.where(empties >= _MOSTLY * looks, _ARRIVED, 0.0)
    return replace(found, arrival_log_odds=np.where(empties >= _MIN_LOOKS, arrived, _UNPROVEN))


def remember_cloud(past: PastScans, found: Detections) -> PastScans:
    """Store the virtual scan of a cloud."""
    if found.heights is None or not len(found.points):
        return past
    # The virtual sensor stands at ``found.origin`` and faces along the map's x axis.
    return remember_scan(past, _virtual_scan(found, found.heights), np.array([*found.origin, 0.0]))


def _virtual_scan(found: Detections, heights: ColumnHeights) -> Scan:
    """Planar scan of the upright columns and the floor of a cloud."""
    upright = heights.high > _UPRIGHT
    floor = heights.floor.astype(float) - found.origin
    return Scan(
        time=found.time,
        mount=np.zeros(3),
        angle_min=-math.pi,
        angle_increment=2.0 * math.pi / _BEAMS,
        range_max=100.0,
        ranges=_ranges(found.points[upright] - found.origin, floor),
    )


@njit(**CACHED)
def _ranges(upright: Floats, floor: Floats) -> Floats:
    """Nearest column in each direction, else the farthest floor, else ``_NO_VIEW``; m.

    A direction between two of the sensor's gets the shorter range of its neighbours.
    """
    near, far = np.full(_BEAMS, np.inf), np.zeros(_BEAMS)
    for i in range(upright.shape[0]):
        k = _beam_index(upright[i, 0], upright[i, 1])
        near[k] = min(near[k], math.hypot(upright[i, 0], upright[i, 1]))
    for i in range(floor.shape[0]):
        k = _beam_index(floor[i, 0], floor[i, 1])
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


@callee()
def _beam_index(x: float, y: float) -> int:
    """Index of the beam nearest to a direction."""
    return math.floor((math.atan2(y, x) + math.pi) * _BEAMS / (2.0 * math.pi) + 0.5) % _BEAMS
