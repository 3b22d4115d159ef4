"""Faults of the time and the mount of planar scanners."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import replace
from cohelm.messages import Observation, Scan
from cohelm.simulation.faults.api import FaultInput, FaultKind
from cohelm.simulation.faults.scan_values import each_scan


def _silent(o: Observation, _: FaultInput) -> Observation:
    return replace(o, scans=(), clouds=())


def _delayed(o: Observation, at: FaultInput) -> Observation:
    """Deliver scans later, with the stamps of their sweeps."""
    return replace(o, scans=_scans_before(at))


def _restamped(o: Observation, at: FaultInput) -> Observation:
    """Deliver scans later, stamped on arrival."""
    return replace(o, scans=tuple(replace(s, time=o.time) for s in _scans_before(at)))


def _out_of_order(o: Observation, at: FaultInput) -> Observation:
    """Deliver the scans of two sweeps at once, the newer one first."""
    everything = [scan for each in at.recent for scan in each.scans]
    if not o.scans or round(o.scans[-1].time / 0.2, 6) % 1.0 > 1e-3:
        return replace(o, scans=())
    return replace(o, scans=tuple(reversed(everything[-2 * len(o.scans) :])))


def _scans_before(at: FaultInput) -> tuple[Scan, ...]:
    """Scans of the observation made ``magnitude`` ago."""
    due = at.time - at.size
    then = [each for each in at.recent if abs(each.time - due) < 0.02]
    return then[-1].scans if then else ()


def _mirrored(o: Observation, _: FaultInput) -> Observation:
    """Mount the scanner upside down: left and right change places."""
    return each_scan(o, lambda scan: replace(scan, ranges=scan.ranges[::-1].copy()))


def _rotated(o: Observation, at: FaultInput) -> Observation:
    """Turn the scanner on its mount; the stated mount stays."""

    def turned(scan: Scan) -> Scan:
        by = round(np.radians(at.size) / scan.angle_increment)
        return replace(scan, ranges=np.roll(scan.ranges, by))

    return each_scan(o, turned)


SCAN_TIMING: Mapping[str, FaultKind] = MappingProxyType(
    {
        "scan_silent": FaultKind(text="scanner sends nothing", effect=_silent),
        "scan_delayed": FaultKind(
            text="scans delayed, with true stamps",
            effect=_delayed,
            unit="s",
            typical=0.3,
            bounds=(0.0, 1.9),
            intensities=(0.2, 0.5),
        ),
        "scan_restamped": FaultKind(
            text="scans delayed and stamped on arrival",
            effect=_restamped,
            unit="s",
            typical=0.4,
            bounds=(0.0, 1.9),
            intensities=(0.2, 0.4, 0.8),
        ),
        "scan_out_of_order": FaultKind(text="scans out of order", effect=_out_of_order),
        "scan_mirrored": FaultKind(text="scanner mounted upside down", effect=_mirrored),
        "scan_rotated": FaultKind(
            text="scanner turned on its mount",
            effect=_rotated,
            unit="°",
            typical=20.0,
            bounds=(-180.0, 180.0),
            intensities=(5.0, 10.0, 20.0, 90.0),
        ),
    }
)
