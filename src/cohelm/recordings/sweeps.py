"""Files of single sweeps as recordings: one of them, or a folder of them in a row."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from cohelm.errors import RecordingError
from cohelm.geometry import compose, transform
from cohelm.messages import Observation, PointCloud
from cohelm.recordings.api import Frame, Labels
from cohelm.recordings.sweep import Sweep


class SweepRecording:
    """Files that hold a sweep each, ``1 / rate`` apart; few say where they were taken.

    Args:
        path: of the file or folder, for messages.
        files: in the order of time.
        read: reads one.
        rate: how many a second, Hz.

    Raises:
        RecordingError: if the first one cannot be read where it is the only one.
    """

    def __init__(
        self, path: Path, files: Sequence[Path], read: Callable[[Path], Sweep], rate: float
    ) -> None:
        self.name = path.name
        self.frames: int | None = len(files)
        self.warnings: list[str] = []
        self._path = path
        self._files = files
        self._read = read
        self._rate = rate
        if len(files) > 1:
            self.warnings.append(f"{path}: tells no times; taken as {rate:g} sweeps a second")
        else:
            read(files[0])

    def __iter__(self) -> Iterator[Frame]:
        """The frames in the order of their files' names.

        Raises:
            RecordingError: if none of the files can be read.
        """
        first: RecordingError | None = None
        seen = False
        for number, file in enumerate(self._files):
            try:
                sweep = self._read(file)
            except RecordingError as error:
                first = first or error
                self._note(str(error))
                continue
            for fault in sweep.damage:
                self._note(str(fault))
            seen = True
            yield _frame(sweep, number / self._rate)
        if first is not None and not seen:
            raise first

    def _note(self, text: str) -> None:
        if text not in self.warnings:
            self.warnings.append(text)


def _frame(sweep: Sweep, time: float) -> Frame:
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
