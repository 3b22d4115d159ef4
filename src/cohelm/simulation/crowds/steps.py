"""From one crowd to the next, where people may come and leave."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import wrap_angle
from cohelm.simulation.api import Crowd

_WALKING = 0.1
"""Speed above which a person turns to where they walk, m/s."""
_AWAY, _APART = 1e6, 10.0
"""Where who is not there is put, and how far from the next one, m."""


def went(before: Crowd, after: Crowd) -> Floats:
    """How far people (n, 2) got from one crowd to the next, m; 0 for who came or left."""
    there = before.there & after.there
    return np.where(there[:, None], after.position - before.position, 0.0)


def between(before: Crowd, after: Crowd, share: float) -> Floats:
    """Where people are (n, 2), a share of the way from one crowd to the next, m."""
    return before.position + share * went(before, after)


def far_away(count: int) -> Floats:
    """Places (count, 2) for who is not there: beyond every map, and apart from each other, m."""
    return np.column_stack([_AWAY + _APART * np.arange(count), np.full(count, _AWAY)])


def turned_towards(heading: Floats, velocity: Floats, dt: float, turn_time: float) -> Floats:
    """Headings (n,) after ``dt`` of turning to where people walk; who stands keeps theirs.

    Args:
        heading: (n,) before, rad.
        velocity: (n, 2), m/s.
        dt: s.
        turn_time: time constant, s.
    """
    walks: Booleans = np.hypot(velocity[:, 0], velocity[:, 1]) > _WALKING
    turn = wrap_angle(np.arctan2(velocity[:, 1], velocity[:, 0]) - heading)
    turned = heading + np.where(walks, turn * (1.0 - math.exp(-dt / turn_time)), 0.0)
    return np.asarray(wrap_angle(turned))
