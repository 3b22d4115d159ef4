"""``cohelm compile``: compile all kernels that a ride needs, before there is a ride."""

from __future__ import annotations

import time

from rich.live import Live
from rich.text import Text

from cohelm import kernel_cache
from cohelm.cli.report import ERRORS, print_line
from cohelm.errors import ConfigError

KERNELS = 300
"""Number of kernels that are compiled, roughly."""
INTERVAL = 10.0
"""Interval of progress lines where there is no terminal, s."""


def compile_all() -> int:
    """Compile what is not in the cache, and print how long it took; returns 0.

    Raises:
        ConfigError: No folder can be written to, so that nothing would remain.
    """
    place = kernel_cache.place()
    if not place.lasts:
        raise ConfigError(f"{place.note}, which is deleted at the end; set {kernel_cache.FOLDER}")
    if place.note:
        ERRORS.print(place.note, markup=False, soft_wrap=True)
    if kernel_cache.is_complete():
        print_line(f"nothing to compile; cache: {place.folder}")
        return 0
    from cohelm.live.compilation import Compilations, compile_kernels  # noqa: PLC0415 # takes seconds

    began, state = time.monotonic(), kernel_cache.state()
    with _Progress() as progress, Compilations(progress.count).listening() as compiled:
        for part in compile_kernels():
            progress.enter(part)
    kernel_cache.mark_complete(state)
    took = time.monotonic() - began
    done = f"compiled {compiled.number} kernels" if compiled.number else "nothing to compile"
    print_line(f"{done}, {took:.0f} s; cache: {place.folder}")
    return 0


class _Progress:
    """Line on a terminal; elsewhere one line every ten seconds."""

    def __init__(self) -> None:
        self._began = self._last = time.monotonic()
        self._number, self._part = 0, ""
        self._live = Live(
            get_renderable=lambda: Text(self._text()),
            console=ERRORS,
            refresh_per_second=4,
            transient=True,
        )

    def __enter__(self) -> _Progress:
        if ERRORS.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *error: object) -> None:
        if ERRORS.is_terminal:
            self._live.stop()

    def enter(self, part: str) -> None:
        """Show the part that is compiled now."""
        self._part = part

    def count(self, number: int) -> None:
        """Show the number of kernels so far."""
        self._number = number
        now = time.monotonic()
        if not ERRORS.is_terminal and now - self._last > INTERVAL:
            self._last = now
            ERRORS.print(self._text(), markup=False, soft_wrap=True)

    def _text(self) -> str:
        took = time.monotonic() - self._began
        if not self._number:
            return f"checking the compiled kernels ({self._part}), {took:.0f} s"
        total = max(KERNELS, self._number)
        return f"compiling {self._number} of about {total} kernels ({self._part}), {took:.0f} s"
