"""What a scan says of a place where nobody was found."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers

UNCLEAR = 0
"""The beams there end now here, now there."""
SEEN_THROUGH = 1
"""They pass."""
HIDDEN = 2
"""Something nearer stops them."""
FILLED = 3
"""They end there: something is in the place, whatever it was taken for."""
UNLOOKED = 4
"""No beam goes there."""


@njit(cache=True)
def sight(origin: Floats, points: Floats, through: Floats, discs: Floats) -> Integers:
    """How each disc (n, 3) of (x, y, radius) was seen from ``origin``.

    Beams towards the disc's inner half are asked, if they reach it. ``HIDDEN`` if at least half end
    before it, ``SEEN_THROUGH`` if every one of at least two ends 0.3 m or more behind it,
    ``FILLED`` if at least half end in it or within a hand's breadth, ``UNLOOKED`` if there is none,
    else ``UNCLEAR``.

    Args:
        origin: (2,) m.
        points: (p, 2) returns, m.
        through: (q, 2) ends of beams that met nothing, m.
        discs: (n, 3) m.
    """
    out = np.zeros(discs.shape[0], dtype=np.int64)
    beams = points.shape[0] + through.shape[0]
    ends = np.empty((beams, 3))
    for i in range(beams if discs.shape[0] else 0):
        end = points[i] if i < points.shape[0] else through[i - points.shape[0]]
        ends[i, 0], ends[i, 1] = end[0] - origin[0], end[1] - origin[1]
        ends[i, 2] = math.sqrt(ends[i, 0] ** 2 + ends[i, 1] ** 2)
    for t in range(discs.shape[0]):
        dx, dy = discs[t, 0] - origin[0], discs[t, 1] - origin[1]
        away, radius = math.hypot(dx, dy), discs[t, 2]
        if away < 1e-6:
            continue
        ux, uy = dx / away, dy / away
        slope = 0.5 * radius / away
        asked = before = within = behind = 0
        for i in range(beams):
            length = ends[i, 2]
            if abs(ends[i, 0] * uy - ends[i, 1] * ux) > slope * length:
                continue
            if ends[i, 0] * ux + ends[i, 1] * uy <= 0.0:
                continue
            if i >= points.shape[0] and length <= away + radius + 0.3:
                continue  # nothing was met as far as it reaches, and it does not reach there
            asked += 1
            before += length < away - radius - 0.1
            within += abs(length - away) <= radius + 0.1
            behind += length > away + radius + 0.3
        if asked == 0:
            out[t] = UNLOOKED
        elif 2 * before >= asked:
            out[t] = HIDDEN
        elif 2 * within >= asked:
            out[t] = FILLED
        elif asked >= 2 and behind == asked:
            out[t] = SEEN_THROUGH
    return out
