"""``cohelm compile``: compile all kernels that a ride needs, before there is a ride."""

from __future__ import annotations

import time
from typing import Self

from rich.live import Live
from rich.text import Text

from cohelm import kernel_cache
from cohelm.cli.report import ERRORS, print_line
from cohelm.errors import ConfigError

INTERVAL = 10.0
"""Interval of progress lines where there is no terminal, s."""


def compile_all() -> int:
    """Compile what is not in the cache, and print how long it took; returns 0.

    Raises:
        ConfigError: No folder can be written to, so that nothing would remain.
    """
    place = kernel_cache.place()
    if not place.lasts:
        raise ConfigError(f"{place.note}: nothing would remain; set {kernel_cache.FOLDER}")
    if place.note:
        ERRORS.print(place.note, markup=False, soft_wrap=True)
    if kernel_cache.is_complete():
        print_line(f"nothing to compile; cache: {place.folder}")
        return 0
    from cohelm.live import compilation

    state = kernel_cache.state()
    counted = kernel_cache.CompileProgress()
    with CompileBar(counted) as progress:
        for part in compilation.compile_kernels():
            progress.enter(part)
    if kernel_cache.unsaved():
        raise ConfigError(f"{kernel_cache.unsaved()}; set {kernel_cache.FOLDER}")
    kernel_cache.mark_complete(state)
    number = counted.kernels
    done = f"compiled {number} kernels" if number else "nothing to compile"
    print_line(f"{done}, {counted.seconds:.0f} s; cache: {place.folder}")
    return 0


class CompileBar:
    """Line on a terminal; elsewhere one line every ten seconds.

    Args:
        counted: What is compiled already.
    """

    def __init__(self, counted: kernel_cache.CompileProgress) -> None:
        self._counted = counted
        self._last = time.time()
        self._part = ""
        self._live = Live(
            get_renderable=lambda: Text(self._text()),
            console=ERRORS,
            refresh_per_second=1,
            transient=True,
        )

    def __enter__(self) -> Self:
        if ERRORS.is_terminal:
            self._live.start()
        return self

    def __exit__(self, *error: object) -> None:
        if ERRORS.is_terminal:
            self._live.stop()

    def enter(self, part: str) -> None:
        """Show the part that is compiled now."""
        self._part = part
        now = time.time()
        if not ERRORS.is_terminal and now - self._last > INTERVAL:
            self._last = now
            ERRORS.print(self._text(), markup=False, soft_wrap=True)

    def _text(self) -> str:
        share, left = self._counted.estimate()
        bar = "█" * round(20 * share) + "░" * (20 - round(20 * share))
        wait = f"about {left:.0f} s left" if left is not None else f"{self._counted.seconds:.0f} s"
        return f"waiting for: compiled kernels {bar} {100 * share:.0f} % ({self._part}), {wait}"
