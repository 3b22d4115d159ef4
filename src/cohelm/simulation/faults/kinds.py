"""All kinds of faults by name.

Those of time (a clock that steps, a navigator that is late) and of the wheel odometry stand here.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import replace
from cohelm.messages import Observation
from cohelm.simulation.faults.api import POSITIVE, FaultInput, FaultKind
from cohelm.simulation.faults.clouds import CLOUDS
from cohelm.simulation.faults.drive import DRIVE
from cohelm.simulation.faults.people import PEOPLE
from cohelm.simulation.faults.pose import POSE
from cohelm.simulation.faults.rider import RIDER
from cohelm.simulation.faults.scan_timing import SCAN_TIMING
from cohelm.simulation.faults.scan_values import SCAN_VALUES


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


FAULT_KINDS: Mapping[str, FaultKind] = MappingProxyType(
    {
        **SCAN_VALUES,
        **SCAN_TIMING,
        **CLOUDS,
        **POSE,
        **TWIST,
        **DRIVE,
        **RIDER,
        **PEOPLE,
        **CLOCK,
    }
)
"""Name → kind, sensors first."""
