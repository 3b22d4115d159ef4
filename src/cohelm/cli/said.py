"""What the parts below the commands log of their progress, as lines on standard error."""

from __future__ import annotations

import contextlib
import logging
from collections.abc import Iterator

from cohelm.cli import streams


class _Lines(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        streams.say(record.getMessage())


@contextlib.contextmanager
def said(name: str = "cohelm.results") -> Iterator[None]:
    """While this lasts, what is logged under a name is said."""
    log, lines = logging.getLogger(name), _Lines()
    level = log.level
    log.addHandler(lines)
    log.setLevel(logging.INFO)
    try:
        yield
    finally:
        log.removeHandler(lines)
        log.setLevel(level)
