"""Child processes: creation, signals, and end with the parent."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker

spawn = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Start processes and threads that never receive an interrupt."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    # If the resource tracker started later, it would unblock interrupts again.
    resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def leave_interrupts() -> None:
    """Ignore interrupts in a child process; the parent handles them."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def end_with_owner(grace: float = 0.0) -> None:
    """End this child process when its parent is gone, even if that was killed.

    A process that waits at its pipe notices anyway; one that computes or writes files does not.

    Args:
        grace: time in which it may still end by itself, s.
    """
    owner = multiprocessing.parent_process()
    if owner is None:
        return

    def watch() -> None:
        owner.join()
        time.sleep(grace)
        os._exit(1)

    threading.Thread(target=watch, name="owner", daemon=True).start()
