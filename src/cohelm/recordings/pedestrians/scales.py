"""Unit and frame rate of recorded trajectories, and a check that people can walk like that."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Literal, get_args

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import RecordingError

Unit = Literal["m", "cm", "mm"]
METRES: dict[str, float] = {"m": 1.0, "cm": 0.01, "mm": 0.001}
_WALKING = (0.3, 3.0)
"""Median speeds of people who walk, m/s."""
_FLOOR = 0.3
"""Minimum extent of a floor with people who walk, m: a body is wider."""


def read_scales(header: str, width: int) -> tuple[float | None, str]:
    """(time between frames, s; unit) of a header, or of the format with ``width`` columns."""
    if not header:
        return (1.0 / 16.0, "cm") if width == 5 else (0.4, "m")
    rate = re.search(r"frame ?rate *[:=]? *([0-9.]+)", header, re.IGNORECASE)
    unit = re.search(r"(?:x ?[/\[(] ?|\bin |unit *[:=]? *)(mm|cm|m)\b", header, re.IGNORECASE)
    hertz = float(rate[1]) if rate and re.fullmatch(r"\d+\.?\d*", rate[1]) else 0.0
    return (1.0 / hertz if hertz > 0.0 else None), unit[1].lower() if unit else "m"


def check_scale(speeds: Floats, positions: Floats, unit: str, file: Path) -> None:
    """Check that people walk, and have room, at a scale.

    Args:
        speeds: of all samples (k,), m/s.
        positions: (k, 2), m.
        unit: of the file.
        file: named in the error.

    Raises:
        RecordingError: if they do not, and another unit fits.
    """
    speed, extent = float(np.median(speeds)), float(np.ptp(positions, axis=0).max())
    slow, fast = _WALKING
    crowded = len(speeds) > 1 and extent < _FLOOR
    if not (crowded or 0.0 < speed < 0.1 * slow or speed > 3.0 * fast):
        return
    for other in get_args(Unit):
        scale = METRES[other] / METRES[unit]
        fits = slow <= speed * scale <= fast or (speed == 0.0 and _FLOOR <= extent * scale < 1e3)
        if other != unit and fits:
            raise RecordingError(
                f"in {unit} its people walk at {speed:.2g} m/s over {extent:.2g} m; the unit is "
                f"probably {other}: give 'unit', or 'step' if the frame rate is wrong",
                file=file,
            )
