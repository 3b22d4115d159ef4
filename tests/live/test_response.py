"""Response of a rider: slow, bounded, deleted with the rides and reset."""

import pytest

from cohelm.live.sessions.database import Database
from cohelm.live.sessions.records import RideSummary, unknown_session
from cohelm.live.sessions.response import (
    reset_response,
    rider_response,
    stored_response,
    with_response,
)
from cohelm.messages import RiderProfile


def ride(number, **measures):
    return RideSummary(
        id=f"20260131-142530-r{number}",
        session="20260131-142530",
        started=f"2026-01-31T14:{number:02d}:00+00:00",
        seed=0,
        destination="",
        outcome="arrived",
        duration=10.0,
        length=5.0,
        measures=measures,
    )


def test_one_ride_moves_it_by_a_sixth():
    # five rides' worth of 0.8 and one of 0.2: 4.2 / 6
    assert rider_response([ride(1, tight_speed=0.2)]).tight_speed == pytest.approx(0.7)


def test_it_is_bounded_and_forgets_old_rides():
    slow = rider_response([ride(k % 60, tight_speed=0.0) for k in range(60)])
    assert slow.tight_speed == 0.2
    assert slow.rides["tight_speed"] == 50


def test_rides_without_the_measure_do_not_count():
    found = rider_response([ride(1), ride(2, steadiness=0.4)])
    assert found.tight_speed == 0.8
    assert found.steadiness == pytest.approx((5.0 + 0.4) / 6.0)


def test_only_learned_speeds_change_the_profile():
    profile = RiderProfile()
    assert with_response(profile, rider_response([])) is profile
    learned = with_response(profile, rider_response([ride(1, tight_speed=0.2)]))
    assert learned.tight_speed == pytest.approx(0.7)
    assert with_response(RiderProfile(tight_speed=0.3), rider_response([ride(1, tight_speed=0.2)])
                         ).tight_speed == 0.3  # fmt: skip


def test_it_is_learned_from_the_stored_rides_and_reset(tmp_path):
    database = Database(tmp_path)
    assert stored_response(database).tight_speed == 0.8
    database.write(
        "INSERT INTO ride VALUES ('a-r1', 'a', '', 'measured', ?, ?, NULL, NULL)",
        unknown_session("a", "").model_dump_json(), ride(1, tight_speed=0.2).model_dump_json(),
    )  # fmt: skip
    assert stored_response(database).tight_speed == pytest.approx(0.7)
    reset_response(database)
    assert stored_response(database).tight_speed == 0.8
    assert stored_response(database).since
