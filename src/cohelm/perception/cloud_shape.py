"""How probable it is that something of a certain shape is a person."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.perception.cloud_bodies import (
    BOTTOM,
    FILLED,
    HEAD,
    HIDDEN,
    MEAN_X,
    MEAN_Y,
    RETURNS,
    SHEER,
    TOP,
    WIDTH,
)


def log_odds(look: Floats, beside: Floats, height: float, view: Floats, spacing: float) -> Floats:
    """ln(p / (1 − p)) that each of s segments is a person, from its shape alone; (s,).

    A sum of independent evidence, each piece bounded; assumed. What is out of the sensor's view or
    hidden says nothing.

    Args:
        look: (s, FIELDS), see ``looks``.
        beside: (s,) share of its columns that lie beside another thing's.
        height: of the sensor, m.
        view: (lowest, highest) slope at which it sees.
        spacing: angle between azimuths, rad.
    """
    away = np.hypot(look[:, MEAN_X], look[:, MEAN_Y])
    top, width = look[:, TOP], look[:, WIDTH] + spacing * away
    above = height + view[1] * away - top > 0.15
    below = height + view[0] * away < 0.2
    hidden = look[:, HIDDEN] > 0.0
    odds = np.where(above, 0.5 - 5.0 * np.clip(1.4 - top, 0.0, 0.6), 0.0)
    odds -= 12.0 * np.clip(top - 2.0, 0.0, 0.4)
    odds += _bump(width, 0.22, 0.7, 1.0, 10.0, 3.0) * np.where(hidden & (width < 0.4), 0.2, 1.0)
    head = look[:, HEAD] + 0.5 * spacing * away
    seen_head = above & (top > 1.1)
    odds += np.where(seen_head, np.clip(6.0 * (0.42 - head), -1.5, 1.5), 0.0)
    sheer = look[:, SHEER]
    odds += np.where(np.isnan(sheer) | ~below, 0.0, np.clip(5.0 * (0.75 - sheer), -1.0, 1.0))
    gaps = 1.0 - look[:, FILLED]
    odds -= np.where(look[:, RETURNS] > 30.0, 3.0 * gaps, 0.0)
    odds -= np.where(below & ~hidden, 3.0 * np.clip(look[:, BOTTOM] - 0.7, 0.0, 0.7), 0.0)
    odds -= 4.0 * beside
    few = np.minimum(look[:, RETURNS] / 12.0, 1.0)
    return np.where(odds > 0.0, few * odds, odds)


def _bump(  # two sides of one curve
    x: Floats, low: float, high: float, most: float, steepness: float, least: float
) -> Floats:
    """``most`` between low and high, falling by ``steepness`` a metre beyond, to −``least``."""
    beyond = np.maximum(np.maximum(low - x, x - high), 0.0)
    return np.maximum(most - steepness * beyond, -least)
