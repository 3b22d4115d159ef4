"""Processes of our own, whoever begins them: how they are made, and what they never hear."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import resource_tracker
from pathlib import Path

spawn = multiprocessing.get_context("spawn")  # numba's threads do not survive a fork


@contextmanager
def without_interrupts() -> Iterator[None]:
    """Processes and threads that begin now never hear an interrupt; this one does afterwards."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    resource_tracker.ensure_running()  # where it begins later, it lets interrupts through again
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def leave_interrupts() -> None:
    """Of a process of our own: an interrupt is for the one that it belongs to."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def compiled(what: str = "*") -> bool:
    """Whether numba has kept anything of ours, or of the modules and functions named so."""
    folder = os.environ.get("NUMBA_CACHE_DIR") or Path(__file__).parents[1]
    return any(Path(folder).rglob(f"{what}.nbi"))


def end_with_owner(grace: float = 0.0) -> None:
    """Of a process of our own: end when the one that it belongs to is gone, killed or not.

    Who only waits at its pipe hears of that anyway; who is busy, or writes files, does not.

    Args:
        grace: in which it may still end by itself, s.
    """
    owner = multiprocessing.parent_process()
    if owner is None:
        return

    def watch() -> None:
        owner.join()
        time.sleep(grace)
        os._exit(1)  # nobody is left to tell

    threading.Thread(target=watch, name="owner", daemon=True).start()
