"""What people do who get no further: RVO2's examples disturb them at random, and so do we.

Nothing is remembered from step to step: who is stuck shows in the velocity that ORCA leaves them.
"""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.simulation.crowds.waypoints import current_targets, last_passed
from cohelm.simulation.sensors.raycast import in_sight
from cohelm.simulation.walls import Walls

_GOLDEN = 0.6180339887498949
"""The golden ratio's fraction: its multiples never come into step."""


def share_stuck(wanted: Floats, velocity: Floats) -> Floats:
    """How stuck people are, (n,): 0 from a third of the wanted progress on, 1 without any.

    Args:
        wanted: (n, 2) preferred velocities, m/s.
        velocity: (n, 2) the ones possible, m/s.
    """
    speed2 = np.sum(wanted * wanted, axis=1)
    progress = np.sum(wanted * velocity, axis=1) / np.maximum(speed2, 1e-9)
    return np.where(speed2 > 0.0, np.clip(1.0 - 3.0 * progress, 0.0, 1.0), 0.0)


def sway(time: float, noise: Floats) -> Floats:
    """A slow to and fro (n,) within ±1.5, out of step from person to person, with noise in it.

    Of two who block each other one then gives way for a while, and no symmetry lasts.
    """
    phase = np.arange(len(noise)) * _GOLDEN
    wave = np.sin(2.0 * np.pi * (time * (0.12 + 0.06 * (phase % 1.0)) + phase))
    return np.clip(wave + 0.3 * noise, -1.5, 1.5)


def turned(velocity: Floats, angle: Floats) -> Floats:
    """Velocities (n, 2), each turned by its angle (n,)."""
    cos, sin = np.cos(angle), np.sin(angle)
    x, y = velocity[:, 0], velocity[:, 1]
    return np.stack([cos * x - sin * y, sin * x + cos * y], axis=1)


def lost_sight(
    position: Floats, waypoints: Floats, target: Integers, loop: Booleans, walls: Walls
) -> Floats:
    """The way-point (n, 2) to go back to for those pushed out of sight of their target, else NaN.

    One who has passed a door's way-point may be pressed back through the door, and would then walk
    against the wall for ever.
    """
    cells = (walls.solid, 2.0 * walls.half, walls.X_MG)
    ahead = current_targets(waypoints, target)
    behind = last_passed(waypoints, target, loop)
    lost = np.isfinite(behind[:, 0])
    lost[lost] &= ~in_sight(*cells, position[lost], ahead[lost])
    lost[lost] &= in_sight(*cells, position[lost], behind[lost])
    return np.where(lost[:, None], behind, np.nan)


def go_back(wanted: Floats, position: Floats, back: Floats, stuck: Floats, speed: Floats) -> Floats:
    """``wanted`` (n, 2), but to ``back`` (n, 2) at ``speed`` (n,) for the stuck who have one."""
    offset = back - position
    distance = np.hypot(offset[:, 0], offset[:, 1])
    returns = (stuck > 0.0) & (distance > 1e-6)
    rate = np.where(returns, speed / np.where(returns, distance, 1.0), 0.0)
    return np.where(returns[:, None], rate[:, None] * offset, wanted)
