"""Replanning with a real planner on a floor with two corridors."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm import plugins
from cohelm.maps import distance_field
from cohelm.messages import LiveObstacles, Request, Wish
from cohelm.navigation.crowding import CrowdingParameters, update_crowding
from cohelm.navigation.obstacle_memory import ObstacleMemory, merge_obstacles
from cohelm.navigation.replanning.replanner import ReplanningParameters, update_route
from cohelm.navigation.replanning.route_query import PlanReason, RouteQuery
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.testing.scenes import walkers

START = np.array([3.0, 3.3, 0.0])
CROWD = [[x, y, 0.0, 0.0] for x in (9.0, 10.0, 11.0, 12.0, 13.0) for y in (2.8, 3.8)]
"""Ten people in the southern corridor, the shorter way."""
RULES = ReplanningParameters()
STEP = 0.5


@pytest.fixture(scope="module")
def stage():
    return build_scenario(load_scenario("door"), 0)


@pytest.fixture(scope="module")
def ask(stage):
    """A query on that floor, of a chair in the western hall."""
    walls = distance_field(stage.grid)
    nothing = LiveObstacles(corner=[0, 0], occupied=np.zeros((10, 10)), version=0)

    def make(time, **changes):
        plain = RouteQuery(
            time=time,
            request=Request(goal=stage.request.goal),
            pose=START,
            robot=stage.robot,
            grid=stage.grid,
            live=nothing,
            walls=walls,
            authority=None,
            people=walkers([]),
        )
        return replace(plain, **changes)

    return make


def north(state):
    return state.path.points[:, 1].max() > 6.0


def follow(ask, planner, until, what, state=None, start=0.0):
    """The states from ``start`` to ``until``, with ``what(time)`` changed in the question."""
    states = []
    for k in range(round((until - start) / STEP)):
        time = start + k * STEP
        state = update_route(ask(time, **what(time)), planner, state, RULES)
        states.append(state)
    return states


@pytest.mark.parametrize("method", ["soft_via", "upf", "astar"])
def test_a_crowded_corridor_moves_the_route_away_and_after_decay_back(ask, stage, method):
    """They come after 10 s and leave after 60 s; half of what they leave is gone 30 s later."""
    planner = plugins.build("global_planners", method)
    memory, rules = None, CrowdingParameters()

    def seen(time):
        nonlocal memory
        people = replace(walkers(CROWD if 10.0 <= time < 60.0 else []), time=time)
        memory = update_crowding(memory, people, stage.grid, None, rules)
        return {"crowding": memory.published, "people": people}

    states = follow(ask, planner, 240.0, seen)
    reasons = [
        state.reason
        for state, before in zip(states[1:], states, strict=False)
        if state.path is not before.path
    ]
    assert reasons == [PlanReason.BETTER, PlanReason.BETTER]
    away = [north(state) for state in states]
    assert not any(away[:20])
    assert all(away[60:120])
    assert not away[-1]


def closed_door(version=1):
    """The southern corridor closed at x = 13 m, in a window about it."""
    occupied = np.zeros((100, 100), dtype=np.uint8)
    occupied[30:95, 60:62] = 1
    return LiveObstacles(corner=[10, 200], occupied=occupied, version=version)


def test_a_path_that_is_found_blocked_far_ahead_is_left_once_and_kept_left(ask):
    planner = plugins.build("global_planners", "soft_via")
    states = follow(ask, planner, 60.0, lambda t: {"live": closed_door()} if t >= 10.0 else {})
    assert [north(s) for s in states[:20]] == [False] * 20
    assert states[-1].replans == 1
    assert states[-1].reason is PlanReason.BLOCKED
    assert north(states[-1])


def test_what_is_out_of_the_window_still_blocks(ask):
    planner = plugins.build("global_planners", "soft_via")
    door = closed_door()
    cells = np.argwhere(door.occupied) + door.corner
    rolled = merge_obstacles(
        LiveObstacles(corner=[0, 0], occupied=np.zeros((60, 60)), version=9),
        ObstacleMemory(cells=cells),
    )
    state = follow(ask, planner, 20.0, lambda t: {"live": door} if t >= 5.0 else {})[-1]
    assert north(state)
    later = follow(ask, planner, 120.0, lambda t: {"live": rolled}, state, 20.0)
    assert later[-1].path is state.path


def test_a_way_that_opens_again_is_taken_only_where_it_is_much_better(ask):
    """Of 21 m by the south and 28 m by the north: much better from the west, not from between."""
    planner = plugins.build("global_planners", "soft_via")
    state = follow(ask, planner, 20.0, lambda t: {"live": closed_door()} if t >= 5.0 else {})[-1]
    opened = replace(closed_door(2), occupied=np.zeros((100, 100)))
    back = follow(ask, planner, 120.0, lambda t: {"live": opened}, state, 20.0)[-1]
    assert (back.reason, north(back)) == (PlanReason.BETTER, False)
    on = replace(state, progress=9.0)  # in the northern corridor by now
    there = np.array([8.0, 7.7, 0.0])
    kept = follow(ask, planner, 120.0, lambda t: {"live": opened, "pose": there}, on, 20.0)[-1]
    assert kept.path is state.path


def test_a_new_wish_is_planned_for_at_once_and_remembers_nothing(ask):
    planner = plugins.build("global_planners", "soft_via")
    first = update_route(ask(0.0), planner, None, RULES)
    goal = first.request.goal
    wished = Request(goal=goal, wishes=(Wish(points=np.array([[13.0, 7.7]])),))
    state = update_route(ask(0.05, request=wished), planner, first, RULES)
    assert (state.reason, state.replans, north(state)) == (PlanReason.WISH, 1, True)
    np.testing.assert_array_equal(state.wish_origin, START[:2])
    elsewhere = Request(goal=np.array([22.5, 6.0]), wishes=wished.wishes)
    assert (
        update_route(ask(0.1, request=elsewhere), planner, state, RULES).reason is PlanReason.GOAL
    )


def test_nothing_changes_and_nothing_is_asked(ask):
    planner = plugins.build("global_planners", "soft_via")
    asked = []

    class Counted:
        def plan(self, problem):
            asked.append(problem)
            return planner.plan(problem)

    states = follow(ask, Counted(), 100.0, lambda t: {})
    assert len(asked) == 1
    assert states[-1].path is states[0].path
