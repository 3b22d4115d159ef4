"""A drive recorded to MCAP files: one, and another whenever the world begins anew."""

from __future__ import annotations

import logging
from pathlib import Path
from types import TracebackType
from typing import Self

from cohelm.errors import RecordingError
from cohelm.evaluation import Stage
from cohelm.evaluation.recorded import facts_of
from cohelm.navigation import Tick
from cohelm.recordings import RideRecorder
from cohelm.simulation import Truth

_log = logging.getLogger(__name__)


class Recording:
    """What is recorded of a drive; a disk that takes no more ends it, and not the drive.

    Args:
        file: the first file; None: nothing is recorded.
        stage: what is driven in.
    """

    def __init__(self, file: Path | None, stage: Stage) -> None:
        self._file, self._stage = file, stage
        self._recorder: RideRecorder | None = None
        self._empty = True

    def __enter__(self) -> Self:
        """Begin, or say why not."""
        self._open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Keep what is recorded."""
        self._close()

    def afresh(self) -> None:
        """The world begins anew: so does its recording, in a file of its own.

        One that has no tick yet is of the new world.
        """
        if self._recorder is not None and not self._empty:
            self._close()
            self._open()

    def add(self, tick: Tick, truth: Truth) -> None:
        """One more step."""
        if self._recorder is None:
            return
        self._empty = False
        try:
            self._recorder(tick, truth)
        except RecordingError as trouble:
            _log.error("recording ends: %s", trouble)
            self._close()

    def _open(self) -> None:
        if self._file is None:
            return
        self._empty = True
        try:
            self._recorder = RideRecorder(_free(self._file), facts_of(self._stage)).__enter__()
        except RecordingError as trouble:
            _log.error("nothing is recorded: %s", trouble)

    def _close(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        try:
            recorder.__exit__(None, None, None)
        except RecordingError as trouble:
            _log.error("recording ends: %s", trouble)


def _free(file: Path) -> Path:
    """The file, or where it is there already the same with the first free number behind."""
    number, free = 1, file
    while free.exists():
        number += 1
        free = file.with_stem(f"{file.stem}-{number}")
    return free
