"""Doors that close ahead: one new path for each real change, and never there and back again."""

from itertools import pairwise

import numpy as np
import pytest

from cohelm.evaluation import Outcome, run
from cohelm.geometry import nearest_on_polyline
from cohelm.navigation import PlanReason
from cohelm.scenarios import load_scenario

DOOR = np.array([13.0, 3.3])


def ride_with_door(seed, closed):
    spans = ", ".join(f"[{a}, {b}]" for a, b in closed)
    door = f"doors=[{{at: [13, 3.3], size: [0.1, 2.6], closed: [{spans}]}}]"
    return run(load_scenario("door", [door]), seed)


def through_the_door(points):
    return nearest_on_polyline(np.ascontiguousarray(points), *DOOR)[1] < 1.3


def ways(ride):
    """Whether each path of the ride in turn leads through the door, from where it was planned."""
    return [through_the_door(p) for p in [ride.path.points, *(r.points for r in ride.replans)]]


def check_one_replan(seed):
    """The door closes between 3 and 10 s, 8 to 3 m before the chair, and stays closed."""
    ride = ride_with_door(seed, [(3.0 + 7.0 * seed / 19.0, 600.0)])
    assert ride.outcome is Outcome.REACHED
    assert [replan.why for replan in ride.replans] == [PlanReason.BLOCKED]
    assert ways(ride) == [True, False]
    assert not ride.hit_wall.any()


@pytest.mark.parametrize("seed", [0])
@pytest.mark.slow
def test_a_door_that_closes_makes_one_new_path(seed):
    check_one_replan(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [s for s in range(20) if s != 0])
def test_so_it_is_in_every_ride(seed):
    check_one_replan(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0])
def test_a_door_that_opens_again_out_of_sight_changes_nothing(seed):
    ride = ride_with_door(seed, [(6.0, 16.0)])
    assert ride.outcome is Outcome.REACHED
    assert ways(ride) == [True, False]


def test_a_door_that_closes_behind_the_chair_changes_nothing():
    ride = ride_with_door(0, [(20.0, 600.0)])
    assert ride.outcome is Outcome.REACHED
    assert ride.replans == ()


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(5))
def test_a_door_that_flaps_does_not_make_the_chair_flap(seed):
    """It opens and closes every few seconds; the chair turns away once, and stays away."""
    spans = [(5.0 + 4.0 * k, 7.0 + 4.0 * k) for k in range(12)]
    ride = ride_with_door(seed, spans)
    assert ride.outcome is Outcome.REACHED
    returns = [not a and b for a, b in pairwise(ways(ride))]
    assert sum(returns) == 0
