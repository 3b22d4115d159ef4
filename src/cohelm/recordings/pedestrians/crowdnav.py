"""Recorded people of CrowdNav's cases (Chen et al., ICRA 2019): arrays in an npz file."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import RecordingError

STEP = 0.25
"""Time between two states, s."""


def read_cases(file: Path | str) -> Floats:
    """Read recorded people, (cases, instants, n, 4) of (x, y, v_x, v_y), every 0.25 s.

    Raises:
        RecordingError: if the file does not exist or is not such a recording.
    """
    try:
        with Path(file).open("rb") as stream, np.load(stream, allow_pickle=False) as data:
            states = np.asarray(data["pos_vel"], dtype=float)
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as cause:
        raise RecordingError(f"is not a recording of people ({cause})", file=file) from None
    if states.ndim != 4 or states.shape[3] != 4 or not states.shape[1]:
        raise RecordingError(f"has states of shape {states.shape}", file=file)
    if not np.isfinite(states).all():
        raise RecordingError("has states that are not finite numbers", file=file)
    return states
