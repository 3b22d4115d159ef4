"""Protocol of sensor recordings: frames of observations, with labels where there are any."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, value
from cohelm.messages import Observation


@value
class Labels:
    """Labelled positions of k people, or of parts of people."""

    time: float
    """s."""
    position: Annotated[Floats, Shape("k 2")]
    """Map frame, m."""
    id: Annotated[Integers, Shape("k")]
    """Stable for each person; −1: unknown."""
    visible: Annotated[Floats, Shape("k")]
    """Visible share of the body, 0…1; 1 where unknown."""


@value
class Frame:
    """One instant of a recording."""

    observation: Observation
    labels: Labels | None = None
    """None: not labelled."""
    posed: bool = True
    """True where the recording has the robot's pose; otherwise it is (0, 0, 0)."""
    unplaced: str = ""
    """Name of the sensor where its place on the robot is unknown: its frames fit no other's."""


class SensorRecording(Protocol):
    """A file of sensor readings, read while iterating."""

    name: str
    """Name of the file."""
    frames: int | None
    """Number of frames, some of which may be unreadable; None: unknown."""
    warnings: list[str]
    """One line for everything that could not be read or had to be assumed; grows while reading."""

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames in the order of time.

        Raises:
            RecordingError: if nothing can be read; names the file and, where known, the byte.
        """
        ...


def natural_order(file: Path) -> list[tuple[int, str]]:
    """Sort key of file names with numbers: 2 before 10."""
    parts = re.split(r"([0-9]+)", file.name)
    return [(int(part), "") if k % 2 else (-1, part) for k, part in enumerate(parts)]


FARTHEST = 1e4
"""Coordinate beyond the range of any sensor, m; assumed. Aerial LiDAR reaches half of it."""


def without_far_points(points: Floats32) -> tuple[Floats32, int]:
    """Replace points that no sensor can see by NaN, which is no return.

    A damaged exponent of a float gives such coordinates, up to 3e38 m.

    Args:
        points: (p, 3), sensor's frame, m; unchanged.

    Returns:
        (p, 3) points, and the number of those with a finite coordinate beyond :data:`FARTHEST`.
    """
    with np.errstate(invalid="ignore"):
        beyond = (np.abs(points) > FARTHEST) & np.isfinite(points)
        far: Booleans = np.asarray(beyond.any(axis=1))
    if not far.any():
        return points, 0
    return np.where(far[:, None], np.float32(np.nan), points), int(far.sum())


def far_points_problem(count: int, total: int) -> str:
    """Description of points that :func:`without_far_points` has removed."""
    return f"{count} of {total} points are more than {FARTHEST:g} m away and are not read"


def max_range(points: Floats32) -> float:
    """Distance of the farthest finite point of (p, 3) from the sensor, m; 0 without points."""
    with np.errstate(over="ignore", invalid="ignore"):
        distance = np.sqrt(np.einsum("ij,ij->i", points, points))
    return float(np.max(distance[np.isfinite(distance)], initial=0.0))
