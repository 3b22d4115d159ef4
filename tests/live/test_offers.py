"""Offers of destinations in a live ride: from the stick to the page, and back by one press."""

import pytest

from cohelm.live.messages import SetGoal, SetMode
from cohelm.live.sessions.habits import with_habits
from cohelm.live.sessions.records import SessionInfo, SessionSummary
from cohelm.messages import Mode
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig
from .test_sessions import record


@pytest.fixture(scope="module")
def hospital():
    settings = ["people.count=0", "destinations.offers.shown_time=0.5"]
    return build_scenario(load_scenario("hospital", settings), 0)


@pytest.fixture
def rig(hospital):
    rig = Rig(hospital)
    rig.drive()
    return rig


def test_offers_follow_the_stick_and_one_press_chooses(rig):
    rig.say(SetMode(mode=Mode.ASSISTED))
    states = rig.steps(120, 0.8)
    offered = [state.offers for state in states if state.offers]
    assert offered
    assert all(len(offers) <= 3 for offers in offered)
    assert all(offer.why for offers in offered for offer in offers)
    assert all(state.goal is None for state in states)  # nothing is chosen by itself
    name = states[-1].offers[0].name
    rig.say(SetGoal(id=1, place=name))
    later = rig.steps(5)[-1]
    assert later.goal.name == name
    assert later.offers == ()


def sessions(*destinations, scene="hospital", outcome="arrived"):
    rides = [record(f"s-r{k}", destination=d, outcome=outcome) for k, d in enumerate(destinations)]
    info = SessionInfo(id="s", started="2026-01-31T14:25:30+00:00", scene=scene, robot="chair")
    return SessionSummary(session=info, rides=tuple(rides))


def test_habits_are_the_destinations_that_were_reached_on_this_floor():
    scenario = load_scenario("hospital")
    stored = [
        sessions("Ward 4", "Ward 4", "Kitchen"),
        sessions("Stairs", outcome="cancelled"),
        sessions("Ward 1", scene="ward"),
    ]
    known = with_habits(scenario, stored).destinations.inference.habits
    assert known == {"Kitchen": 1, "Ward 4": 2}
    assert with_habits(scenario, []).destinations == scenario.destinations


def test_habits_of_the_scenario_and_a_switched_off_inference_stay():
    given = load_scenario("hospital", ["destinations.inference.habits={Stairs: 3}"])
    assert with_habits(given, [sessions("Ward 4")]) is given
    off = load_scenario("hospital", ["destinations.infer=false"])
    assert with_habits(off, [sessions("Ward 4")]) is off
