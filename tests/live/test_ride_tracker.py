from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.errors import StoreError
from cohelm.live.control.mission import Mission
from cohelm.live.messages import Limits
from cohelm.live.ride_tracker import RideMarks, RideTracker
from cohelm.live.sessions.records import RideSummary
from cohelm.live.sessions.store import SessionStore
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

MOVING = SimpleNamespace(twist=np.array([0.3, 0.0, 0.0]))


@pytest.fixture
def ended(tmp_path):
    """A ride that is over, whose log the navigator's process still has."""
    kept = SessionStore(tmp_path)
    limits = Limits(max_speed=1.0, max_acceleration=0.5, min_distance=0.3)
    rides = RideTracker(kept, SimpleNamespace(limits=limits, person=""), lambda *_: None)
    rides.enter(build_scenario(load_scenario("empty"), 0))
    rides.step(MOVING, Mission(), elapsed=0.05, length=0.1, device="keys")
    rides.end("cancelled")
    yield rides, kept
    kept.close()


def first(rides):
    """The id of the first ride."""
    return rides._ended and next(iter(rides._ended))


def rating(kept, ride):
    kept.wait_until_idle()
    return next(r.rating for each in kept.list() for r in each.rides if r.id == ride)


def test_a_ride_is_rated_before_its_log_has_come(ended):
    rides, kept = ended
    ride = first(rides)
    rides.rate(ride, 4)
    assert kept.list() == ()
    rides.navigator_lost()
    assert rating(kept, ride) == 4


def test_a_ride_is_rated_afterwards(ended):
    rides, kept = ended
    ride = first(rides)
    rides.navigator_lost()
    rides.rate(ride, 2)
    assert rating(kept, ride) == 2


def test_marks_are_taken_in_their_order_and_none_is_lost(ended):
    """The navigator is busy from the beginning of one ride until after that of the next."""
    rides, _ = ended
    one = first(rides)
    rides.step(MOVING, Mission(), elapsed=0.05, length=0.1, device="keys")
    marks = rides.take_marks()
    assert (marks.begin.ride, marks.end) == (one, "")
    marks = rides.take_marks()
    assert marks.begin.ride == f"{one[:-1]}2"
    assert RideSummary.model_validate_json(marks.end).id == one
    rides.end("collision")
    marks = rides.take_marks()
    assert RideSummary.model_validate_json(marks.end).outcome == "collision"
    assert rides.take_marks() == RideMarks()


def test_the_summary_goes_to_the_log_every_second_and_never_before_the_beginning(ended):
    rides, _ = ended
    given = []
    for _ in range(65):
        rides.step(MOVING, Mission(), elapsed=0.05, length=0.1, device="keys")
        given.append(rides.take_marks().summary)
    told = [RideSummary.model_validate_json(each).duration for each in given if each]
    assert told == pytest.approx([1.0, 2.0, 3.0], abs=0.1)


def test_what_is_no_ride_is_not_rated(ended):
    rides, _ = ended
    with pytest.raises(StoreError):
        rides.rate("s-r2", 5)
