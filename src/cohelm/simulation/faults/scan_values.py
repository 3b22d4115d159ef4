"""Faults of the ranges of planar scanners: stuck, blind, constant, disturbed."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

import numpy as np

from cohelm.arrays import Booleans, Floats, replace
from cohelm.messages import Observation, Scan
from cohelm.simulation.faults.api import SHARE, FaultInput, FaultKind

_STRIPES = 24
"""Sectors of the horizon that are glass or sunlight or neither."""


def each_scan(o: Observation, change: Callable[[Scan], Scan]) -> Observation:
    """Observation with every scan changed."""
    return replace(o, scans=tuple(change(scan) for scan in o.scans)) if o.scans else o


def _with_ranges(o: Observation, ranges: Callable[[Scan], Floats]) -> Observation:
    return each_scan(o, lambda scan: replace(scan, ranges=ranges(scan)))


def bearings(scan: Scan) -> Floats:
    """Directions of the beams in the robot's frame, (b,), rad, within ±π."""
    angles = scan.mount[2] + scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    return np.asarray((angles + np.pi) % (2.0 * np.pi) - np.pi)


def _frozen(o: Observation, at: FaultInput) -> Observation:
    """Repeat the ranges of the onset with new stamps."""

    def held(scan: Scan) -> Floats:
        same = [s for s in at.held_scans if np.array_equal(s.mount, scan.mount)]
        return same[-1].ranges if same else scan.ranges

    return _with_ranges(o, held)


def _constant(o: Observation, at: FaultInput) -> Observation:
    return _with_ranges(o, lambda scan: np.full_like(scan.ranges, at.size))


def _nan(o: Observation, _: FaultInput) -> Observation:
    return replace(
        _with_ranges(o, lambda scan: np.full_like(scan.ranges, np.nan)),
        clouds=tuple(replace(c, points=np.full_like(c.points, np.nan)) for c in o.clouds),
    )


def _sector(reading: float) -> Callable[[Observation, FaultInput], Observation]:
    def effect(o: Observation, at: FaultInput) -> Observation:
        half = np.radians(at.size)
        return _with_ranges(
            o, lambda scan: np.where(np.abs(bearings(scan)) <= half, reading, scan.ranges)
        )

    return effect


def _free_beams(o: Observation, at: FaultInput) -> Observation:
    """Let the same random beams read +inf all the time."""

    def ranges(scan: Scan) -> Floats:
        lost = at.pattern.random(len(scan.ranges)) < at.size
        return np.where(lost, np.inf, scan.ranges)

    return _with_ranges(o, ranges)


def _scaled(o: Observation, at: FaultInput) -> Observation:
    return _with_ranges(o, lambda scan: at.size * scan.ranges)


def _spots(o: Observation, at: FaultInput) -> Observation:
    """Cross-talk of another scanner: random beams read too short, others in every sweep."""

    def ranges(scan: Scan) -> Floats:
        hit = at.rng.random(len(scan.ranges)) < at.size
        farthest = np.where(np.isfinite(scan.ranges), scan.ranges, scan.range_max)
        return np.where(hit, at.rng.uniform(0.15, 1.0, len(scan.ranges)) * farthest, scan.ranges)

    return _with_ranges(o, ranges)


def _multipath(o: Observation, at: FaultInput) -> Observation:
    """Mirror images behind polished surfaces: a share of the horizon reads too far."""

    def ranges(scan: Scan) -> Floats:
        far = np.minimum(1.7 * scan.ranges, scan.range_max)
        return np.where(_in_stripes(scan, at), far, scan.ranges)

    return _with_ranges(o, ranges)


def _glass(o: Observation, at: FaultInput) -> Observation:
    """Panes in a share of the horizon: nine beams in ten pass without a return."""

    def ranges(scan: Scan) -> Floats:
        passes = _in_stripes(scan, at) & (at.rng.random(len(scan.ranges)) < 0.9)
        return np.where(passes, np.inf, scan.ranges)

    return _with_ranges(o, ranges)


def _sunlight(o: Observation, at: FaultInput) -> Observation:
    """Sunlight in a share of the horizon: seven beams in ten drop out, the others are noisy."""

    def ranges(scan: Scan) -> Floats:
        lit, n = _in_stripes(scan, at), len(scan.ranges)
        noisy = np.clip(scan.ranges + 0.3 * at.rng.standard_normal(n), 0.0, scan.range_max)
        dazzled = np.where(at.rng.random(n) < 0.7, np.nan, noisy)
        return np.where(lit, dazzled, scan.ranges)

    return _with_ranges(o, ranges)


def _in_stripes(scan: Scan, at: FaultInput) -> Booleans:
    """Mask of the beams (b,) towards random sectors that are fixed in the map."""
    chosen = at.pattern.permutation(_STRIPES) < at.size * _STRIPES
    # The sound heading: panes stay where they are, whatever a faulty localiser says.
    world = (bearings(scan) + at.recent[-1].pose[2]) % (2.0 * np.pi)
    index = (world / (2.0 * np.pi) * _STRIPES).astype(int) % _STRIPES
    return np.asarray(chosen[index])


SCAN_VALUES: Mapping[str, FaultKind] = MappingProxyType(
    {
        "scan_frozen": FaultKind(text="scanner repeats one sweep with new stamps", effect=_frozen),
        "scan_constant": FaultKind(
            text="every beam reads the same range",
            effect=_constant,
            unit="m",
            typical=5.0,
            intensities=(0.0, -1.0, 0.3, 5.0, 1e9),
        ),
        "scan_nan": FaultKind(text="every beam drops out", effect=_nan),
        "scan_blind": FaultKind(
            text="sector about the front blind, as NaN",
            effect=_sector(np.nan),
            unit="° to each side",
            typical=81.0,
            bounds=(0.0, 180.0),
            intensities=(20.0, 45.0, 81.0),
        ),
        "scan_free_sector": FaultKind(
            text="sector about the front reads free, as +inf",
            effect=_sector(np.inf),
            unit="° to each side",
            typical=90.0,
            bounds=(0.0, 180.0),
            intensities=(20.0, 45.0, 90.0, 180.0),
        ),
        "scan_free_beams": FaultKind(
            text="random beams read free, as +inf",
            effect=_free_beams,
            unit="share",
            typical=0.5,
            bounds=SHARE,
            intensities=(0.25, 0.5, 0.75),
        ),
        "scan_scaled": FaultKind(
            text="ranges scaled",
            effect=_scaled,
            unit="factor",
            typical=1.2,
            bounds=(0.0, 10.0),
            intensities=(0.8, 1.1, 1.3),
        ),
        "scan_spots": FaultKind(
            text="cross-talk: random beams too short",
            effect=_spots,
            unit="share",
            typical=0.05,
            bounds=SHARE,
            intensities=(0.02, 0.1, 0.3),
        ),
        "scan_multipath": FaultKind(
            text="multipath: a share of the horizon too far",
            effect=_multipath,
            unit="share",
            typical=0.25,
            bounds=SHARE,
            intensities=(0.1, 0.25, 0.5),
        ),
        "scan_glass": FaultKind(
            text="glass: a share of the horizon without return",
            effect=_glass,
            unit="share",
            typical=0.25,
            bounds=SHARE,
            intensities=(0.1, 0.25, 0.5),
        ),
        "scan_sunlight": FaultKind(
            text="sunlight: a share of the horizon dazzled",
            effect=_sunlight,
            unit="share",
            typical=0.25,
            bounds=SHARE,
            intensities=(0.1, 0.25, 0.5),
        ),
    }
)
