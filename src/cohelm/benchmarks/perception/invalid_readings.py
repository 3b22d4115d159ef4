"""Perception on invalid readings: no exception, no person, and a status."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import Any

import numpy as np

from cohelm.arrays import Floats, Floats32
from cohelm.benchmarks.claims import NONE, measured
from cohelm.evaluation.perception.recording_view import perceive_frames, perception_of
from cohelm.messages import Observation, PointCloud, Scan, Sensing
from cohelm.perception import PerceptionParts
from cohelm.recordings import Frame

PART = "invalid readings"
FRAMES = 12
"""Frames of each kind of reading, more than a track needs to be confirmed."""
STEP = 0.1
"""Interval of frames, s."""
MANY = 1_000_000
"""Points of a huge cloud."""
_MOUNT = np.array([0.2, 0.0, 1.2, 0.0, 0.0, 0.0])
_REACH = 10.0
_EITHER = (Sensing.OK, Sensing.NO_RETURNS)
_Readings = tuple[Scan | PointCloud, ...]


def rows(settings: Sequence[str] = ()) -> Iterator[dict[str, Any]]:
    """One row per kind of reading: tracked people, and the sensing status."""
    nothing = np.empty((0, 3), dtype=np.float32)
    far = np.full((5000, 3), np.nan, dtype=np.float32)
    point = np.array([[2.0, 0.5, -0.4]], dtype=np.float32)
    room = _room()
    steady = np.arange(FRAMES) * STEP
    still, back = np.zeros(FRAMES), steady.copy()
    back[FRAMES // 2 :] -= 3.0
    line = partial(_row, parts=perception_of(settings))
    stands, goes = Sensing.CLOCK_FROZEN, Sensing.CLOCK_BACKWARDS
    yield line("empty cloud", [_cloud(t, nothing) for t in steady], (Sensing.NO_RETURNS,))
    yield line("all-NaN cloud", [_cloud(t, far) for t in steady], (Sensing.NO_RETURNS,))
    yield line("cloud of one point", [_cloud(t, point) for t in steady], _EITHER)
    yield line("one point a million times", [_cloud(0.0, np.tile(point, (MANY, 1)))], _EITHER)
    yield line("a million points: fog", [_cloud(t, _fog()) for t in steady[:3]], (Sensing.OK,))
    yield line("a million points: a room", [_cloud(t, _room(MANY)) for t in steady[:3]], _EITHER)
    yield line("clock standing still, cloud", [_cloud(t, room) for t in still], (stands,))
    yield line("clock running back, cloud", [_cloud(t, room) for t in back], (goes,))
    yield line("empty scan", [_scan(t, np.empty(0)) for t in steady], (Sensing.NO_RETURNS,))
    yield line("all-NaN scan", [_scan(t, np.full(540, np.nan)) for t in steady], _EITHER)
    yield line("scan of one return", [_scan(t, _one_beam()) for t in steady], (Sensing.OK,))
    yield line("clock standing still, scan", [_scan(t, _one_beam()) for t in still], (stands,))
    yield line("clock running back, scan", [_scan(t, _one_beam()) for t in back], (goes,))
    yield line("no sensor", [()] * FRAMES, (Sensing.SILENT,))


def _row(
    what: str,
    readings: Sequence[_Readings],
    wanted: tuple[Sensing, ...],
    *,
    parts: PerceptionParts,
) -> dict[str, Any]:
    """Row that requires no person, and an expected status in some frame after the first."""
    frames = [Frame(observation=_observation(k, each)) for k, each in enumerate(readings)]
    found = list(perceive_frames(frames, parts))
    statuses = [seen.perceived.sensing for seen in found]
    later = statuses[1:] or statuses
    count = max(len(seen.perceived.people) for seen in found)
    said = ", ".join(dict.fromkeys(status.value for status in statuses))
    remark = f"{len(readings)} frames; sensing {said}"
    right = any(status in wanted for status in later)
    return measured(PART, what, count, unit="people", bound=NONE, valid=right, remark=remark)


def _observation(k: int, readings: _Readings) -> Observation:
    clouds = tuple(each for each in readings if isinstance(each, PointCloud))
    scans = tuple(each for each in readings if isinstance(each, Scan))
    time = max((each.time for each in readings), default=k * STEP)
    return Observation.at_rest(time, scans=scans, clouds=clouds)


def _cloud(time: float, points: Floats32) -> _Readings:
    return (PointCloud(time=float(time), mount=_MOUNT, points=points, range_max=_REACH),)


def _scan(time: float, ranges: Floats) -> _Readings:
    beams = len(ranges)
    return (
        Scan(
            time=float(time),
            mount=np.array([0.3, 0.0, 0.0]),
            angle_min=-2.0,
            angle_increment=4.0 / max(beams - 1, 1),
            range_max=_REACH,
            ranges=ranges,
        ),
    )


def _one_beam() -> Floats:
    ranges = np.full(540, np.inf)
    ranges[270] = 2.0
    return ranges


def _fog() -> Floats32:
    """Points anywhere within range, from the floor up to 2.2 m."""
    rng = np.random.default_rng(0)
    low, high = (-_REACH, -_REACH, -_MOUNT[2]), (_REACH, _REACH, 1.0)
    return rng.uniform(low, high, (MANY, 3)).astype(np.float32)


def _room(count: int = 20_000) -> Floats32:
    """Points of the floor and the walls of a room of 8 × 6 m."""
    rng = np.random.default_rng(1)
    half = np.array([4.0, 3.0])
    x, y = rng.uniform(-half, half, (count, 2)).T
    z = np.zeros(count)
    wall = rng.integers(3, size=count)  # 0: the floor
    side = rng.choice([-1.0, 1.0], count)
    x, y = np.where(wall == 1, side * half[0], x), np.where(wall == 2, side * half[1], y)
    z = np.where(wall > 0, rng.uniform(0.0, 2.5, count), z)
    return np.column_stack([x, y, z - _MOUNT[2]]).astype(np.float32)
