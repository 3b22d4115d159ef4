"""View in the direction of travel: the widest part of it that no scanner sees."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.health.map_fit import MISSING, UNUSABLE
from cohelm.health.sweeps import ScannerState

BINS = 120
"""Directions about the robot, 3° each."""


def widest_gap(
    scanners: Iterable[tuple[ScannerState, Floats]],
    travel: float,
    half_angle: float,
    *,
    trust_map: bool,
) -> float:
    """Width of the widest unseen gap in the sector of travel, rad.

    Directions that no scanner covers by design do not count: the gap is a loss. A beam that finds
    nothing where the map has a wall sees nothing, if the map is trusted.

    Args:
        scanners: last sweep and mount (3,) of each.
        travel: direction of travel in the robot's frame, rad.
        half_angle: half the sector, rad.
        trust_map: compare with the map.
    """
    seen, covered = np.zeros(BINS, dtype=np.bool_), np.zeros(BINS, dtype=np.bool_)
    for state, mount in scanners:
        lost = state.fit.beams == UNUSABLE
        if trust_map:
            lost |= state.fit.beams == MISSING
        angle = (state.beams.angle + mount[2]) % (2.0 * math.pi)
        index = (angle / (2.0 * math.pi) * BINS).astype(np.int64) % BINS
        covered[index] = True
        seen[index[~lost]] = True
    blind = covered & ~seen
    if not blind.any():
        return 0.0
    directions = (np.arange(BINS) + 0.5) * 2.0 * math.pi / BINS
    apart = np.abs((directions - travel + math.pi) % (2.0 * math.pi) - math.pi)
    return _longest_run(blind & (apart <= half_angle)) * 2.0 * math.pi / BINS


def _longest_run(mask: Booleans) -> int:
    """Length of the longest run of a circular mask; a single seen bin does not interrupt it."""
    closed = mask | (np.roll(mask, 1) & np.roll(mask, -1))
    if closed.all():
        return len(closed)
    start = int(np.argmin(closed))
    best = run = 0
    for each in np.roll(closed, -start):
        run = run + 1 if each else 0
        best = max(best, run)
    return best
