"""Faults of the localiser."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import replace
from cohelm.geometry import transform
from cohelm.messages import Observation
from cohelm.simulation.faults.api import POSITIVE, FaultInput, FaultKind


def _silent(o: Observation, at: FaultInput) -> Observation:
    last = at.last
    return o if last is None else replace(o, pose=last.pose, pose_time=last.pose_time)


def _frozen(o: Observation, at: FaultInput) -> Observation:
    return replace(o, pose=at.held.pose)


def _nan(o: Observation, _: FaultInput) -> Observation:
    return replace(o, pose=np.full(3, np.nan))


def _jump(o: Observation, at: FaultInput) -> Observation:
    """Report a pose that is too far to the chair's left."""
    return _moved_left(o, at.size)


def _drift(o: Observation, at: FaultInput) -> Observation:
    return _moved_left(o, at.size * at.since)


def _turn_drift(o: Observation, at: FaultInput) -> Observation:
    return replace(o, pose=o.pose + np.array([0.0, 0.0, np.radians(at.size) * at.since]))


def _moved_left(o: Observation, by: float) -> Observation:
    point = transform(o.pose, np.array([0.0, by]))
    return replace(o, pose=np.array([*point, o.pose[2]]))


def _overconfident(o: Observation, at: FaultInput) -> Observation:
    """Wander about the true pose while the stated covariance stays small."""
    wave = 2.0 * np.pi * at.since / 6.0
    return replace(_moved_left(o, at.size * np.sin(wave)), pose_covariance=np.eye(3) * 1e-6)


POSE: Mapping[str, FaultKind] = MappingProxyType(
    {
        "pose_silent": FaultKind(text="localiser sends nothing", effect=_silent),
        "pose_frozen": FaultKind(text="localiser repeats one pose with new stamps", effect=_frozen),
        "pose_nan": FaultKind(text="localiser sends NaN", effect=_nan),
        "pose_jump": FaultKind(
            text="pose jumps sideways",
            effect=_jump,
            unit="m",
            bounds=POSITIVE,
            intensities=(0.3, 0.5, 2.0),
        ),
        "pose_drift": FaultKind(
            text="pose drifts sideways",
            effect=_drift,
            unit="m/s",
            typical=0.05,
            intensities=(0.01, 0.05, 0.1),
        ),
        "pose_turn_drift": FaultKind(
            text="heading drifts",
            effect=_turn_drift,
            unit="°/s",
            typical=2.0,
            intensities=(0.5, 2.0, 5.0),
        ),
        "pose_overconfident": FaultKind(
            text="pose wanders with a small stated covariance",
            effect=_overconfident,
            unit="m",
            typical=0.5,
            bounds=POSITIVE,
            intensities=(0.2, 0.5),
        ),
        "kidnapped": FaultKind(
            text="chair carried elsewhere, localiser not told",
            unit="m",
            typical=2.0,
            bounds=(0.05, 50.0),
            intensities=(0.5, 1.0, 2.0, 5.0),
        ),
    }
)
