"""Where to steer: what a driver who knows the size of the chair makes of what lies ahead.

Ways beside the wanted one are driven in thought, in several gears and by the hand's own law, with
the chair's whole footprint against what is seen and where people walk; the one that gets on best is
chosen. A dynamic window (Fox, Burgard and Thrun 1997) over ways instead of twists: what is driven
in thought can be an S, as through a gap beside the route.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Annotated, Booleans, Floats, Shape, value
from cohelm.geometry import arc_length, inverse, nearest_on_polyline, transform
from cohelm.simulation.api import RiderView
from cohelm.simulation.riders.rehearsal import (
    EASE,
    GEARS,
    SPACING,
    STEPS,
    TURNED,
    bearing,
    rehearsed,
)

_POINTS = 50
"""Of the wanted way that are looked at."""
_BESIDE = np.arange(-6, 7) * 0.2
"""How far to the left of the wanted way there are others, m …"""
_SHIFTS = (0.0, 0.1, 0.05, -0.05)
"""… by so much farther in turn, look by look, m …"""
_NUDGES = np.array([0.0, 0.03, -0.03])
"""… and by so much beside the one that is being driven, m."""

_KEEPS = 2.0
"""How far off a thing is remembered when it is out of sight, m."""
_FRESH = 2.0
"""For how long a thing is remembered that ought to be in sight and is not, s."""
_SAME = 0.07
"""What lies within this of something in sight is the same, m."""


@value
class Surroundings:
    """Things about the chair, in its frame: those in sight first, then those remembered."""

    points: Annotated[Floats, Shape("n 2")]
    """m."""
    time: Annotated[Floats, Shape("n")]
    """When each was seen, s."""


NOTHING = Surroundings(points=np.empty((0, 2)), time=np.empty(0))


@value
class Hand:
    """How the stick is held, and what the chair makes of it."""

    forward: float
    """Deflection on a straight way."""
    turning: float
    """Deflection aside for each radian, 1/rad."""
    lookahead: float
    """m."""
    full: Annotated[Floats, Shape("2")]
    """Speed and turn at full deflection, m/s and rad/s."""


@value
class Choice:
    """A way beside the wanted one, and how it is driven."""

    beside: float
    """How far to the left of the wanted way, m."""
    gear: int
    """Row of ``GEARS``."""


def seen(view: RiderView, before: Surroundings, step: Floats) -> Surroundings:
    """What is in sight now and what is remembered of what was.

    Args:
        view: what is seen.
        before: the surroundings at the last look.
        step: how the chair is felt to have moved since then, (3,).
    """
    met = np.isfinite(view.free)
    bearings = view.bearings[met]
    now = view.free[met, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    old = transform(inverse(step), before.points)
    field = float(np.abs(view.bearings).max(initial=0.0)) - 0.1
    kept = _remembered(now, old, view.time - before.time, field)
    return Surroundings(
        points=np.concatenate([now, old[kept]]),
        time=np.concatenate([np.full(len(now), view.time), before.time[kept]]),
    )


@njit(cache=True)
def _remembered(now: Floats, old: Floats, age: Floats, field: float) -> Booleans:
    """Which old points (n, 2) are still there, though not in sight."""
    kept = np.zeros(len(old), dtype=np.bool_)
    for i in range(len(old)):
        x, y = old[i]
        if x * x + y * y > _KEEPS * _KEEPS:
            continue
        if age[i] > _FRESH and abs(math.atan2(y, x)) < field:
            continue
        kept[i] = True
        for j in range(len(now)):
            if abs(now[j, 0] - x) < _SAME and abs(now[j, 1] - y) < _SAME:
                kept[i] = False
                break
    return kept


def wanted_way(view: RiderView) -> Floats:
    """What lies ahead of the wanted way, ``SPACING`` apart, in the chair's frame, (m, 4).

    Points and unit vectors to the way's left; at least one, and the last is where the way ends or
    is not looked at any more.
    """
    route = view.route if len(view.route) > 1 else np.array([view.pose[:2], view.goal])
    route = transform(inverse(view.pose), route)
    s = arc_length(route)
    at, _ = nearest_on_polyline(route, 0.0, 0.0)
    count = min(math.ceil((s[-1] - at) / SPACING) + 1, _POINTS)
    middle = np.minimum(at + SPACING * np.arange(count), s[-1])
    sought = np.concatenate([middle, middle - SPACING, middle + SPACING])
    x, y = np.interp(sought, s, route[:, 0]), np.interp(sought, s, route[:, 1])
    dx, dy = x[2 * count :] - x[count : 2 * count], y[2 * count :] - y[count : 2 * count]
    length = np.maximum(np.hypot(dx, dy), 1e-9)
    return np.column_stack([x[:count], y[:count], -dy / length, dx / length])


def best_way(
    view: RiderView,
    way: Floats,
    things: Surroundings,
    *,
    hand: Hand,
    outline: Floats,
    before: Choice | None,
    look: int,
) -> Choice | None:
    """The way that gets on best; None where there is none to drive.

    Args:
        view: what is seen.
        way: the wanted one, (m, 4); see ``wanted_way``.
        things: what is about.
        hand: how the stick is held.
        outline: of the chair, (k, 2), m.
        before: what was driven so far; of two ways as good the nearer one is taken.
        look: number of the look; other ways are looked at in the next one.
    """
    driven = before.beside if before is not None else 0.0
    beside = np.concatenate([[0.0], driven + _NUDGES, _BESIDE + _SHIFTS[look % len(_SHIFTS)]])
    box = np.concatenate([outline.min(axis=0), outline.max(axis=0)])
    far = hand.forward * hand.full[0] * STEPS * GEARS[0, 2] + np.abs(box).max() + EASE[0]
    held = np.array([hand.forward, hand.turning, hand.lookahead])
    near = things.points[np.hypot(*things.points.T) < far]
    gear, chosen = rehearsed(
        way, near, view.people, view.twist, box, held, hand.full, beside, driven
    )
    return Choice(beside=float(chosen), gear=int(gear)) if gear >= 0 else None


def steering(way: Floats, choice: Choice, lookahead: float) -> tuple[float, float]:
    """Where to steer for a choice (rad, to the left), and which share of the speed it is worth."""
    share, ahead, _, turns = GEARS[choice.gear]
    aside = float(bearing(way, np.zeros(3), 0, choice.beside, lookahead * ahead))
    return aside, float(share * (turns == 0.0 or abs(aside) <= TURNED))
