"""Weights that are given for speed and for turning, as one for each input of a motion model."""

from __future__ import annotations

import functools

import numpy as np

from cohelm.arrays import Floats, read_only
from cohelm.robots import Kinematics


@functools.lru_cache(maxsize=64)
def per_input(
    kinematics: Kinematics, speed: float, turn: float, times: float = 1.0, over: float = 1.0
) -> Floats:
    """(m,): ``speed`` for inputs that move the robot over the floor, ``turn`` for the others.

    Both multiplied by ``times``, divided by ``over``.
    """
    moving = kinematics.translating
    each = np.array([speed] * moving + [turn] * (kinematics.inputs - moving))
    return read_only(each * times / over)
