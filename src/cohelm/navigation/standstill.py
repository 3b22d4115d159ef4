"""Standstill by odometry."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats

_SPEED, _TURN_RATE = 0.05, 0.1
"""Odometry below this is noise or standstill, m/s and rad/s."""


def is_standing_still(twist: Floats) -> bool:
    """Check that a measured twist (3,) is that of a chair at rest."""
    speed, turn_rate = float(np.hypot(*twist[:2])), abs(float(twist[2]))
    return speed < _SPEED and turn_rate < _TURN_RATE
