"""Which way is free: what a careful driver makes of what lies ahead."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.simulation.api import RiderView

_MOMENTS = np.arange(0.0, 3.1, 0.5)
"""At which people are looked for where their walk leads them, s."""
_AHEAD = 1.0
"""Who is no farther than this beyond where the chair would be at that moment is in the way, m."""
_BESIDE = 0.05
"""Who is no farther ahead than this is beside the chair and in nobody's way, m."""

_LOSS = 2.0 * math.pi
"""What a way that is not free at all counts beside one that leads off the wanted direction, rad."""


def free_way(
    view: RiderView, bearing: float, *, width: float, far: float, speed: float
) -> tuple[float, float]:
    """The direction nearest to a wanted one in which the way is free.

    Args:
        view: what is seen.
        bearing: the wanted direction, in the chair's frame, rad.
        width: of the way that is needed, m.
        far: how far it should be free, m; nothing beyond counts.
        speed: at which the chair would go, m/s.

    Returns:
        The direction, rad, and how far it is free, m, at most ``far``. Where no way is free as far
        as that, the one that loses least.
    """
    aside = np.where(np.abs(view.bearings) <= math.pi / 2.0, view.bearings, np.nan)
    ways = np.append(bearing, aside[np.isfinite(aside)])
    free = np.minimum(
        _free_of(_things(view), ways, width),
        _free_of_people(view, ways, width, speed),
    ).clip(max=far)
    off = np.abs(np.remainder(ways - bearing + math.pi, 2.0 * math.pi) - math.pi)
    best = int(np.argmin(off + _LOSS * (far - free) / far))
    return float(ways[best]), float(free[best])


def _things(view: RiderView) -> Floats:
    """(k, 2) where the glances meet something, m."""
    met = np.isfinite(view.free)
    bearings = view.bearings[met]
    points: Floats = view.free[met, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    return points


def _free_of(points: Floats, ways: Floats, width: float) -> Floats:
    """How far each way (w,) goes before one of the points (k, 2) lies in it, (w,), m."""
    unit = np.column_stack([np.cos(ways), np.sin(ways)])
    along = unit @ points.T
    across = unit[:, :1] * points[:, 1] - unit[:, 1:] * points[:, 0]
    met = (along > _BESIDE) & (np.abs(across) < width / 2.0)
    free: Floats = np.where(met, along, np.inf).min(axis=1, initial=np.inf)
    return free


def _free_of_people(view: RiderView, ways: Floats, width: float, speed: float) -> Floats:
    """The same with people, who are to be where the chair would be at that moment; (w,), m."""
    free = np.full(len(ways), np.inf)
    unit = np.column_stack([np.cos(ways), np.sin(ways)])
    for moment in _MOMENTS:
        place = view.people[:, :2] + moment * view.people[:, 2:4]
        along = unit @ place.T
        across = unit[:, :1] * place[:, 1] - unit[:, 1:] * place[:, 0]
        body = view.people[:, 4]
        gone = speed * moment
        met = (along > _BESIDE) & (np.abs(across) < width / 2.0 + body)
        met &= along - body < gone + _AHEAD
        free = np.minimum(
            free, np.where(met, (along - body).clip(min=0.0), np.inf).min(axis=1, initial=np.inf)
        )
    return free
