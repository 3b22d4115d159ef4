"""Standard output and standard error, also where they are closed, full, or lack a character."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import sys
from collections.abc import Iterator

BROKEN_PIPE = 141
"""Exit status where the reader of the output has gone: 128 + SIGPIPE, as shells have it."""


def prepare() -> None:
    """Replace closed streams, and let standard output print ``?`` for an unknown character."""
    sys.stdout = sys.stdout or _null_stream()
    sys.stderr = sys.stderr or _null_stream()
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")


def say(text: str) -> None:
    """Write one line to standard error; lost where that cannot be written."""
    try:
        sys.stderr.write(f"{' '.join(text.split())}\n")
        sys.stderr.flush()
    except OSError:
        sys.stderr = _null_stream()


def drop_output() -> None:
    """Discard unwritten standard output, so that Python does not try again at its end."""
    with contextlib.suppress(OSError, ValueError):
        null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(null, sys.stdout.fileno())
        os.close(null)


@contextlib.contextmanager
def log_to_stderr(name: str = "cohelm.results") -> Iterator[None]:
    """Write what a logger logs to standard error, as lines, while this lasts."""
    log, lines = logging.getLogger(name), _Lines()
    level = log.level
    log.addHandler(lines)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(lines)
        log.setLevel(level)


class _Lines(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        say(record.getMessage())


def _null_stream() -> io.TextIOWrapper:
    return open(os.devnull, "w", encoding="utf-8")  # noqa: PTH123 # open until the end
