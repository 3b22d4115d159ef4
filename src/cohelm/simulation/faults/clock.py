"""Faults of time: a clock that steps, a navigator that is late."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from cohelm.messages import Observation
from cohelm.simulation.faults.api import POSITIVE, FaultInput, FaultKind


def _late(o: Observation, at: FaultInput) -> Observation:
    return replace(o, late=at.size)


def _backwards(o: Observation, at: FaultInput) -> Observation:
    return _stepped(o, -at.size)


def _forwards(o: Observation, at: FaultInput) -> Observation:
    """Step the navigator's clock alone; its senders keep theirs."""
    return replace(o, time=o.time + at.size)


def _stepped(o: Observation, by: float) -> Observation:
    """Step all clocks together."""
    rider = None if o.rider is None else replace(o.rider, heartbeat=o.rider.heartbeat + by)
    return replace(
        o,
        time=o.time + by,
        pose_time=o.pose_time + by,
        twist_time=o.twist_time + by,
        scans=tuple(replace(s, time=s.time + by) for s in o.scans),
        clouds=tuple(replace(c, time=c.time + by) for c in o.clouds),
        rider=rider,
    )


CLOCK: Mapping[str, FaultKind] = MappingProxyType(
    {
        "late": FaultKind(
            text="navigator late", effect=_late, unit="s", bounds=POSITIVE, intensities=(0.2, 1.0)
        ),
        "clock_backwards": FaultKind(
            text="all clocks step back",
            effect=_backwards,
            unit="s",
            bounds=POSITIVE,
            intensities=(0.1, 1.0),
        ),
        "clock_forwards": FaultKind(
            text="the navigator's clock steps forward",
            effect=_forwards,
            unit="s",
            bounds=POSITIVE,
            intensities=(0.1, 1.0),
        ),
    }
)
