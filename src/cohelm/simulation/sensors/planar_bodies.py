"""Outlines of people and what they push, as a planar scanner at leg height sees them.

Every outline is a set of discs; a rod, a wheel or the side of a trolley is a row of small ones.
Measures are typical of adults and common products, rounded, and assumed where no source is named:
manual wheelchairs are 0.65 m wide with wheels of 0.6 m (ISO 7176-5), rollators 0.6 m wide,
supermarket trolleys 0.55 m wide. An outline stays within the disc of radius ``RADIUS``.
"""

from __future__ import annotations

import math
from enum import IntEnum
from functools import lru_cache
from itertools import pairwise

import numpy as np

from cohelm.arrays import Floats, read_only
from cohelm.simulation.sensors.human_bodies import HumanBodies


class BodyKind(IntEnum):
    """Outline of a pedestrian in a planar scan."""

    DISC = 0
    """One disc, as of a scanner at the height of the hips."""
    LEGS = 1
    """Two legs of an adult."""
    CHILD = 2
    """Two legs of a child."""
    SEATED = 3
    """A person on a chair with four legs."""
    WALKER = 4
    """A person behind a rollator."""
    WHEELCHAIR = 5
    """A person in a manual wheelchair."""
    TROLLEY = 6
    """A person who pushes a trolley."""


RADIUS = {
    BodyKind.DISC: 0.25,
    BodyKind.LEGS: 0.25,
    BodyKind.CHILD: 0.18,
    BodyKind.SEATED: 0.4,
    BodyKind.WALKER: 0.45,
    BodyKind.WHEELCHAIR: 0.5,
    BodyKind.TROLLEY: 0.6,
}
"""Radius of the disc that contains each body, m."""
STATURES = {
    BodyKind.CHILD: (1.0, 1.35),
    BodyKind.SEATED: (1.2, 1.35),
    BodyKind.WHEELCHAIR: (1.2, 1.4),
}
"""Range of heights of kinds that are lower than ``people.stature``, m."""
SPEEDS = {
    BodyKind.SEATED: 0.0,
    BodyKind.WALKER: 0.7,
    BodyKind.WHEELCHAIR: 1.0,
    BodyKind.CHILD: 1.0,
    BodyKind.TROLLEY: 0.9,
}
"""Highest preferred speed, m/s; seated people stay where they are."""
_LEG_RADIUS = {BodyKind.CHILD: 0.04}
_ADULT_LEG = 0.065
_HALF_STANCE = {BodyKind.CHILD: 0.06}
_ADULT_STANCE = 0.1
_ROD = 0.012
_SPACING = 0.03


def planar_discs(bodies: HumanBodies) -> Floats:
    """Discs (k, 3) x, y, radius of all bodies in the map frame, m."""
    if bodies.kind is None or not bodies.kind.any():
        return np.column_stack([bodies.position, bodies.radius])
    swing, out = bodies.swing, []
    for i, kind in enumerate(bodies.kind.tolist()):
        outline = outline_of(BodyKind(kind), float(swing[i]), float(bodies.radius[i]))
        c, s = math.cos(bodies.heading[i]), math.sin(bodies.heading[i])
        x, y, r = outline.T
        at = bodies.position[i]
        out.append(np.column_stack([at[0] + c * x - s * y, at[1] + s * x + c * y, r]))
    return np.concatenate(out)


def outline_of(kind: BodyKind, swing: float, radius: float) -> Floats:
    """Discs (k, 3) x, y, radius of one body that faces along x, m.

    Args:
        kind: outline.
        swing: distance of the left foot ahead of the hip and of the right one behind it, m.
        radius: of the disc that stands for ``BodyKind.DISC``, m.
    """
    if kind is BodyKind.DISC:
        return np.array([[0.0, 0.0, radius]])
    back = {BodyKind.WALKER: -0.22, BodyKind.TROLLEY: -0.42}.get(kind, 0.0)
    if kind in {BodyKind.SEATED, BodyKind.WHEELCHAIR}:
        legs = np.array([[0.3, 0.1, 0.06], [0.3, -0.1, 0.06]])
    else:
        leg = _LEG_RADIUS.get(kind, _ADULT_LEG)
        apart = _HALF_STANCE.get(kind, _ADULT_STANCE)
        most = RADIUS[kind] - leg
        reach = math.sqrt(max((most - abs(back)) ** 2 - apart**2, 0.0)) if back else 0.0
        reach = reach or math.sqrt(most**2 - apart**2)
        step = min(max(swing, -reach), reach)
        legs = np.array([[back + step, apart, leg], [back - step, -apart, leg]])
    return np.concatenate([legs, _aid(kind)])


@lru_cache(maxsize=16)
def _aid(kind: BodyKind) -> Floats:
    """Discs (k, 3) of what carries or is pushed by a person, m."""
    if kind is BodyKind.SEATED:
        corners = [(0.2, 0.2), (0.2, -0.2), (-0.2, 0.2), (-0.2, -0.2)]
        return read_only(np.array([(x, y, 0.015) for x, y in corners]))
    if kind is BodyKind.WALKER:
        sides = [rod((-0.1, 0.28 * side), (0.3, 0.24 * side)) for side in (1.0, -1.0)]
        return read_only(np.concatenate([*sides, rod((0.3, 0.1), (0.3, -0.1))]))
    if kind is BodyKind.WHEELCHAIR:
        sides = [rod((-0.35, 0.3 * side), (0.25, 0.3 * side)) for side in (1.0, -1.0)]
        return read_only(np.concatenate([*sides, rod((-0.15, 0.2), (-0.15, -0.2))]))
    if kind is BodyKind.TROLLEY:
        ends = [(-0.1, 0.26), (0.5, 0.2), (0.5, -0.2), (-0.1, -0.26), (-0.1, 0.26)]
        return read_only(np.concatenate([rod(a, b) for a, b in pairwise(ends)]))
    return read_only(np.empty((0, 3)))


def rod(start: tuple[float, float], end: tuple[float, float]) -> Floats:
    """Return a row of discs (k, 3) from ``start`` to ``end``, m."""
    count = max(math.ceil(math.dist(start, end) / _SPACING), 1) + 1
    line = np.linspace(start, end, count)
    return np.column_stack([line, np.full(count, _ROD)])
