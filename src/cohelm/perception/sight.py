"""What a scan says of a place where nobody was found: seen through, hidden, or unclear."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

UNCLEAR = 0
SEEN_THROUGH = 1
HIDDEN = 2


@njit(cache=True)
def sight(origin: Floats, points: Floats, through: Floats, discs: Floats) -> Integers:
    """How each disc (n, 3) of (x, y, radius) was seen from ``origin``.

    Beams that meet the disc's inner half are asked: ``HIDDEN`` if at least half end before it,
    ``SEEN_THROUGH`` if every one of at least two ends 0.3 m or more behind it, else ``UNCLEAR``.

    Args:
        origin: (2,) m.
        points: (p, 2) returns, m.
        through: (q, 2) ends of beams that met nothing, m.
        discs: (n, 3) m.
    """
    out = np.zeros(discs.shape[0], dtype=np.int64)
    for t in range(discs.shape[0]):
        dx, dy = discs[t, 0] - origin[0], discs[t, 1] - origin[1]
        away, radius = math.hypot(dx, dy), discs[t, 2]
        if away < 1e-6:
            continue
        ux, uy = dx / away, dy / away
        beams = before = behind = 0
        for i in range(points.shape[0] + through.shape[0]):
            end = points[i] if i < points.shape[0] else through[i - points.shape[0]]
            ex, ey = end[0] - origin[0], end[1] - origin[1]
            along = ex * ux + ey * uy
            length = math.hypot(ex, ey)
            if along <= 0.0 or abs(ex * uy - ey * ux) * away > 0.5 * radius * length:
                continue
            beams += 1
            before += length < away - radius - 0.1
            behind += length > away + radius + 0.3
        if beams and 2 * before >= beams:
            out[t] = HIDDEN
        elif beams >= 2 and behind == beams:
            out[t] = SEEN_THROUGH
    return out
