"""Thread CPU time by stage: measured, never steered by."""

from __future__ import annotations

import time


class Stopwatch:
    """Thread CPU time from lap to lap, s."""

    def __init__(self) -> None:
        self.laps: dict[str, float] = {}
        self._last = time.thread_time()

    def lap(self, name: str) -> None:
        """Book the time since the last lap under ``name``."""
        now = time.thread_time()
        self.laps[name] = self.laps.get(name, 0.0) + now - self._last
        self._last = now
