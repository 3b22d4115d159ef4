"""Faults of the wheel odometry."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from cohelm.messages import Observation
from cohelm.simulation.faults.api import FaultInput, FaultKind


def _silent(o: Observation, at: FaultInput) -> Observation:
    last = at.last
    return o if last is None else replace(o, twist=last.twist, twist_time=last.twist_time)


def _frozen(o: Observation, at: FaultInput) -> Observation:
    return replace(o, twist=at.held.twist)


def _nan(o: Observation, _: FaultInput) -> Observation:
    return replace(o, twist=np.full(3, np.nan))


def _zero(o: Observation, _: FaultInput) -> Observation:
    return replace(o, twist=np.zeros(3))


def _scaled(o: Observation, at: FaultInput) -> Observation:
    return replace(o, twist=at.size * o.twist)


def _slip(o: Observation, at: FaultInput) -> Observation:
    """Measure wheels that turn faster than the chair moves; see ``drive.true_twist``."""
    return replace(o, twist=o.twist / max(1.0 - at.size, 0.05))


TWIST: Mapping[str, FaultKind] = MappingProxyType(
    {
        "twist_silent": FaultKind(text="odometry sends nothing", effect=_silent),
        "twist_frozen": FaultKind(
            text="odometry repeats one value with new stamps", effect=_frozen
        ),
        "twist_nan": FaultKind(text="odometry sends NaN", effect=_nan),
        "twist_zero": FaultKind(text="odometry reads zero", effect=_zero),
        "twist_scaled": FaultKind(
            text="odometry scaled, as by a wrong wheel size, or its sign flipped",
            effect=_scaled,
            unit="factor",
            typical=-1.0,
            bounds=(-5.0, 5.0),
            intensities=(0.5, 0.8, 1.5, -1.0),
        ),
        "wheel_slip": FaultKind(
            text="wheels slip",
            effect=_slip,
            unit="share",
            typical=0.5,
            bounds=(0.0, 0.95),
            intensities=(0.2, 0.5, 0.9),
        ),
    }
)
