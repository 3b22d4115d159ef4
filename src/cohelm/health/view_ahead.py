"""View in the direction of travel: the widest part of it that no scanner sees."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.health.map_fit import MISSING, UNUSABLE
from cohelm.health.sweeps import ScannerState

_MIN_MISSING = 4
"""Beams of a run of free ones that must miss a wall for the whole run not to be believed."""
_MISSING_SHARE = 0.15
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
            lost |= _disbelieved(state)
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


def _disbelieved(state: ScannerState) -> Booleans:
    """Mask of the free beams that see nothing.

    A run of free beams that misses mapped walls in a part of it is not believed in any part.
    """
    free: Booleans = np.isposinf(state.beams.range)
    missing: Booleans = state.fit.beams == MISSING
    if free.all():
        return np.asarray(free & missing.any())
    if missing.sum() < _MIN_MISSING:
        return missing
    start = int(np.argmin(free))
    rolled, missed = np.roll(free, -start), np.roll(missing, -start)
    run = np.cumsum(~rolled)  # beams of one run of free ones share a number
    count = np.bincount(run[rolled], minlength=run[-1] + 1)
    wrong = np.bincount(run[rolled & missed], minlength=run[-1] + 1)
    whole = (wrong >= _MIN_MISSING) & (wrong >= _MISSING_SHARE * count)
    return np.asarray(missing | np.roll(rolled & whole[run], start))


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
