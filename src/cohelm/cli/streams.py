"""Standard output and standard error, also where they are closed, full, or know few letters."""

from __future__ import annotations

import contextlib
import io
import os
import sys

NOBODY_READS = 141
"""Exit status, 128 + the number of the signal, as shells have it."""


def prepare() -> None:
    """Give a closed stream somewhere to go, and an output that lacks a letter a ``?`` for it."""
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def say(text: str) -> None:
    """One line on standard error; lost where that cannot be written."""
    try:
        sys.stderr.write(f"{' '.join(text.split())}\n")
        sys.stderr.flush()
    except OSError:
        sys.stderr = _nowhere()


def drop_output() -> None:
    """Forget what standard output has not taken, so that Python does not try again at its end."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)


def _nowhere() -> io.TextIOWrapper:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 # open until the end
