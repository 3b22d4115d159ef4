"""Pose registered with the map: moved by the offset at which the last sweep fits the walls.

Localisers are wrong by centimetres, which is as much as a chair has left beside a bench or in a
door. A sweep knows better where the walls are: many beams end on them, each with a noise of a
centimetre. The monitor fits each sweep to the map anyway, see ``health.map_fit``; small offsets
correct the pose, large ones make it doubtful.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.geometry import compose, inverse
from cohelm.health.monitor import HealthState
from cohelm.health.parameters import HealthParameters
from cohelm.health.sweeps import ScannerState
from cohelm.messages import Observation
from cohelm.robots import Robot


def registered(
    observation: Observation, state: HealthState, robot: Robot, parameters: HealthParameters
) -> Observation:
    """Observation with the pose that fits the walls of the map.

    Args:
        observation: with the reported pose.
        state: of the monitor after this observation, with the fits of the last sweeps.
        robot: mounts of its scanners.
        parameters: bounds of the correction.
    """
    p = parameters
    found = [
        (each.fit.hit, mount.pose, _bounded(each.fit.offset, p))
        for each, mount in zip(state.scanners, robot.lasers, strict=False)
        if each is not None and _reaches_walls(each, p)
    ]
    if not found:
        return observation
    _, mount, offset = max(found, key=lambda each: each[0])
    sensor = compose(observation.pose, mount)
    return replace(observation, pose=compose(sensor + offset, inverse(mount)))


def _reaches_walls(state: ScannerState, p: HealthParameters) -> bool:
    """Check that enough beams end on walls of the map to tell where they are."""
    return state.fit.hit >= p.registration_hits * max(len(state.beams.angle), 1)


def _bounded(offset: Floats, p: HealthParameters) -> Floats:
    """Offset (3,) of a fit, no larger than a localiser is wrong while it is not lost."""
    shift = math.hypot(offset[0], offset[1])
    share = min(p.registration_shift / shift, 1.0) if shift > 0.0 else 1.0
    turn = min(max(offset[2], -p.registration_turn), p.registration_turn)
    return np.array([share * offset[0], share * offset[1], turn])
