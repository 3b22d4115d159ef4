"""What may go wrong between the world and the navigator, injected at will."""

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
        "clock_back",
    ]
    """What fails and how: ``silent`` sends no more, ``nan`` sends what is not a number; ``scan``
    stands for all that looks out, planar scanners, LiDARs and depth cameras."""
    at: float = Field(ge=0.0)
    """s."""
    duration: float = Field(1.0, gt=0.0)
    """s."""
    magnitude: float = Field(1.0, ge=0.0)
    """Of a jump (m, to the chair's left), of lateness or of the clock's step back (s)."""

    def active(self, time: float) -> bool:
        """Whether it is there at ``time``, s."""
        return self.at - _ROUNDING <= time < self.at + self.duration - _ROUNDING


def with_faults(
    observation: Observation, faults: tuple[Fault, ...], last: Observation | None
) -> Observation:
    """The observation as it arrives with the faults that are active at its time.

    Args:
        observation: the sound one.
        faults: applied in order.
        last: what arrived before; a silent sender leaves its last word standing. None at the
            beginning: whoever is silent from then on has spoken once.
    """
    now = observation.time
    for fault in faults:
        if fault.active(now):
            observation = _EFFECTS[fault.kind](observation, fault, last)
    return observation


_Effect = Callable[[Observation, Fault, Observation | None], Observation]


def _scan_silent(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return replace(o, scans=(), clouds=())


def _pose_silent(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return o if last is None else replace(o, pose=last.pose, pose_time=last.pose_time)


def _twist_silent(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return o if last is None else replace(o, twist=last.twist, twist_time=last.twist_time)


def _rider_silent(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return o if last is None else replace(o, rider=last.rider)


def _scan_nan(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return replace(
        o,
        scans=tuple(replace(s, ranges=np.full_like(s.ranges, np.nan)) for s in o.scans),
        clouds=tuple(replace(c, points=np.full_like(c.points, np.nan)) for c in o.clouds),
    )


def _pose_nan(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return replace(o, pose=np.full(3, np.nan))


def _twist_nan(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return replace(o, twist=np.full(3, np.nan))


def _rider_nan(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return (
        o if o.rider is None else replace(o, rider=replace(o.rider, deflection=np.full(2, np.nan)))
    )


def _pose_jump(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    left = np.array([-np.sin(o.pose[2]), np.cos(o.pose[2]), 0.0])
    return replace(o, pose=o.pose + fault.magnitude * left)


def _late(o: Observation, fault: Fault, last: Observation | None) -> Observation:
    return replace(o, late=fault.magnitude)


def _clock_back(o: Observation, fault: Fault, last: Observation | None) -> Observation:
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
        "scan_silent": _scan_silent,
        "pose_silent": _pose_silent,
        "twist_silent": _twist_silent,
        "rider_silent": _rider_silent,
        "scan_nan": _scan_nan,
        "pose_nan": _pose_nan,
        "twist_nan": _twist_nan,
        "rider_nan": _rider_nan,
        "pose_jump": _pose_jump,
        "late": _late,
        "clock_back": _clock_back,
    }
)
