"""Continuity of sweeps: a view that breaks off, after which less of it is on the map.

A chair that is carried, or whose localiser lies, sees another place from one moment to the next.
The map alone may explain that place nearly as well: corridors and rooms resemble each other, and
what stands before a wall may be people. Both together tell: the sweep does not continue the
earlier one, and from then on fewer beams end on mapped walls. People who pass hide walls slowly,
and a map that is wrong does not break the view.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from cohelm.health.map_fit import MapFit
from cohelm.health.parameters import HealthParameters

_MIN_BEAMS = 30
"""Beams with an expectation without which a sweep tells nothing about walls."""
_WATCHED = 1.0
"""Time after a break within which fewer beams on walls are due to it, s; also the time for which as
many as before must end on walls until it is forgotten."""


class Continuity(NamedTuple):
    """Usual shares, and the last break; NaN: not known yet."""

    inliers: float = math.nan
    """Usual share of a sweep that continues the earlier one."""
    on_walls: float = math.nan
    """Usual share of the beams that end on mapped walls."""
    broken: float = -math.inf
    """Time of the last sweep that broke off, or showed less of the map after one that did, s."""
    fall: float = 0.0
    """Fall of the share on walls below what was usual before the break; 0 without a break."""


def update_continuity(
    before: Continuity,
    inliers: float,
    fit: MapFit,
    elapsed: float,
    time: float,
    p: HealthParameters,
) -> Continuity:
    """Add a sweep; the usual shares stay as they were before a break while it is watched.

    Args:
        before: continuity before.
        inliers: share of the sweep that continues an earlier one; NaN: not comparable.
        fit: of the sweep to the map.
        elapsed: time since the last sweep, s.
        time: of the sweep, s.
        p: parameters.
    """
    expected = fit.hit + fit.short + fit.through + fit.missing
    on_walls = fit.hit / expected if expected else 0.0
    breaks = before.inliers - inliers >= p.break_drop
    if breaks or time - before.broken <= _WATCHED:
        known = expected >= _MIN_BEAMS and not math.isnan(before.on_walls)
        fall = before.on_walls - on_walls if known else 0.0
        broken = time if breaks or fall >= p.break_fall else before.broken
        return before._replace(broken=broken, fall=fall)
    share = 1.0 - math.exp(-elapsed / p.smoothing)
    return Continuity(
        _towards(before.inliers, inliers, share), _towards(before.on_walls, on_walls, share)
    )


def _towards(usual: float, now: float, share: float) -> float:
    """Mean that forgets; what is not known changes nothing."""
    if math.isnan(now):
        return usual
    return now if math.isnan(usual) else usual + share * (now - usual)
