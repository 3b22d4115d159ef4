"""Weights that are given for speed and for turning, as one for each input of a motion model."""

from __future__ import annotations

import functools

import numpy as np

from cohelm.arrays import Floats, read_only
from cohelm.robots import Kinematics


@functools.lru_cache(maxsize=64)
def per_input(kinematics: Kinematics, speed: float, turn: float) -> Floats:
    """(m,): ``speed`` for inputs that move the robot over the floor, ``turn`` for the others."""
    over = kinematics.translating
    return read_only(np.array([speed] * over + [turn] * (kinematics.inputs - over)))
