"""Preference between routes: stored with the rides, per rider, deleted and reset with them."""

from typing import get_args

import pytest

from cohelm.live.control.mission import Mission, choice_of
from cohelm.live.messages import ChosenRoute, Destination, RouteCause, RouteFigures
from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import RideSummary, SessionInfo
from cohelm.live.sessions.response import reset_response
from cohelm.live.sessions.route_choices import learned_preference
from cohelm.navigation import PlanReason
from cohelm.planning.alternatives.learned_preference import MIN_CHOICES

ANNA = "rider-0f3a91c2"
WARD = Destination(name="Ward 1", x=1.0, y=2.0)
SHORT = RouteFigures(length=20.0, clearance=0.8, encounters=6.0, turns=2.0, doors=0.0)
QUIET = SHORT.model_copy(update={"length": 30.0, "encounters": 0.0})


def quiet_choice(taken=1):
    return choice_of(ChosenRoute(figures=(SHORT, QUIET), taken=taken), WARD)


def session(database, number, rider, count):
    """Session in which the rider took the quieter way each time."""
    id_ = f"20260131-14253{number}"
    info = SessionInfo(
        id=id_, started="2026-01-31T14:25:30+00:00", scene="hospital", robot="chair", rider=rider
    )
    for k in range(1, count + 1):
        ride = RideSummary(
            id=f"{id_}-r{k}", session=id_, seed=0,
            started=f"2026-01-31T14:{k:02d}:00+00:00", destination="Ward 1",
            outcome="arrived", duration=10.0, length=5.0, choice=quiet_choice(),
        )  # fmt: skip
        database.write(
            "INSERT INTO ride VALUES (?, ?, ?, 'measured', ?, ?, NULL, NULL)",
            ride.id, id_, rider, info.model_dump_json(), ride.model_dump_json(),
        )  # fmt: skip


def test_it_is_learned_from_the_rides_of_the_rider_alone_and_reset(tmp_path):
    database = Database(tmp_path)
    session(database, 0, ANNA, MIN_CHOICES)
    session(database, 1, "", MIN_CHOICES - 1)
    weights = learned_preference(database, ANNA)
    assert weights.encounters < 0.0 < weights.length  # they went farther, and met fewer people
    assert learned_preference(database, "") is None
    reset_response(database)  # now, which is later than the rides
    assert learned_preference(database, ANNA) is None


def test_a_choice_belongs_to_its_trip():
    mission = Mission().with_goal(WARD, (), quiet_choice())
    assert mission.choice.taken == 1
    assert mission.choice.routes[1].encounters == 0.0
    assert mission.with_goal(WARD).choice is None
    assert mission.with_goal(WARD, ()).choice is None


@pytest.mark.parametrize("chosen", [None, ChosenRoute(figures=(SHORT, QUIET), taken=2)])
def test_what_was_not_shown_is_no_choice(chosen):
    assert choice_of(chosen, WARD) is None


def test_pages_know_every_cause_of_a_route():
    assert set(get_args(RouteCause)) == {each.value for each in PlanReason}
