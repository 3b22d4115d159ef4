from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.errors import StoreError
from cohelm.live.control.ipc import RideBegin
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Limits
from cohelm.live.ride_tracker import RideMarks, RideTracker

MOVING = SimpleNamespace(twist=np.array([0.3, 0.0, 0.0]))


class Kept:
    """Stands in for the sessions: a ride can be rated once it is kept."""

    def __init__(self):
        self.rides, self.ratings, self.count = [], {}, 0

    def begin(self, ride_setup, rider):
        return SimpleNamespace(id="s")

    def begin_ride(self):
        self.count += 1
        return f"s-r{self.count}", None

    error = ""

    def checkpoint(self, record, ride_setup=None):
        self.begun = record.id

    def keep(self, record, log, ride_setup):
        self.rides.append(record.id)

    def rate(self, ride, rating):
        if ride not in self.rides:
            raise StoreError("there is no such ride")
        self.ratings[ride] = rating


@pytest.fixture
def ended():
    """A ride that is over, whose log the navigator's process still has."""
    kept = Kept()
    limits = Limits(max_speed=1.0, max_acceleration=0.5, min_distance=0.3)
    rides = RideTracker(kept, SimpleNamespace(limits=limits, person=""), lambda *_: None)
    rides.enter(SimpleNamespace(seed=0))
    rides.step(MOVING, Mission(), elapsed=0.05, length=0.1, device="keys")
    rides.end("cancelled")
    return rides, kept


def test_a_ride_is_rated_before_its_log_has_come(ended):
    rides, kept = ended
    rides.rate("s-r1", 4)
    assert kept.ratings == {}
    rides.navigator_lost()
    assert kept.rides == ["s-r1"]
    assert kept.ratings == {"s-r1": 4}


def test_a_ride_is_rated_afterwards(ended):
    rides, kept = ended
    rides.navigator_lost()
    rides.rate("s-r1", 2)
    assert kept.ratings == {"s-r1": 2}


def test_marks_are_taken_in_their_order_and_none_is_lost(ended):
    """The navigator is busy from the beginning of one ride until after that of the next."""
    rides, _ = ended
    rides.step(MOVING, Mission(), elapsed=0.05, length=0.1, device="keys")
    assert rides.take_marks() == RideMarks(begin=RideBegin("s-r1", None))
    assert rides.take_marks() == RideMarks(end="cancelled", begin=RideBegin("s-r2", None))
    rides.end("collision")
    assert rides.take_marks() == RideMarks(end="collision")
    assert rides.take_marks() == RideMarks()


def test_what_is_no_ride_is_not_rated(ended):
    rides, _ = ended
    with pytest.raises(StoreError):
        rides.rate("s-r2", 5)


def test_a_full_disk_is_said_before_the_first_ride_and_no_longer_once_there_is_space():
    kept = Kept()
    full = [True]

    def begin(ride_setup, rider):
        if full[0]:
            raise StoreError("cannot be written (No space left on device)", file="data")

    kept.begin = begin
    limits = Limits(max_speed=1.0, max_acceleration=0.5, min_distance=0.3)
    settings = SimpleNamespace(limits=limits, person="", error="")
    rides = RideTracker(kept, settings, lambda *_: None)
    rides.enter(SimpleNamespace(seed=0))
    assert "No space left" in rides.error
    rides.retry()
    assert "No space left" in rides.error
    full[0] = False
    rides.retry()
    assert rides.error == ""
