"""How probable it is that something of a certain shape is a person."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.perception.cloud_bodies import (
    BOTTOM,
    DEPTH,
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
from cohelm.perception.cloud_points import Gathered

_BODY = 0.5
"""What is nearer than this to the end of a sensor's reach may go on behind it, m."""


def log_odds(look: Floats, beside: Floats, seen: Gathered) -> Floats:
    """ln(p / (1 − p)) that each of s segments is a person, from its shape alone; (s,).

    A sum of independent evidence, each piece bounded; assumed. What is out of the sensor's view or
    hidden, or lies between its rings, says nothing; what the end of the reach cuts may be a piece
    of anything, and nothing speaks for a person.

    Args:
        look: (s, FIELDS), see ``looks``.
        beside: (s,) share of its columns that lie beside another thing's.
        seen: the sensors' places, views and resolution.
    """
    away = np.hypot(look[:, MEAN_X], look[:, MEAN_Y])
    places = look[:, [MEAN_X, MEAN_Y]]
    lowest, highest = seen.in_view(places)
    above = highest - look[:, TOP] > 0.15
    below = lowest < 0.3
    hidden = look[:, HIDDEN] > 0.0
    aside, upright = seen.spacing * away, seen.ring * away
    sharp = np.clip(1.5 - 5.0 * upright, 0.0, 1.0)
    odds = _height(look[:, TOP], upright, above)
    odds += _width(look[:, WIDTH] + aside, hidden)
    odds += sharp * _head((look[:, HEAD] + aside) / (look[:, WIDTH] + aside), above)
    sheer = look[:, SHEER]
    odds += np.where(np.isnan(sheer) | ~below, 0.0, np.clip(10.0 * (0.5 - sheer), -2.0, 1.5))
    odds -= 3.0 * sharp * (1.0 - look[:, FILLED])
    odds -= np.where(below & ~hidden, 3.0 * np.clip(look[:, BOTTOM] - 0.7, 0.0, 0.7), 0.0)
    odds -= 4.0 * np.clip(look[:, DEPTH] - 0.45, 0.0, 0.5)
    odds -= 4.0 * beside
    few = np.minimum(look[:, RETURNS] / 25.0, 1.0)
    return np.where(odds > 0.0, np.where(seen.room(places) < _BODY, 0.0, few * odds), odds)


def _height(top: Floats, gap: Floats, seen: Booleans) -> Floats:
    """From the height (s,): a grown-up's is likely, a child's less, above 2.0 m it is nobody."""
    odds = np.where(seen, 0.4 - 5.0 * np.clip(1.4 - top - gap, 0.0, 0.6), 0.0)
    return odds - 12.0 * np.clip(top - 2.0, 0.0, 0.4)


def _width(width: Floats, hidden: Booleans) -> Floats:
    """From the breadth (s,) at the torso; half a person may be hidden, and says less."""
    thin = np.clip(0.22 - width, 0.0, 0.2)
    wide = np.clip(width - 0.7, 0.0, 0.4)
    return np.where(hidden & (width < 0.35), 0.0, 0.6 - 20.0 * thin - 10.0 * wide)


def _head(share: Floats, seen: Booleans) -> Floats:
    """From the head's share (s,) of the breadth: narrower is a head or a neck, as wide is none.

    Where the view ends below the top, it ends higher on what is farther: hardly a word on heads.
    """
    odds = np.clip(8.0 * (0.8 - share), -1.5, 1.5)
    return np.where(seen, odds, np.clip(odds, 0.0, 0.5))
