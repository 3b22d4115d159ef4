"""One sweep of a sensor, as a file of its own holds it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, value
from cohelm.errors import RecordingError

POINT_LIMIT = 20_000_000
"""A file that claims more points is no single sweep."""

AT_REST = np.zeros(3)
SOMEWHERE = np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])
"""A sensor of which nobody says how high it is mounted."""


@value
class Sweep:
    """What a file holds of one instant; its time is told elsewhere."""

    points: Annotated[Floats32, Shape("p 3")]
    """In the sensor's frame, m."""
    range_max: float
    """Reach of the sensor, m."""
    mount: Annotated[Floats, Shape("6")]
    """X_RS."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    people: Annotated[Floats, Shape("k 3")] | None = None
    """(x, y, visible share) of those that somebody labelled, sensor's frame; None: nobody did."""
    damage: tuple[RecordingError, ...] = ()
    """What could not be read."""


def read_rows(file: Path, columns: int) -> tuple[Floats32, tuple[RecordingError, ...]]:
    """(p, columns) little-endian float32, and what is wrong at the end of the file.

    Raises:
        RecordingError: if the file cannot be read, is empty, too large, or holds no points.
    """
    size = 4 * columns
    data = read_bytes(file, POINT_LIMIT * size)
    whole = len(data) // size
    if whole == 0:
        problem = f"is empty or cut within its first point of {size} bytes"
        raise RecordingError(problem, file=file, offset=0)
    rows = np.frombuffer(data, dtype="<f4", count=whole * columns).reshape(whole, columns)
    if np.mean(_absurd(rows[:, :3])) > 0.5:
        problem = "holds no points: most of its numbers are no distances in metres"
        raise RecordingError(problem, file=file, offset=0)
    damage = []
    if len(data) % size:
        problem = f"ends within a point: {whole} whole points are read"
        damage.append(RecordingError(problem, file=file, offset=whole * size))
    return rows, tuple(damage)


def read_bytes(file: Path, most: int) -> bytes:
    """All of a file.

    Raises:
        RecordingError: if it cannot be read, or is larger than ``most``.
    """
    try:
        if not file.is_file():
            raise RecordingError("is no file" if file.exists() else "does not exist", file=file)
        with file.open("rb") as stream:
            data = stream.read(min(most, file.stat().st_size) + 1)
    except OSError as error:
        raise RecordingError(error.strerror or str(error), file=file) from None
    if len(data) > most:
        raise RecordingError(f"is too large for one sweep, more than {most} bytes", file=file)
    return data


def _absurd(points: Floats32) -> Booleans:
    """Which rows hold a number farther than any sensor sees, or nearer to 0 than any rounding."""
    with np.errstate(invalid="ignore"):
        size = np.abs(points)
        absurd: Booleans = ((size > 1e4) & np.isfinite(size)) | ((size > 0.0) & (size < 1e-6))
    return np.asarray(absurd.any(axis=1))
