"""A trip is planned before it begins, and what cannot be reached replaces nothing."""

import pickle
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from tests.planning.floors import problem, room

from cohelm.live.control.mission import GoalRefused, Mission, check_goal, wish_of
from cohelm.live.control.planning_context import PlanningContext
from cohelm.live.messages import Destination, RouteWish
from cohelm.live.page.preview_process import TripRequest, trip_answers
from cohelm.maps import OccupancyGrid
from cohelm.messages import Wish
from cohelm.planning import AStar, SoftVia
from cohelm.planning.alternatives.learned_preference import FeatureVector

SIDE_BY_SIDE = ((4.0, 2.0, 16.0, 4.8), (4.0, 6.8, 16.0, 10.0))
"""Two blocks in a room of 20 × 12 m: three ways from left to right."""
THREE_WAYS = problem(room(20.0, 12.0, 0.1, boxes=SIDE_BY_SIDE), (1.5, 5.8), (18.5, 5.8))


def asked(goal=(18.5, 5.8), wishes=(), planner=None, weights=None):
    context = PlanningContext(
        pose=np.array([1.5, 5.8, 0.0]), clearance=THREE_WAYS.clearance, speed=0.7, live=None,
    )  # fmt: skip
    request = TripRequest(
        id=7, client="a", goal=goal, wishes=wishes, planning_context=pickle.dumps(context)
    )
    navigator = SimpleNamespace(global_planner=planner or SoftVia(), filters=(), heat=None)
    setup = SimpleNamespace(grid=THREE_WAYS.grid, robot=THREE_WAYS.robot, navigator=navigator)
    *before, answer = trip_answers(request, setup, weights)
    assert [each.complete for each in before] == (
        [False] if weights is None and not answer.error else []
    )
    assert [each.routes[0].points for each in before] == [answer.routes[0].points for _ in before]
    return answer


def test_a_trip_has_the_planners_route_and_alternatives_with_their_differences():
    answer = asked()
    assert (answer.id, answer.error, len(answer.routes)) == (7, "", 3)
    first, *others = answer.routes
    assert (first.differences, first.via) == ((), None)
    # 17 m at 0.7 m/s, and a little to start and to stop
    assert 17.0 / 0.7 < first.duration < 17.0 / 0.7 + 5.0
    for route in others:
        told = {each.what: each.more for each in route.differences}
        assert told["length"] == pytest.approx(route.length - first.length, abs=0.1)


def test_routes_come_in_the_order_that_the_rider_prefers():
    """Whoever likes longer routes gets the longest one first, compared with nothing."""
    own = asked()
    longer = asked(weights=FeatureVector(length=1.0))
    lengths = [route.length for route in longer.routes]
    assert (own.learned, longer.learned) == (False, True)
    assert lengths == sorted(lengths, reverse=True) != [route.length for route in own.routes]
    first, *others = longer.routes
    assert first.differences == ()
    assert first.via is not None  # it is not the planner's own, so that it must be wished for
    told = [{each.what: each.more for each in route.differences} for route in others]
    assert any(each.get("length", 0.0) < -1.0 for each in told)  # less than the first one
    assert sorted(lengths) == sorted(route.length for route in own.routes)


def test_wishing_for_the_point_of_an_alternative_gives_that_route():
    for route in asked().routes[1:]:
        assert route.via is not None
        wished = replace(
            THREE_WAYS, wishes=(Wish(points=np.array([route.via])),), wish_origin=THREE_WAYS.start
        )
        driven = SoftVia().plan(wished)
        assert driven.length == pytest.approx(route.length, rel=0.05)
        assert np.hypot(*(driven.points - route.via).T).min() < 0.5


def test_a_planner_that_heeds_no_wishes_offers_no_alternatives():
    assert len(asked(planner=AStar()).routes) == 1


def test_a_wish_on_the_way_costs_what_it_adds():
    free = asked().routes[0].length
    answer = asked(wishes=(Wish(points=np.array([[10.0, 1.0]])),))
    assert answer.extra_length == pytest.approx(answer.routes[0].length - free, abs=0.2)
    assert answer.extra_length > 1.0


POCKET = problem(
    room(20.0, 12.0, 0.1, boxes=((4.0, 2.0, 9.0, 11.9), (11.0, 2.0, 16.0, 11.9))),
    (1.5, 1.0),
    (18.5, 1.0),
)
"""A corridor along the bottom, and a pocket 2 m wide and 10 m deep in its middle."""


def test_a_place_to_visit_is_visited_where_a_wish_for_it_is_not_worth_the_detour():
    at = np.array([[10.0, 9.0]])
    asked_for = replace(POCKET, wish_origin=POCKET.start)
    planner = SoftVia(SoftVia.Parameters(closeness=1.0))
    # A metre nearer costs two on the way in and out: with λ = 1 it is not worth it.
    near = planner.plan(replace(asked_for, wishes=(Wish(points=at),)))
    assert near.wishes.closest[0] > 6.0
    visit = planner.plan(replace(asked_for, wishes=(Wish(points=at, visit=True),)))
    assert visit.wishes.closest[0] < 0.2
    assert visit.length == pytest.approx(near.length + 2.0 * (9.0 - 1.0), abs=1.5)


def test_alternatives_visit_what_the_trip_visits():
    place = (10.0, 5.8)  # in the middle way
    answer = asked(wishes=(Wish(points=np.array([place]), visit=True),))
    assert answer.closest[0] < 0.2
    for route in answer.routes:
        assert np.hypot(*(np.array(route.points) - place).T).min() < 0.2


def test_a_place_that_cannot_be_reached_is_passed_and_the_distance_told():
    answer = asked(wishes=(Wish(points=np.array([[10.0, 3.4]]), visit=True),))  # inside a block
    assert not answer.error
    assert 0.5 < answer.closest[0] < 2.5  # 1.4 m to the edge of the block, and the chair's half


def test_no_route_is_an_answer():
    assert asked(goal=(10.0, 3.5)).error


def test_a_goal_outside_on_a_wall_or_in_the_unknown_is_refused():
    data = np.zeros((40, 40), dtype=np.int8)
    data[:, 30:] = -1
    data[0] = 100
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3))
    check_goal(Destination(name="", x=1.0, y=1.0), grid)
    for x, y, code in ((-1.0, 1.0, "outside_map"), (3.5, 1.0, "outside_map")):
        with pytest.raises(GoalRefused) as refused:
            check_goal(Destination(name="", x=x, y=y), grid)
        assert refused.value.code == code
    with pytest.raises(GoalRefused) as refused:
        check_goal(Destination(name="", x=1.0, y=0.05), grid)
    assert refused.value.code == "goal_blocked"


def test_an_area_is_avoided_or_it_is_told_how_much_of_the_route_is_within():
    top, all_ways = (
        Wish(kind="avoid", points=np.array([(8.0, y), (12.0, y), (12.0, z), (8.0, z)]))
        for y, z in ((10.0, 12.0), (0.0, 12.0))
    )
    assert asked(wishes=(top,)).through == (0.0,)
    assert asked(wishes=(top, all_ways)).through == (0.0, pytest.approx(4.0, abs=0.2))


def test_a_trip_replaces_destination_and_wishes_at_once():
    goal = Destination(name="Ward 3", x=1.0, y=2.0)
    wish = wish_of(RouteWish(kind="attract", points=((1.0, 1.0),)), 4)
    mission = Mission().with_goal(goal, (wish,))
    assert (mission.goal, mission.wishes, mission.version) == (goal, (wish,), 1)
