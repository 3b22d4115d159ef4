"""Files of single point clouds: reading them, and folders of them as a recording."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Shape, value
from cohelm.errors import RecordingError
from cohelm.geometry import compose, transform
from cohelm.messages import Observation, PointCloud
from cohelm.recordings.api import (
    FARTHEST,
    Frame,
    Labels,
    far_points_problem,
    without_far_points,
)

POINT_LIMIT = 20_000_000
"""Maximum number of points of a sweep."""

AT_REST = np.zeros(3)
UNKNOWN_MOUNT = np.array([0.0, 0.0, np.nan, 0.0, 0.0, 0.0])
"""Mount of a sensor at unknown height."""


@value
class CloudSweep:
    """Content of a file; the file does not contain its time."""

    points: Annotated[Floats32, Shape("p 3")]
    """In the sensor's frame, m."""
    range_max: float
    """Range of the sensor, m."""
    mount: Annotated[Floats, Shape("6")]
    """X_RS."""
    pose: Annotated[Floats, Shape("3")]
    """X_MR."""
    people: Annotated[Floats, Shape("k 3")] | None = None
    """(x, y, visible share) of labelled people, sensor's frame; None: not labelled."""
    damage: tuple[RecordingError, ...] = ()
    """Parts that could not be read."""


class SweepRecording:
    """Files with one sweep each, ``1 / rate`` apart; few contain a pose.

    Args:
        path: File or folder, for messages.
        files: In the order of time.
        read: Reads one file.
        rate: Sweeps per second, Hz.

    Raises:
        RecordingError: if the only file cannot be read.
    """

    def __init__(
        self, path: Path, files: Sequence[Path], read: Callable[[Path], CloudSweep], rate: float
    ) -> None:
        self.name = path.name
        self.frames: int | None = len(files)
        self.warnings: list[str] = []
        self._path = path
        self._files = files
        self._read = read
        self._rate = rate
        if len(files) > 1:
            self.warnings.append(f"{path}: contains no times; {rate:g} sweeps per second assumed")
        else:
            read(files[0])

    def __iter__(self) -> Iterator[Frame]:
        """Iterate over the frames in the order of the files.

        Raises:
            RecordingError: if no file can be read.
        """
        first: RecordingError | None = None
        seen = False
        for number, file in enumerate(self._files):
            try:
                sweep = self._read(file)
            except RecordingError as error:
                first = first or error
                self._warn(str(error))
                continue
            for fault in sweep.damage:
                self._warn(str(fault))
            seen = True
            yield _frame(sweep, number / self._rate)
        if first is not None and not seen:
            raise first

    def _warn(self, text: str) -> None:
        if text not in self.warnings:
            self.warnings.append(text)


def _frame(sweep: CloudSweep, time: float) -> Frame:
    labels = None
    if sweep.people is not None:
        X_MS = compose(sweep.pose, sweep.mount[[0, 1, 5]])
        labels = Labels(
            time=time,
            position=transform(X_MS, sweep.people[:, :2]),
            id=np.full(len(sweep.people), -1),
            visible=sweep.people[:, 2],
        )
    cloud = PointCloud(time=time, mount=sweep.mount, points=sweep.points, range_max=sweep.range_max)
    return Frame(
        observation=Observation(
            time=time,
            pose=sweep.pose,
            pose_time=time,
            twist=np.zeros(3),
            twist_time=time,
            clouds=(cloud,),
        ),
        labels=labels,
        posed=bool(sweep.pose.any()),
    )


def read_rows(file: Path, columns: int) -> tuple[Floats32, tuple[RecordingError, ...]]:
    """Read points (p, 3) from rows of ``columns`` little-endian float32, and the damage.

    Raises:
        RecordingError: if the file cannot be read, is empty, too large, or holds no points.
    """
    size = 4 * columns
    data = read_bytes(file, POINT_LIMIT * size)
    whole = len(data) // size
    if whole == 0:
        problem = f"is empty or cut within its first point of {size} bytes"
        raise RecordingError(problem, file=file, offset=0)
    rows = np.frombuffer(data, dtype="<f4", count=whole * columns).reshape(whole, columns)[:, :3]
    if np.mean(_absurd(rows)) > 0.5:
        problem = "holds no points: most of its numbers are not distances in metres"
        raise RecordingError(problem, file=file, offset=0)
    damage = []
    if len(data) % size:
        problem = f"ends within a point: {whole} whole points are read"
        damage.append(RecordingError(problem, file=file, offset=whole * size))
    points, far = checked_points(rows, file)
    return points, (*damage, *far)


def checked_points(points: Floats32, file: Path) -> tuple[Floats32, tuple[RecordingError, ...]]:
    """Return points (p, 3) with NaN for those that no sensor can see, and the damage.

    Raises:
        RecordingError: if these are most of the points.
    """
    plausible, far = without_far_points(points)
    if not far:
        return points, ()
    problem = far_points_problem(far, len(points))
    if far > 0.5 * len(points):
        raise RecordingError(f"holds no points: {problem}", file=file)
    return plausible, (RecordingError(problem, file=file),)


def read_bytes(file: Path, max_size: int) -> bytes:
    """Read a whole file.

    Raises:
        RecordingError: if it cannot be read, or is larger than ``max_size``.
    """
    try:
        if not file.is_file():
            raise RecordingError("is not a file" if file.exists() else "does not exist", file=file)
        with file.open("rb") as stream:
            data = stream.read(min(max_size, file.stat().st_size) + 1)
    except OSError as error:
        raise RecordingError(error.strerror or str(error), file=file) from None
    if len(data) > max_size:
        raise RecordingError(f"is too large for one sweep, more than {max_size} bytes", file=file)
    return data


def _absurd(points: Floats32) -> Booleans:
    """Mask of rows with a number beyond any sensor's range, or too close to 0 to be a distance."""
    with np.errstate(invalid="ignore"):
        size = np.abs(points)
        absurd: Booleans = ((size > FARTHEST) & np.isfinite(size)) | ((size > 0.0) & (size < 1e-6))
    return np.asarray(absurd.any(axis=1))
