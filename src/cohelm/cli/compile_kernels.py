"""``cohelm compile``: compile all kernels that a ride needs, before there is a ride."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Self

from rich.live import Live
from rich.text import Text

from cohelm import kernel_cache
from cohelm.cli.report import ERRORS, print_line
from cohelm.errors import ConfigError

KERNELS = 300
"""Number of kernels that are compiled, roughly."""
INTERVAL = 10.0
"""Interval of progress lines where there is no terminal, s."""
_CLOCK = 0.05
"""Delay of the clock that stamps files, s."""


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
    with _Progress(place.folder) as progress:
        for part in compilation.compile_kernels():
            progress.enter(part)
    if kernel_cache.unsaved():
        raise ConfigError(f"{kernel_cache.unsaved()}; set {kernel_cache.FOLDER}")
    kernel_cache.mark_complete(state)
    number = progress.number()
    done = f"compiled {number} kernels" if number else "nothing to compile"
    print_line(f"{done}, {progress.seconds():.0f} s; cache: {place.folder}")
    return 0


class _Progress:
    """Line on a terminal; elsewhere one line every ten seconds.

    Kernels are counted by their new files, because several processes compile.

    Args:
        folder: Folder of the cache.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._began = self._last = time.time()
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

    def seconds(self) -> float:
        """Time since the beginning, s."""
        return time.time() - self._began

    def number(self) -> int:
        """Number of kernels that were compiled so far."""
        times = [file.stat().st_mtime for file in self._folder.rglob("*.nbi")]
        return sum(each >= self._began - _CLOCK for each in times)

    def enter(self, part: str) -> None:
        """Show the part that is compiled now."""
        self._part = part
        now = time.time()
        if not ERRORS.is_terminal and now - self._last > INTERVAL:
            self._last = now
            ERRORS.print(self._text(), markup=False, soft_wrap=True)

    def _text(self) -> str:
        number, waited = self.number(), f"({self._part}), {self.seconds():.0f} s"
        if not number:
            return f"waiting for: compiled kernels {waited}"
        total = max(KERNELS, number)
        return f"waiting for: compiling {number} of about {total} kernels {waited}"
