"""Checks of LiDARs and depth cameras: frames that repeat, and covered lenses."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.health.parameters import HealthParameters
from cohelm.messages import Observation, PointCloud, Reason

_LENS = 0.2
"""Distance below which returns come from what covers the lens, m."""
_FEW = 20
"""Fewer returns than these tell nothing."""
_FRESH = 0.5
"""Age up to which the last cloud counts, s; later the gate finds it missing."""


class CloudState(NamedTuple):
    """Last cloud of a sensor, and what is wrong with it."""

    cloud: PointCloud
    symptom: Reason | None


def update_clouds(
    memory: tuple[CloudState, ...], observation: Observation, p: HealthParameters
) -> tuple[CloudState, ...]:
    """Check the new clouds of each sensor, which its mount tells from the others."""
    out = list(memory)
    for cloud in observation.clouds:
        known = [i for i, each in enumerate(out) if _same(each.cloud.mount, cloud.mount)]
        before = out[known[0]].cloud if known else None
        if before is not None and cloud.time <= before.time:
            continue
        state = CloudState(cloud, _symptom(cloud, before, p))
        if known:
            out[known[0]] = state
        else:
            out.append(state)
    return tuple(out)


def cloud_symptoms(states: Iterable[CloudState], time: float) -> list[Reason]:
    """Symptoms of the sensors whose last cloud is fresh; ``time`` in s."""
    return [
        each.symptom
        for each in states
        if each.symptom is not None and time - each.cloud.time <= _FRESH
    ]


def _same(a: Floats, b: Floats) -> bool:
    return bool(np.array_equal(a, b, equal_nan=True))


def _symptom(cloud: PointCloud, before: PointCloud | None, p: HealthParameters) -> Reason | None:
    """Reason to doubt a cloud; floor that returns nothing is no fault of the sensor."""
    seen = np.isfinite(cloud.points).all(axis=1)
    if not seen.any():
        return Reason.SCAN_PARTLY_BLIND
    if seen.sum() < _FEW:
        return None
    near = np.einsum("ij,ij->i", cloud.points, cloud.points) < _LENS**2
    if near.sum() >= p.repeated_share * seen.sum():
        return Reason.SCAN_BLIND
    if before is not None and before.points.shape == cloud.points.shape:
        equal = (before.points == cloud.points).all(axis=1)
        if equal.sum() >= p.repeated_share * seen.sum():
            return Reason.SCAN_FROZEN
    return None
