"""Faults of the rider's device."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Floats, replace
from cohelm.messages import Observation
from cohelm.simulation.faults.api import FaultInput, FaultKind


def _silent(o: Observation, at: FaultInput) -> Observation:
    return o if at.last is None else replace(o, rider=at.last.rider)


def _deflected(o: Observation, deflection: Floats) -> Observation:
    if o.rider is None:
        return o
    return replace(o, rider=replace(o.rider, deflection=np.clip(deflection, -1.0, 1.0)))


def _nan(o: Observation, _: FaultInput) -> Observation:
    return _deflected(o, np.full(2, np.nan))


def _stuck(o: Observation, at: FaultInput) -> Observation:
    return _deflected(o, np.array([at.size, 0.0]))


def _repeated(o: Observation, at: FaultInput) -> Observation:
    """Repeat the last event with new stamps."""
    held = at.held.rider
    return o if held is None else _deflected(o, held.deflection)


def _off_centre(o: Observation, at: FaultInput) -> Observation:
    """Let the centre drift to the left within two seconds."""
    if o.rider is None:
        return o
    shift = np.array([0.0, at.size * min(at.since / 2.0, 1.0)])
    return _deflected(o, o.rider.deflection + shift)


RIDER: Mapping[str, FaultKind] = MappingProxyType(
    {
        "rider_silent": FaultKind(text="device sends nothing", effect=_silent),
        "rider_nan": FaultKind(text="device sends NaN", effect=_nan),
        "rider_stuck": FaultKind(
            text="stick stuck forward",
            effect=_stuck,
            unit="deflection",
            bounds=(-1.0, 1.0),
            intensities=(0.3, 1.0),
        ),
        "rider_repeated": FaultKind(
            text="device repeats its last event with new stamps", effect=_repeated
        ),
        "rider_off_centre": FaultKind(
            text="centre of the stick drifts to the left",
            effect=_off_centre,
            unit="deflection",
            typical=0.2,
            bounds=(-1.0, 1.0),
            intensities=(0.1, 0.3),
        ),
    }
)
