"""Arrivals of the leading sensor's readings wake the control loop."""

import threading
import time

from cohelm.platforms import LeadingReadings


def test_an_arrival_ends_the_wait_and_stays_until_it_is_taken():
    leading, began = LeadingReadings(), time.monotonic()
    threading.Timer(0.05, leading.arrived).start()
    at = leading.wait(-1.0, 5.0)
    assert began < at <= time.monotonic() < began + 4.0
    assert leading.wait(-1.0, 0.0) == at
    assert leading.wait(at, 0.01) is None
    leading.taken()
    assert leading.wait(-1.0, 0.01) is None
