"""Checks of LiDARs and depth cameras: frames that repeat, and covered lenses."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.health.parameters import HealthParameters
from cohelm.messages import Observation, PointCloud, Reason

_LENS = 0.2
"""Distance below which returns come from what covers the lens, m."""
_COVERED = 0.9
"""Share of such returns from which the lens is covered."""
_MOVED = (0.02, 0.02)
"""Motion from which clouds are compared, m and rad: at rest, quantised ones may be equal."""
_ROWS = 2000
"""Rows that are compared; more cost time."""
_FEW = 20
"""Fewer returns than these tell nothing."""
_FRESH = 0.5
"""Age up to which the last cloud counts, s; later the gate finds it missing, or the mount moved."""


class CloudState(NamedTuple):
    """State of one sensor."""

    cloud: PointCloud
    """The last one."""
    earlier: PointCloud
    """The one with which later ones are compared, from before the chair moved."""
    pose: Floats
    """Reported pose (3,) of the chair at the earlier one."""
    symptom: Reason | None


def update_clouds(
    memory: tuple[CloudState, ...], observation: Observation, p: HealthParameters
) -> tuple[CloudState, ...]:
    """Check the new clouds of each sensor, which its mount tells from the others."""
    if not observation.clouds:
        return memory
    out = [each for each in memory if observation.time - each.cloud.time <= _FRESH]
    for cloud in observation.clouds:
        same = [i for i, each in enumerate(out) if _same(each.cloud.mount, cloud.mount)]
        if not same:
            out.append(CloudState(cloud, cloud, observation.pose, _symptom(cloud, None, p)))
        elif cloud.time > out[same[0]].cloud.time:
            out[same[0]] = _next(out[same[0]], cloud, observation.pose, p)
    return tuple(out)


def _next(known: CloudState, cloud: PointCloud, pose: Floats, p: HealthParameters) -> CloudState:
    """State after a new cloud."""
    dx, dy, turn = (pose - known.pose).tolist()
    if math.hypot(dx, dy) < _MOVED[0] and abs(math.remainder(turn, math.tau)) < _MOVED[1]:
        # A frozen sensor stays so until it shows something else.
        last = known.cloud if known.symptom is Reason.SCAN_FROZEN else None
        return known._replace(cloud=cloud, symptom=_symptom(cloud, last, p))
    return CloudState(cloud, cloud, pose, _symptom(cloud, known.earlier, p))


def cloud_symptoms(states: Iterable[CloudState], time: float) -> list[Reason]:
    """Symptoms of the sensors whose last cloud is fresh; ``time`` in s."""
    return [
        each.symptom
        for each in states
        if each.symptom is not None and time - each.cloud.time <= _FRESH
    ]


def _same(a: Floats, b: Floats) -> bool:
    return bool(np.array_equal(a, b, equal_nan=True))


def _symptom(cloud: PointCloud, earlier: PointCloud | None, p: HealthParameters) -> Reason | None:
    """Reason to doubt a cloud; the gate stops for one without any return."""
    stride = max(len(cloud.points) // _ROWS, 1)
    points = cloud.points[::stride]
    seen = np.isfinite(points).all(axis=1)
    count = np.count_nonzero(seen)
    if count < _FEW:
        return None
    with np.errstate(over="ignore", invalid="ignore"):
        near = np.einsum("ij,ij->i", points, points) < _LENS**2
    if np.count_nonzero(near & seen) >= _COVERED * count:
        return Reason.SCAN_BLIND
    if earlier is not None and earlier.points.shape == cloud.points.shape:
        equal = (earlier.points[::stride] == points).all(axis=1) & seen
        if np.count_nonzero(equal) >= p.repeated_share * count:
            return Reason.SCAN_FROZEN
    return None
