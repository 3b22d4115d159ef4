from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.driving.messages import Limits
from cohelm.driving.outings import Outings
from cohelm.driving.wanted import Errand
from cohelm.errors import StoreError


class Kept:
    """Stands in for the sessions: a ride can be rated once it is kept."""

    def __init__(self):
        self.rides, self.ratings = [], {}

    def begin(self, _):
        return SimpleNamespace(id="s")

    def begin_ride(self):
        return "s-r1", None

    def keep(self, record, log, stage):
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
    outings = Outings(kept, SimpleNamespace(limits=limits), lambda *_: None, 0.05)
    outings.on(SimpleNamespace(seed=0))
    order = SimpleNamespace(twist=np.array([0.3, 0.0, 0.0]))
    outings.went(order, Errand(), way=0.1, device="keys")
    outings.end("left")
    return outings, kept


def test_a_ride_is_rated_before_its_log_has_come(ended):
    outings, kept = ended
    outings.rate("s-r1", 4)
    assert kept.ratings == {}
    outings.lost()
    assert kept.rides == ["s-r1"]
    assert kept.ratings == {"s-r1": 4}


def test_a_ride_is_rated_afterwards(ended):
    outings, kept = ended
    outings.lost()
    outings.rate("s-r1", 2)
    assert kept.ratings == {"s-r1": 2}


def test_what_is_no_ride_is_not_rated(ended):
    outings, _ = ended
    with pytest.raises(StoreError):
        outings.rate("s-r2", 5)
