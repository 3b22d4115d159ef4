"""Arrival of a leading sensor's readings: a control step begins with each, not at a fixed time."""

from __future__ import annotations

import math
import threading
import time


class LeadingReadings:
    """Arrivals of the leading sensor's readings, from a platform's thread to the control loop.

    leading = LeadingReadings()
    Capabilities(name="my chair", wait=leading.wait)
    leading.arrived()        # in the thread that reads the sensor: observe() can return a reading
    leading.taken()          # in observe(), under the same lock as the readings
    """

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._at = -math.inf

    def arrived(self) -> None:
        """Report a new reading."""
        with self._changed:
            self._at = time.monotonic()
            self._changed.notify_all()

    def taken(self) -> None:
        """Report that all readings so far have been observed."""
        with self._changed:
            self._at = -math.inf

    def wait(self, after: float, timeout: float) -> float | None:
        """See :attr:`~cohelm.platforms.Capabilities.wait`."""
        with self._changed:
            came = self._changed.wait_for(lambda: self._at > after, max(timeout, 0.0))
            return self._at if came else None
