"""Whether the clocks of the sensors run on, each compared with itself, and what to leave out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.messages import Observation, PointCloud, Scan, Sensing

RAN_BACK = 1.0
"""A clock that is behind by more than this has started anew, and all memory ends, s."""

_Reading = Scan | PointCloud
_SENSORS = 16
"""So many sensors are remembered: one whose mount moves looks like ever new ones."""
_SAME = 1e-3
"""Mounts that differ by no more than this, m and rad, are one: tf rounds."""


@value
class Heard:
    """The newest reading of one sensor; a planar scanner's mount has 3 numbers, a cloud's 6."""

    mount: Annotated[Floats, Shape("m")]
    range_max: float
    """m."""
    time: float
    """s."""
    behind: bool = False
    """Whether the last reading was older than that."""


@value
class Clocks:
    """What is remembered of time."""

    now: float = -math.inf
    """Of the newest observation, s."""
    heard: tuple[Heard, ...] = ()
    """Each sensor's newest reading, the last one heard first."""


@value
class Timely:
    """An observation with those readings that can be used."""

    observation: Observation
    sensing: Sensing
    anew: bool
    """Whether time ran back, so that all that was seen before counts for nothing."""
    clocks: Clocks
    """For the next call."""


def timely(observation: Observation, memory: Clocks) -> Timely:
    """Compare the times of an observation with those before, and leave out what is of no use.

    A reading is compared with the newest of the same sensor, that is of the same kind, mount and
    reach; sensors may be late behind one another by up to ``RAN_BACK``. Left out is what is older
    than its sensor's newest, or farther than ``RAN_BACK`` from now. Time ran back where all of it
    did by more than ``RAN_BACK``, or where one sensor is behind itself twice running: one reading
    alone may have been overtaken on its way.

    ``sensing`` is ``CLOCK_BACK`` where a reading is behind its sensor or time ran back,
    ``CLOCK_APART`` where one is far from now, ``SILENT`` where there is none, ``CLOCK_STANDS``
    where none is newer than its sensor's newest, else ``OK``.
    """
    readings: tuple[_Reading, ...] = (*observation.scans, *observation.clouds)
    near = [each for each in readings if abs(each.time - observation.time) <= RAN_BACK]
    anew = observation.time < memory.now - RAN_BACK
    last = [None if anew else _last(each, memory) for each in near]
    behind = [h is not None and r.time < h.time for r, h in zip(near, last, strict=True)]
    twice = any(late and h and h.behind for late, h in zip(behind, last, strict=True))
    newer = anew or any(h is None or r.time > h.time for r, h in zip(near, last, strict=True))
    told = Sensing.OK if newer else Sensing.CLOCK_STANDS
    if anew or any(behind):
        told = Sensing.CLOCK_BACK
    elif len(near) < len(readings):
        told = Sensing.CLOCK_APART
    elif not readings:
        told = Sensing.SILENT
    anew |= twice
    kept = near if anew else [r for r, late in zip(near, behind, strict=True) if not late]
    clocks = Clocks(now=observation.time) if anew else memory
    for reading in sorted(near, key=lambda each: each.time):
        clocks = _noted(reading, clocks)
    if math.isfinite(observation.time):
        clocks = replace(clocks, now=max(clocks.now, observation.time))
    if len(kept) < len(readings):
        observation = replace(
            observation,
            scans=tuple(each for each in kept if isinstance(each, Scan)),
            clouds=tuple(each for each in kept if isinstance(each, PointCloud)),
        )
    return Timely(observation=observation, sensing=told, anew=anew, clocks=clocks)


def _noted(reading: _Reading, clocks: Clocks) -> Clocks:
    last = _last(reading, clocks)
    behind = last is not None and reading.time < last.time
    time = last.time if last and behind else reading.time
    now = Heard(mount=reading.mount, range_max=reading.range_max, time=time, behind=behind)
    others = tuple(each for each in clocks.heard if each is not last)
    return replace(clocks, heard=(now, *others)[:_SENSORS])


def _last(reading: _Reading, clocks: Clocks) -> Heard | None:
    return next((each for each in clocks.heard if _is_from(reading, each)), None)


def _is_from(reading: _Reading, heard: Heard) -> bool:
    if len(heard.mount) != len(reading.mount) or heard.range_max != reading.range_max:
        return False
    if np.array_equal(heard.mount, reading.mount):  # nearly always, and several times as quick
        return True
    return np.allclose(heard.mount, reading.mount, rtol=0.0, atol=_SAME, equal_nan=True)
