"""Alternative routes differ from each other."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.planning.floors import problem, room

from cohelm.errors import NoPath
from cohelm.messages import Wish
from cohelm.planning import AStar
from cohelm.planning.alternatives.alternatives import (
    AlternativeCriteria,
    find_alternatives,
    overlap,
    wish_distance,
)

from .random_floors import route_sets, storey

SIDE_BY_SIDE = ((4.0, 2.0, 16.0, 4.8), (4.0, 6.8, 16.0, 10.0))
"""Two blocks in a room of 20 × 12 m: three ways from left to right."""


def three_ways(**more):
    grid = room(20.0, 12.0, 0.1, boxes=SIDE_BY_SIDE)
    return problem(grid, (1.5, 5.8), (18.5, 5.8), **more)


def heights(routes):
    """Where the routes pass x = 10 m."""
    return [np.interp(10.0, *each.path.points.T) for each in routes]


def test_a_line_overlaps_itself_and_not_one_far_away():
    line = np.array([[0.0, 0.0], [10.0, 0.0]])
    assert overlap(line, line, 1.0) == 1.0
    assert overlap(line, np.add(line, (0.0, 2.0)), 1.0) == 0.0
    # all of the short one runs along the long one
    double = np.array([[0.0, 0.0], [20.0, 0.0]])
    assert overlap(line, double, 1.0) == 1.0


def test_overlap_is_the_share_of_the_length():
    straight = np.array([[0.0, 0.0], [10.0, 0.0]])
    leaves = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 6.0]])
    # the first 5 m of 10 are within 1 m of the other, and so are 4 m and the first of 6
    assert overlap(straight, leaves, 1.0) == pytest.approx(0.5, abs=0.02)


def test_every_corridor_is_found_and_the_planners_own_comes_first():
    routes = find_alternatives(three_ways(), AStar(), 3)
    assert sorted(np.round(heights(routes), 0)) == [1.0, 6.0, 11.0]
    own = AStar().plan(three_ways())
    assert np.array_equal(routes[0].path.points, own.points)
    prices = [each.price for each in routes]
    assert prices == sorted(prices)


def test_no_more_routes_than_there_are():
    assert len(find_alternatives(three_ways(), AStar(), 10)) == 3
    assert len(find_alternatives(three_ways(), AStar(), 1)) == 1
    with pytest.raises(ValueError, match="at least one"):
        find_alternatives(three_ways(), AStar(), 0)


def test_an_empty_room_has_one_way():
    assert len(find_alternatives(problem(room(20.0, 12.0, 0.1), (2, 2), (18, 10)), AStar(), 5)) == 1


def test_the_other_side_of_a_pillar_is_offered_only_where_there_is_nothing_else():
    pillar = (9.8, 5.8, 10.2, 6.2)
    beside = problem(room(20.0, 12.0, 0.1, boxes=[pillar]), (1.5, 6.0), (18.5, 6.0))
    wide = AlternativeCriteria(overlap=0.9)
    assert len(find_alternatives(beside, AStar(), 5, wide)) == 2
    wall = (6.0, 2.0, 14.0, 4.0)
    walled = problem(room(20.0, 12.0, 0.1, boxes=[pillar, wall]), (1.5, 6.0), (18.5, 6.0))
    routes = find_alternatives(walled, AStar(), 5, wide)
    assert sorted(y > 3.0 for y in heights(routes)) == [False, True]


def test_a_detour_beyond_bounds_is_none():
    far = room(20.0, 12.0, 0.1, boxes=[(2.0, 2.0, 18.0, 10.0)])
    there = problem(far, (1.0, 1.0), (19.0, 1.0))  # 18 m, or 38 m round the other side
    assert len(find_alternatives(there, AStar(), 3)) == 1
    assert len(find_alternatives(there, AStar(), 3, AlternativeCriteria(stretch=3.0))) == 2


def test_a_dead_end_is_no_way():
    """A cell in an alcove lies on no good way: going in and out again is always dearer."""
    alcoves = room(20.0, 9.0, 0.1, boxes=[(0.0, 3.0, 8.0, 9.0), (10.0, 3.0, 20.0, 9.0)])
    assert len(find_alternatives(problem(alcoves, (1.0, 1.5), (19.0, 1.5)), AStar(), 5)) == 1


def test_avoided_zones_hold_for_every_route():
    zone = Wish(kind="avoid", points=np.array([[10.0, 5.8]]), radius=1.0, hard=True)
    asked = three_ways()
    routes = find_alternatives(
        type(asked)(
            grid=asked.grid, robot=asked.robot, start=asked.start, goal=asked.goal, wishes=(zone,)
        ),
        AStar(),
        5,
    )
    assert sorted(np.round(heights(routes), 0)) == [1.0, 11.0]


def test_some_alternative_serves_the_wish_and_some_says_what_it_costs():
    from cohelm.planning.planners.soft_via import SoftVia

    asked = three_ways(prefer=[(10.0, 11.0)])
    keen = SoftVia(SoftVia.Parameters(closeness=6.0))
    routes = find_alternatives(asked, keen, 4)
    own = routes[0].path
    assert wish_distance(own) < 0.2
    for each in routes[1:]:
        assert each.path.wishes.closest.shape == (1,)
        assert np.array_equal(each.path.without_wishes, own.without_wishes)
    straight = min(routes, key=lambda each: each.path.length)
    assert wish_distance(straight.path) > 4.0
    assert straight.path.wishes.extra_length == pytest.approx(0.0, abs=0.3)


def test_no_way_is_said():
    closed = room(20.0, 12.0, 0.1, boxes=[(9.0, 0.0, 10.0, 12.0)])
    with pytest.raises(NoPath):
        find_alternatives(problem(closed, (2, 2), (18, 10)), AStar(), 3)


def test_twice_the_same():
    first, second = (find_alternatives(three_ways(), AStar(), 3) for _ in range(2))
    for a, b in zip(first, second, strict=True):
        assert np.array_equal(a.path.points, b.path.points)


@settings(max_examples=5, deadline=None)
@given(seed=st.integers(0, 10_000))
def test_on_any_storey_routes_differ_pairwise_and_are_no_detours(seed):
    rng = np.random.default_rng(seed)
    differing = AlternativeCriteria()
    for routes in route_sets([storey(rng)], rng, 2, k=4):
        for a, b in itertools.combinations(routes, 2):
            assert overlap(a.path.points, b.path.points, differing.corridor) <= 0.7
        for each in routes[1:]:
            assert each.overlap <= 0.7
            assert each.path.length <= differing.stretch * routes[0].path.length
            assert np.array_equal(each.path.points[[0, -1]], routes[0].path.points[[0, -1]])
