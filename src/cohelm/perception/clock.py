"""Whether the clocks of the sensors run on, each compared with itself."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.messages import Observation, PointCloud, Scan, Sensing

RAN_BACK = 1.0
"""A clock that is behind by more than this has started anew, and all memory ends, s; a reading that
is behind by less is late."""

_SENSORS = 16
"""So many sensors are remembered: one whose mount moves looks like ever new ones."""
_SAME = 1e-3
"""Mounts that differ by no more than this, m and rad, are one: tf rounds."""


@value
class Heard:
    """The newest reading of one sensor; a planar scanner's mount has 3 numbers, a cloud's 6."""

    mount: Annotated[Floats, Shape("m")]
    time: float
    """s."""


@value
class Clocks:
    """What is remembered of time."""

    now: float = -math.inf
    """Of the newest observation, s."""
    heard: tuple[Heard, ...] = ()
    """Each sensor's newest reading, the last one heard first."""


def read_clocks(observation: Observation, memory: Clocks) -> tuple[Sensing, Clocks]:
    """How the times of an observation compare with those before, and the memory for the next one.

    A reading is compared with the newest of the same sensor: of the same kind and mount. Sensors
    may be late behind one another as they like.

    Returns:
        ``SILENT`` where there is no reading; ``CLOCK_BACK`` where one is older than its sensor's
        newest, or all time ran back by more than ``RAN_BACK``; ``CLOCK_STANDS`` where none is newer
        than its sensor's newest; else ``OK``.
    """
    began_anew = observation.time < memory.now - RAN_BACK
    if began_anew:
        memory = Clocks()
    readings = (*observation.scans, *observation.clouds)
    heard, newer, older = memory.heard, False, began_anew
    for reading in readings:
        last = next((each for each in heard if _is_from(reading, each)), None)
        newest = -math.inf if last is None else last.time
        newer |= reading.time > newest
        older |= reading.time < newest
        if not math.isfinite(reading.time):
            continue
        late = newest - RAN_BACK <= reading.time < newest
        noted = Heard(mount=reading.mount, time=newest if late else reading.time)
        heard = (noted, *(each for each in heard if each is not last))[:_SENSORS]
    clocks = Clocks(now=max(memory.now, observation.time), heard=heard)
    if older:
        return Sensing.CLOCK_BACK, clocks
    if not readings:
        return Sensing.SILENT, clocks
    return (Sensing.OK if newer else Sensing.CLOCK_STANDS), clocks


def _is_from(reading: Scan | PointCloud, heard: Heard) -> bool:
    if len(heard.mount) != len(reading.mount):
        return False
    return np.allclose(heard.mount, reading.mount, rtol=0.0, atol=_SAME, equal_nan=True)
