"""Time and memory of a call, as benchmarks state them."""

from __future__ import annotations

import contextlib
import ctypes
import gc
import math
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")


@dataclass(frozen=True)
class Timing:
    """Thread CPU times of repeated calls."""

    median: float
    """s."""
    p99: float
    """s; of few rounds it is nearly the longest."""
    rounds: int


def timed(call: Callable[[], Any], rounds: int) -> Timing:
    """Call once to warm up, then as often as said."""
    call()
    times = np.empty(rounds)
    for i in range(rounds):
        begin = time.thread_time()
        call()
        times[i] = time.thread_time() - begin
    median, p99 = np.percentile(times, [50.0, 99.0])
    return Timing(median=float(median), p99=float(p99), rounds=rounds)


def peak_memory(call: Callable[[], Any]) -> float:
    """By how much a call lifts the process's resident memory at its height, bytes.

    What the process has freed but kept is given back before, else a call that fits into it would
    seem to take nothing. NaN where the system does not say (other than Linux).
    """
    gc.collect()
    try:
        with contextlib.suppress(AttributeError):  # of glibc
            ctypes.CDLL(None).malloc_trim(0)
        _RESET.write_text("5", encoding="ascii")  # the height counts from now on
        before = _kilobytes("VmRSS")
        call()
        return 1024.0 * max(_kilobytes("VmHWM") - before, 0.0)
    except OSError:
        return math.nan


def _kilobytes(name: str) -> float:
    for line in _STATUS.read_text(encoding="ascii").splitlines():
        if line.startswith(f"{name}:"):
            return float(line.split()[1])
    raise OSError(f"{_STATUS} does not say {name}")
