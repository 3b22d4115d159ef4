"""Peak memory of a call."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")


def peak_memory(call: Callable[[], Any]) -> float:
    """Measure the rise of the process's resident memory during a call, bytes.

    Memory that the process has freed but still holds is returned to the system first; otherwise a
    call that fits into it would seem to need none. NaN where the system does not report it.
    """
    gc.collect()
    try:
        with contextlib.suppress(AttributeError):  # malloc_trim belongs to glibc
            ctypes.CDLL(None).malloc_trim(0)
        _RESET.write_text("5", encoding="ascii")  # restarts the high-water mark
        before = _kilobytes("VmRSS")
        call()
        return 1024.0 * max(_kilobytes("VmHWM") - before, 0.0)
    except OSError:
        return math.nan


def _kilobytes(name: str) -> float:
    for line in _STATUS.read_text(encoding="ascii").splitlines():
        if line.startswith(f"{name}:"):
            return float(line.split()[1])
    raise OSError(f"{_STATUS} has no {name}")
