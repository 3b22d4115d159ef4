"""Sweeps of nuScenes' LiDAR (.pcd.bin): x, y, z, intensity and the number of the ring.

The sensor's frame has x to the right and y ahead; its mount turns that as REP-103 wants it.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from cohelm.recordings.clouds.sweep import AT_REST, CloudSweep, read_rows

HEIGHT = 1.84
"""Height of LIDAR_TOP above the ground, m: calibration of nuScenes' cars."""

REACH = 100.0
"""Range of a HDL-32E, m: data sheet."""

COLUMNS = 5


def read_nuscenes(file: Path) -> CloudSweep:
    """Read the sweep.

    Raises:
        RecordingError: if the file cannot be read or holds no points.
    """
    points, damage = read_rows(file, COLUMNS)
    return CloudSweep(
        points=points,
        range_max=REACH,
        mount=np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, -math.pi / 2.0]),
        pose=AT_REST,
        damage=damage,
    )


def has_rings(start: bytes) -> bool:
    """Check that the first points of a file, read as nuScenes', have ring numbers."""
    whole = len(start) // (4 * COLUMNS)
    rows = np.frombuffer(start, dtype="<f4", count=whole * COLUMNS).reshape(whole, COLUMNS)
    ring = rows[:, 4]
    with np.errstate(invalid="ignore"):
        rings = (ring >= 0.0) & (ring < 128.0) & (ring == np.round(ring))
    return bool(whole >= 8 and rings.all() and len(np.unique(ring)) > 1)
