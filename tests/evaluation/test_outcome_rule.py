"""The outcome rule: arrived, past all wanted places, never on floor to avoid."""

import dataclasses

import numpy as np
import pytest

from cohelm.evaluation import Outcome
from cohelm.evaluation.metrics.wanted import as_wanted, entered_avoided_floor, places_missed
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.rider_plan import RiderPlan
from cohelm.scenarios.scenario import load_scenario
from cohelm.simulation import SplitCells

LINE = np.column_stack([np.arange(11.0), np.zeros(11), np.zeros(11)])


def ride_past(made_ride, *past, pose=LINE, **changes):
    ride = made_ride(pose, **changes)
    plan = RiderPlan(past=past, past_distance=1.0)
    scenario = ride.scenario.model_copy(update={"rider_plan": plan})
    return dataclasses.replace(ride, scenario=scenario)


def test_a_ride_without_a_plan_is_as_wanted_where_it_arrives(made_ride):
    assert as_wanted(made_ride(LINE))
    for outcome in (Outcome.COLLISION, Outcome.STOPPED, Outcome.TIMEOUT):
        assert not as_wanted(made_ride(LINE, outcome=outcome))


@pytest.mark.parametrize(
    ("past", "missed"),
    [
        ([], 0),
        ([(4.0, 0.9)], 0),
        ([(4.0, 1.1)], 1),
        ([(3.0, 0.0), (7.0, 0.5)], 0),
        ([(7.0, 0.0), (3.0, 0.0)], 1),
        ([(3.0, 5.0), (7.0, 0.0)], 2),
    ],
)
def test_places_count_within_their_distance_and_in_their_order(made_ride, past, missed):
    ride = ride_past(made_ride, *past)
    assert places_missed(ride) == missed
    assert as_wanted(ride) == (missed == 0)


@pytest.mark.parametrize(("y", "enters"), [(2.0, False), (1.2, False), (0.9, True), (0.0, True)])
def test_the_footprint_must_keep_off_floor_to_avoid(made_ride, y, enters):
    # The square chair is 1 m wide; the centre of the one wet cell lies at (5.5, 0.5).
    wet = np.zeros((20, 20), dtype=bool)
    wet[0, 5] = True
    split = SplitCells(unsensed=np.zeros_like(wet), avoided=wet)
    setup = build_scenario(load_scenario("empty"), 0).world
    setup = dataclasses.replace(setup, split=split)
    ride = made_ride(LINE + np.array([0.0, y, 0.0]), setup=setup)
    assert entered_avoided_floor(ride) is enters
    assert as_wanted(ride) is not enters
    assert not entered_avoided_floor(dataclasses.replace(ride, setup=None))
