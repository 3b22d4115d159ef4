"""Fault injection between world and navigator."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Literal

import numpy as np
from pydantic import Field

from cohelm.config import Model
from cohelm.messages import Observation

_ROUNDING = 1e-9


class Fault(Model):
    """One fault, active from ``at`` for ``duration``."""

    kind: Literal[
        "scan_silent",
        "pose_silent",
        "twist_silent",
        "rider_silent",
        "scan_nan",
        "pose_nan",
        "twist_nan",
        "rider_nan",
        "pose_jump",
        "late",
        "clock_backwards",
    ]
    """``silent``: no new messages; ``nan``: invalid numbers. ``scan`` stands for planar scanners,
    LiDARs and depth cameras together."""
    at: float = Field(ge=0.0)
    """s."""
    duration: float = Field(1.0, gt=0.0)
    """s."""
    magnitude: float = Field(1.0, ge=0.0)
    """Size of a jump (m, to the chair's left), of the lateness or of the clock's step back (s)."""

    def active(self, time: float) -> bool:
        """Check that the fault is active at ``time``, s."""
        return self.at - _ROUNDING <= time < self.at + self.duration - _ROUNDING


def with_faults(
    observation: Observation, faults: tuple[Fault, ...], last: Observation | None
) -> Observation:
    """Apply the faults that are active at the time of the observation.

    Args:
        observation: without faults.
        faults: applied in order.
        last: previous observation, whose values a silent sender repeats; None at first, when every
            sender has sent once.
    """
    now = observation.time
    for fault in faults:
        if fault.active(now):
            observation = _EFFECTS[fault.kind](observation, fault, last)
    return observation


_Effect = Callable[[Observation, Fault, Observation | None], Observation]


def _pose_silent(o: Observation, _: Fault, last: Observation | None) -> Observation:
    return o if last is None else replace(o, pose=last.pose, pose_time=last.pose_time)


def _twist_silent(o: Observation, _: Fault, last: Observation | None) -> Observation:
    return o if last is None else replace(o, twist=last.twist, twist_time=last.twist_time)


def _scan_nan(o: Observation) -> Observation:
    return replace(
        o,
        scans=tuple(replace(s, ranges=np.full_like(s.ranges, np.nan)) for s in o.scans),
        clouds=tuple(replace(c, points=np.full_like(c.points, np.nan)) for c in o.clouds),
    )


def _rider_nan(o: Observation) -> Observation:
    if o.rider is None:
        return o
    return replace(o, rider=replace(o.rider, deflection=np.full(2, np.nan)))


def _pose_jump(o: Observation, fault: Fault, _: Observation | None) -> Observation:
    left = np.array([-np.sin(o.pose[2]), np.cos(o.pose[2]), 0.0])
    return replace(o, pose=o.pose + fault.magnitude * left)


def _clock_backwards(o: Observation, fault: Fault, _: Observation | None) -> Observation:
    by = fault.magnitude
    rider = None if o.rider is None else replace(o.rider, heartbeat=o.rider.heartbeat - by)
    return replace(
        o,
        time=o.time - by,
        pose_time=o.pose_time - by,
        twist_time=o.twist_time - by,
        scans=tuple(replace(s, time=s.time - by) for s in o.scans),
        clouds=tuple(replace(c, time=c.time - by) for c in o.clouds),
        rider=rider,
    )


_EFFECTS: Mapping[str, _Effect] = MappingProxyType(
    {
        "scan_silent": lambda o, fault, last: replace(o, scans=(), clouds=()),
        "pose_silent": _pose_silent,
        "twist_silent": _twist_silent,
        "rider_silent": lambda o, fault, last: o if last is None else replace(o, rider=last.rider),
        "scan_nan": lambda o, fault, last: _scan_nan(o),
        "pose_nan": lambda o, fault, last: replace(o, pose=np.full(3, np.nan)),
        "twist_nan": lambda o, fault, last: replace(o, twist=np.full(3, np.nan)),
        "rider_nan": lambda o, fault, last: _rider_nan(o),
        "pose_jump": _pose_jump,
        "late": lambda o, fault, last: replace(o, late=fault.magnitude),
        "clock_backwards": _clock_backwards,
    }
)
