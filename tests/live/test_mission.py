"""From what a rider asked for to what the navigator is asked."""

import numpy as np
import pytest

from cohelm.errors import InvalidProblem, MapError
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.mission import Mission, check_wish, goal_of, request_of, wish_of
from cohelm.live.messages import Destination, FloorInfo, Limits, RiderSettings, RouteWish
from cohelm.maps import NamedPlace, Places
from cohelm.messages import Mode, RiderProfile

LIMITS = Limits(max_speed=0.6, max_acceleration=0.5, min_distance=0.7)
PLACES = Places(places=(NamedPlace(name="Ward 3", point=np.array([1.0, 2.0])),))
FLOOR = FloorInfo(image="", width=100, height=50, resolution=0.1, x=0.0, y=0.0)
WARD = Destination(name="Ward 3", x=1.0, y=2.0)


def asked(mission, *, moves=True):
    rider = RiderSettings(tremor_filter=0.2, dead_zone=0.15)
    return request_of(mission, RiderProfile(), LIMITS, rider, moves=moves)


@pytest.mark.parametrize("mode", list(Mode))
def test_with_nowhere_to_go_the_rider_steers(mode):
    request = asked(Mission(mode=mode))
    assert np.isnan(request.goal).all()
    assert request.mode is (mode if mode.rider_drives else Mode.ASSISTED)
    assert asked(Mission(mode=mode).with_goal(WARD)).mode is mode


@pytest.mark.parametrize("mode", list(Mode))
def test_a_chair_that_must_stand_is_asked_for_no_speed_and_needs_no_stick(mode):
    request = asked(Mission(mode=mode), moves=False)
    assert request.speed_limit == 0.0
    assert not request.mode.rider_drives


def test_a_chair_is_under_way_where_it_goes_on_by_itself():
    assert not Mission().under_way
    assert Mission().with_goal(WARD).under_way
    assert not Mission(mode=Mode.ASSISTED).with_goal(WARD).under_way


@pytest.mark.parametrize(("pace", "speed"), [("slow", 0.4), ("normal", 0.6), ("brisk", 0.6)])
def test_pace_is_bounded_by_the_limits(pace, speed):
    request = asked(Mission(pace=pace))
    assert request.speed_limit == request.profile.preferred_speed == speed


def test_limits_and_settings_reach_the_navigator():
    profile = asked(Mission()).profile
    assert profile.social_distance == 0.7
    assert (profile.tremor_filter, profile.dead_zone) == (0.2, 0.15)


def test_wishes_come_and_end_with_their_trip():
    wish = wish_of(RouteWish(kind="avoid", points=((1.0, 0.0),), radius=1.0), 1)
    trip = Mission().with_goal(WARD, (wish,))
    assert asked(trip).wishes[0].points.tolist() == [[1.0, 0.0]]
    assert trip.with_goal(WARD).wishes == ()
    assert trip.with_goal(None).wishes == ()
    driver = DriverState(mission=trip)
    driver.arrive()
    assert driver.mission.wishes == ()


def test_the_outline_of_a_large_place_is_no_line_that_is_too_long():
    points = ((0.0, 0.0), (8.0, 0.0), (8.0, 5.0), (0.0, 5.0)) * 20
    check_wish(RouteWish(kind="avoid", points=points), FLOOR)


def test_every_change_of_the_way_is_a_new_version():
    wish = wish_of(RouteWish(kind="attract", points=((1.0, 0.0),)), 1)
    trips = [Mission()]
    for goal, wishes in ((WARD, ()), (WARD, (wish,)), (None, ())):
        trips.append(trips[-1].with_goal(goal, wishes))
    assert len({each.version for each in trips}) == 4


def test_a_destination_is_a_place_or_a_point_or_none():
    assert goal_of("ward 3", None, PLACES) == WARD
    assert goal_of(None, (5.0, 6.0), PLACES) == Destination(name="", x=5.0, y=6.0)
    assert goal_of(None, None, PLACES) is None
    with pytest.raises(MapError, match="Ward 3"):
        goal_of("Ward 4", None, PLACES)


@pytest.mark.parametrize(
    "want",
    [
        RouteWish(kind="stroke", points=((1.0, 1.0),)),
        RouteWish(kind="avoid", points=((1.0, 1.0),)),
        RouteWish(kind="avoid", points=((1.0, 1.0), (2.0, 2.0))),
    ],
)
def test_a_wish_without_size_is_refused(want):
    with pytest.raises(InvalidProblem):
        check_wish(want, FLOOR)


@pytest.mark.parametrize(
    "points",
    [((1e6, 1e6), (-1e6, 1e6)), ((-2.1, 1.0),), ((1.0, 7.1),), ((0.0, 0.0), (8.0, 5.0)) * 32],
)
def test_what_no_way_can_heed_is_refused_before_one_is_looked_for(points):
    """Off the map by more than 2 m, or drawn to and fro for more than 300 m."""
    with pytest.raises(InvalidProblem):
        check_wish(RouteWish(kind="stroke", points=points), FLOOR)
    check_wish(RouteWish(kind="stroke", points=((0.0, 0.0), (10.0, 5.0), (11.9, 6.9))), FLOOR)
