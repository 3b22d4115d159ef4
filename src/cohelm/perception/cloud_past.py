"""Whether what a cloud shows can have walked to its place: was that place ever seen empty?

Pieces of a wall come and go with the point of view, and seem to walk along it. Who truly walks does
so where the floor was seen before. A cloud is remembered as a planar scan of what stands in it, see
``novelty``.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.messages import Scan
from cohelm.perception.api import Detections
from cohelm.perception.novelty import (
    EMPTY,
    FULL,
    NoveltyParameters,
    Past,
    remember,
    was_there,
)

_BEAMS = 720
"""Round the horizon (0.5° each)."""
_STANDS = 0.5
"""What reaches higher stands there, m: legs and low things are seen over."""
_UNPROVEN = -0.9
"""Log-odds of having moved of what stands where nobody was seen to be missing: it says that nothing
walked there, not that it is no person who stands."""
_CAME = 0.5
"""The same of what stands where the floor was seen mostly before."""
_MOSTLY, _LOOKS, _NEARLY = 0.35, 2, 0.6
"""A place is empty where at most this share of it is full; it takes so many looks to know, and this
share of all to call it mostly empty."""
_GROWTH, _SURELY = 0.02, 0.94
"""Growth with range of what counts as the same place, m/m (a localiser's error of 1°); and share of
the way to the farthest floor that was surely empty: depth cameras are in doubt of the rest."""
_UNSEEN = 1e-3
"""What is told of directions from which nothing came back, m: there the view ended at the sensor.
A camera did not look there, and a laser's beam may have been lost."""
_RULES = NoveltyParameters()


def with_place(seen: Detections, past: Past) -> Detections:
    """``seen`` with ``moved``: above 0 where the place was empty, below where it never was."""
    d = len(seen.position)
    mine = np.flatnonzero(seen.owner >= 0)
    if seen.heights is not None:
        mine = mine[seen.heights.high[mine] > _STANDS]
    owner = seen.owner[mine]
    width = 2.0 * seen.ellipse[seen.cluster[mine], 2]
    margin = np.array([_RULES.margin, _GROWTH])
    looks, empties = np.zeros(d), np.zeros(d)
    for glance in past if len(mine) else ():
        scan = glance.scan
        if not _RULES.youngest <= seen.time - scan.time <= _RULES.oldest:
            continue
        beams = np.array([scan.angle_min, scan.angle_increment, scan.range_max])
        was = was_there(seen.points[mine], width, scan.ranges, beams, glance.X_MS, margin)
        full = np.bincount(owner[was == FULL], minlength=d)
        empty = np.bincount(owner[was == EMPTY], minlength=d)
        looks += full + empty > 0
        empties += (empty > 0) & (full <= _MOSTLY * (full + empty))
    moved = np.where(empties >= _NEARLY * looks, _CAME, 0.0)
    return replace(seen, moved=np.where(empties >= _LOOKS, moved, _UNPROVEN))


def remember_place(past: Past, seen: Detections) -> Past:
    """``past`` with what stands in a cloud."""
    if seen.heights is None or not len(seen.points):
        return past
    stands = seen.heights.high > _STANDS
    free = seen.heights.floor.astype(float) - seen.origin
    scan = Scan(
        time=seen.time,
        mount=np.zeros(3),
        angle_min=-math.pi,
        angle_increment=2.0 * math.pi / _BEAMS,
        range_max=100.0,
        ranges=_ranges(seen.points[stands] - seen.origin, free),
    )
    return remember(past, scan, np.array([*seen.origin, 0.0]))


@njit(cache=True)
def _ranges(stands: Floats, floor: Floats) -> Floats:
    """The nearest thing in each direction, or else the farthest floor, or else ``_UNSEEN``; m.

    A direction between two of the sensor's is as free as the less free one beside it.
    """
    near, far = np.full(_BEAMS, np.inf), np.zeros(_BEAMS)
    for i in range(stands.shape[0]):
        k = _beam(stands[i, 0], stands[i, 1])
        near[k] = min(near[k], math.hypot(stands[i, 0], stands[i, 1]))
    for i in range(floor.shape[0]):
        k = _beam(floor[i, 0], floor[i, 1])
        far[k] = max(far[k], math.hypot(floor[i, 0], floor[i, 1]))
    for k in range(_BEAMS):
        if near[k] == np.inf and far[k] > 0.0:
            near[k] = _SURELY * far[k]
    out = near.copy()
    for k in range(_BEAMS):
        if near[k] == np.inf:
            beside = min(near[k - 1], near[(k + 1) % _BEAMS])
            out[k] = beside if beside < np.inf else _UNSEEN
    return out


@njit(cache=True)
def _beam(x: float, y: float) -> int:
    """The beam nearest to a direction."""
    return math.floor((math.atan2(y, x) + math.pi) * _BEAMS / (2.0 * math.pi) + 0.5) % _BEAMS
