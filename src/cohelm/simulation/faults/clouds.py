"""Faults of LiDARs and depth cameras: frozen, covered, tilted on their mount, mounted too high."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np
from scipy.spatial.transform import Rotation

from cohelm.arrays import replace
from cohelm.messages import Observation, PointCloud
from cohelm.simulation.faults.api import FaultInput, FaultKind


def _each(o: Observation, change: Callable[[PointCloud], PointCloud]) -> Observation:
    return replace(o, clouds=tuple(map(change, o.clouds))) if o.clouds else o


def _frozen(o: Observation, at: FaultInput) -> Observation:
    """Repeat the last cloud of each sensor before the onset with new stamps."""

    def held(cloud: PointCloud) -> PointCloud:
        same = [c for c in at.held.clouds if np.array_equal(c.mount, cloud.mount, equal_nan=True)]
        return replace(cloud, points=same[-1].points) if same else cloud

    return _each(o, held)


def _covered(o: Observation, at: FaultInput) -> Observation:
    """Let every return come from what covers the lens; at 0 there is none."""

    def points(cloud: PointCloud) -> PointCloud:
        away = np.linalg.norm(cloud.points, axis=1, keepdims=True)
        short = cloud.points / away * np.float32(at.size)
        return replace(cloud, points=short if at.size > 0.0 else np.full_like(short, np.nan))

    return _each(o, points)


def _tilted(o: Observation, at: FaultInput) -> Observation:
    """Pitch the sensors, down > 0, about the robot's y axis; the stated mounts stay."""

    def points(cloud: PointCloud) -> PointCloud:
        R_RS = Rotation.from_euler("xyz", cloud.mount[3:])
        turned = R_RS.inv() * Rotation.from_euler("y", -at.size, degrees=True) * R_RS
        return replace(cloud, points=turned.apply(cloud.points).astype(np.float32))

    return _each(o, points)


def _raised(o: Observation, at: FaultInput) -> Observation:
    """State mounts that are too low."""
    return _each(
        o, lambda cloud: replace(cloud, mount=cloud.mount - np.array([0, 0, at.size, 0, 0, 0]))
    )


CLOUDS: Mapping[str, FaultKind] = MappingProxyType(
    {
        "cloud_frozen": FaultKind(text="3-D sensors repeat one frame", effect=_frozen),
        "cloud_covered": FaultKind(
            text="3-D sensors see only what covers them; at 0 nothing",
            effect=_covered,
            unit="m",
            typical=0.05,
            bounds=(0.0, 1.0),
            intensities=(0.0, 0.05),
        ),
        "cloud_tilted": FaultKind(
            text="3-D sensors tilted on their mounts, down > 0",
            effect=_tilted,
            unit="°",
            typical=8.0,
            bounds=(-45.0, 45.0),
            intensities=(-8.0, -3.0, 3.0, 8.0),
        ),
        "cloud_raised": FaultKind(
            text="3-D sensors mounted higher than stated",
            effect=_raised,
            unit="m",
            typical=0.02,
            bounds=(-0.5, 0.5),
            intensities=(-0.02, 0.02),
        ),
    }
)
