"""Work that Ctrl-C is not to tear apart."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator


@contextlib.contextmanager
def undisturbed() -> Iterator[None]:
    """An interrupt that comes within is raised at the end instead.

    Only the main thread is interrupted, and only Python's own handler is put off: whoever has
    another one wants to be asked at once.

    Raises:
        KeyboardInterrupt: at the end, if there was one.
    """
    mine = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT)
    if not mine or before is not signal.default_int_handler:
        yield
        return
    came: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt
