"""Recording of a drive to MCAP files: one for each world."""

from __future__ import annotations

import glob
import logging
import sys
from pathlib import Path
from types import TracebackType
from typing import Self

from cohelm.errors import RecordingError
from cohelm.evaluation.episode.recorded import facts_of
from cohelm.navigation import Tick
from cohelm.recordings import RideRecorder
from cohelm.scenarios import RideSetup
from cohelm.simulation import GroundTruth

_log = logging.getLogger(__name__)


class DriveRecording:
    """Recording of a drive; a full disk ends the recording, not the drive.

    Args:
        file: First file; None: nothing is recorded.
        ride_setup: World of the drive.
    """

    def __init__(self, file: Path | None, ride_setup: RideSetup) -> None:
        self._file, self._ride_setup = file, ride_setup
        self._recorder: RideRecorder | None = None
        self._empty = True
        self.error = ""
        """Reason why the recording has ended; empty: it goes on, or there is none."""

    def __enter__(self) -> Self:
        """Open the first file; a failure is logged."""
        self._open()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Close the file."""
        self._close()

    def restart(self) -> None:
        """Continue in a new file because the world restarted, unless the current one is empty."""
        if self._recorder is not None and not self._empty:
            self._close()
            self._open()

    def add(self, tick: Tick, truth: GroundTruth | None) -> None:
        """Record one step; without ground truth, what the chair measured."""
        if self._recorder is None:
            return
        self._empty = False
        try:
            self._recorder(tick, truth)
        except RecordingError as error:
            self._report(f"The recording has ended: {error.problem}.", error)
            self._close()

    def _open(self) -> None:
        if self._file is None:
            return
        self._empty = True
        try:
            file = _free(self._file)
            self._recorder = RideRecorder(file, facts_of(self._ride_setup)).__enter__()
            sys.stdout.write(f"recording {file}\n")
            sys.stdout.flush()
        except RecordingError as error:
            self._report(f"Nothing is recorded: {error.problem}.", error)

    def _close(self) -> None:
        recorder, self._recorder = self._recorder, None
        if recorder is None:
            return
        try:
            recorder.__exit__(None, None, None)
        except RecordingError as error:
            self._report(f"The recording has ended: {error.problem}.", error)

    def _report(self, text: str, error: RecordingError) -> None:
        _log.error("recording: %s", error)
        self.error = text


def _free(file: Path) -> Path:
    """Return the file, or if it exists the name with the number after the last one."""
    if not file.exists():
        return file
    others = file.parent.glob(f"{glob.escape(file.stem)}-*{file.suffix}")
    numbers = (each.stem.removeprefix(f"{file.stem}-") for each in others)
    last = max((int(each) for each in numbers if each.isdecimal()), default=1)
    return file.with_stem(f"{file.stem}-{last + 1}")
