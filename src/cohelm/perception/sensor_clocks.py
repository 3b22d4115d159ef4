"""Check of the sensor clocks, each against its own past."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.messages import Observation, PointCloud, Scan, Sensing

CLOCK_RESET = 1.0
"""A clock that jumps back by more than this has restarted, and all memory ends, s."""

_Reading = Scan | PointCloud
_MAX_SENSORS = 16
"""Limit of remembered sensors: a sensor whose mount moves looks like ever new sensors."""
_MOUNT_TOLERANCE = 1e-3
"""Mounts that differ by at most this, m and rad, are equal: tf rounds."""


@value
class SensorClock:
    """Newest reading of one sensor; the mount of a planar scanner has 3 numbers, of a cloud 6."""

    mount: Annotated[Floats, Shape("m")]
    range_max: float
    """m."""
    time: float
    """s."""
    behind: bool = False
    """True if the last reading was older than ``time``."""


@value
class Clocks:
    """Memory of the clock check."""

    now: float = -math.inf
    """Time of the newest observation, s."""
    sensors: tuple[SensorClock, ...] = ()
    """Newest reading of each sensor, the most recent message first."""


@value
class ClockCheck:
    """Observation with its usable readings."""

    observation: Observation
    sensing: Sensing
    reset: bool
    """True if time jumped back, so that earlier readings are void."""
    clocks: Clocks
    """Memory for the next call."""


def check_clocks(observation: Observation, memory: Clocks) -> ClockCheck:
    """Compare the times of an observation with earlier ones, and remove unusable readings.

    A reading is compared with the newest of the same sensor, that is of the same kind, mount and
    range; sensors may lag each other by up to ``CLOCK_RESET``. Removed are readings older than
    their sensor's newest, or farther than ``CLOCK_RESET`` from now. Time was reset if the
    observation jumps back by more than ``CLOCK_RESET``, or if one sensor is behind itself twice in
    a row: a single reading may have been overtaken in transport.

    ``sensing`` is ``CLOCK_BACKWARDS`` if a reading is behind its sensor or time was reset,
    ``CLOCK_OFFSET`` if one is far from now, ``SILENT`` if there is none, ``CLOCK_FROZEN`` if none
    is newer than its sensor's newest, else ``OK``.
    """
    readings: tuple[_Reading, ...] = (*observation.scans, *observation.clouds)
    near = [each for each in readings if abs(each.time - observation.time) <= CLOCK_RESET]
    reset = observation.time < memory.now - CLOCK_RESET
    last = [None if reset else _sensor_of(each, memory) for each in near]
    behind = [c is not None and r.time < c.time for r, c in zip(near, last, strict=True)]
    twice = any(late and c and c.behind for late, c in zip(behind, last, strict=True))
    newer = reset or any(c is None or r.time > c.time for r, c in zip(near, last, strict=True))
    sensing = Sensing.OK if newer else Sensing.CLOCK_FROZEN
    if reset or any(behind):
        sensing = Sensing.CLOCK_BACKWARDS
    elif len(near) < len(readings):
        sensing = Sensing.CLOCK_OFFSET
    elif not readings:
        sensing = Sensing.SILENT
    reset |= twice
    usable = near if reset else [r for r, late in zip(near, behind, strict=True) if not late]
    clocks = Clocks(now=observation.time) if reset else memory
    for reading in sorted(near, key=lambda each: each.time):
        clocks = _updated(reading, clocks)
    if math.isfinite(observation.time):
        clocks = Clocks(now=max(clocks.now, observation.time), sensors=clocks.sensors)
    if len(usable) < len(readings):
        observation = replace(
            observation,
            scans=tuple(each for each in usable if isinstance(each, Scan)),
            clouds=tuple(each for each in usable if isinstance(each, PointCloud)),
        )
    return ClockCheck(observation=observation, sensing=sensing, reset=reset, clocks=clocks)


def _updated(reading: _Reading, clocks: Clocks) -> Clocks:
    last = _sensor_of(reading, clocks)
    behind = last is not None and reading.time < last.time
    time = last.time if last and behind else reading.time
    now = SensorClock(mount=reading.mount, range_max=reading.range_max, time=time, behind=behind)
    others = tuple(each for each in clocks.sensors if each is not last)
    return Clocks(now=clocks.now, sensors=(now, *others)[:_MAX_SENSORS])


def _sensor_of(reading: _Reading, clocks: Clocks) -> SensorClock | None:
    return next((each for each in clocks.sensors if _is_from(reading, each)), None)


def _is_from(reading: _Reading, sensor: SensorClock) -> bool:
    if len(sensor.mount) != len(reading.mount) or sensor.range_max != reading.range_max:
        return False
    # Exact equality first: the usual case, and many times as fast.
    if sensor.mount.tolist() == reading.mount.tolist():
        return True
    return np.allclose(sensor.mount, reading.mount, rtol=0.0, atol=_MOUNT_TOLERANCE, equal_nan=True)
