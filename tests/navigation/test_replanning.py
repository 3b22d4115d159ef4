"""Replanning: causes, and the path that is kept."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.errors import NoPath
from cohelm.maps import distance_field
from cohelm.messages import Authority, LiveObstacles, Reference, Wish
from cohelm.navigation.local_walls import local_walls
from cohelm.navigation.map_openings import NO_CELLS
from cohelm.navigation.recovery.progress_checker import ProgressParameters, check_progress
from cohelm.navigation.replanning.replanner import ReplanningParameters, update_route
from cohelm.navigation.replanning.route_query import RouteQuery
from cohelm.testing.scenes import open_floor, room, walkers

from .scenes import START, Straight, request

RULES = ReplanningParameters()
TICK = 0.05
FREE = open_floor()
SHUT = replace(FREE, distance=np.full_like(FREE.distance, 0.1))
"""Walls everywhere, 0.1 m away: less than the chair is wide."""


@pytest.fixture
def asked(chair):
    """A query at tick k: a free floor and no rider input unless ``changes`` adds them."""

    def make(k=0, **changes):
        plain = RouteQuery(
            time=k * TICK,
            request=request(),
            pose=np.array(START),
            robot=chair,
            grid=room(),
            live=LiveObstacles(corner=[0, 0], occupied=np.zeros((4, 4)), version=0),
            walls=FREE,
            authority=None,
            people=walkers([]),
        )
        return replace(plain, **changes)

    return make


@pytest.fixture
def plan_times(asked):
    """The ticks at which ``planner`` is asked, when tick k is what ``change(k)`` makes of it."""

    def run(ticks, change, planner=None, rules=RULES):
        planner, state, at = planner or Straight(), None, []
        for k in range(ticks):
            before = len(planner.asked)
            state = update_route(asked(k, **change(k)), planner, state, rules)
            if len(planner.asked) > before:
                at.append(k)
        return at

    return run


def test_a_good_path_is_kept_as_it_is(asked):
    planner = Straight()
    first = update_route(asked(), planner, None, RULES)
    for k in (1, 20, 2000):
        later = update_route(asked(k), planner, first, RULES)
        assert later.path is first.path
        assert later.planned_at == first.planned_at
    assert len(planner.asked) == 1


@pytest.mark.parametrize("since", range(1, 40))
def test_a_blocked_way_is_given_up_after_its_time_and_not_before(plan_times, since):
    # blocked_time 0.7 s: 14 ticks after it was first seen to be blocked
    at = plan_times(since + 15, lambda k: {"walls": SHUT if k >= since else FREE})
    assert at == [0, since + 14]


def test_a_way_that_is_free_again_in_between_counts_anew(plan_times):
    def change(k):
        return {"walls": FREE if k < 5 or k == 15 else SHUT}

    assert plan_times(40, change) == [0, 16 + 14]


def test_what_is_blocked_behind_or_far_ahead_does_not_matter(asked, chair):
    """The way is watched from the chair's projection for 6 m; its end is then 7 m away."""
    planner = Straight()
    state = update_route(asked(), planner, None, RULES)
    grid = room()
    walls = distance_field(grid)
    narrow = walls.distance.copy()
    cols = np.arange(narrow.shape[1]) * walls.resolution
    for low, high, blocked in [(0.0, 1.9, False), (8.2, 12.0, False), (5.0, 5.3, True)]:
        there = replace(
            walls, distance=np.where((cols > low) & (cols < high), np.float32(0.1), narrow)
        )
        later = update_route(asked(1, walls=there), planner, state, RULES)
        assert np.isfinite(later.blocked_since) == blocked


def test_a_chair_astray_gets_a_new_path_from_where_it_is(plan_times, asked):
    # max_deviation 1.0 m
    for aside, at in [(0.95, [0]), (1.05, [0, 10])]:
        pose = np.array([3.0, START[1] + aside, 0.0])
        assert plan_times(20, lambda k, pose=pose: {"pose": pose} if k >= 10 else {}) == at[:2]
    planner = Straight()
    state = update_route(asked(), planner, None, RULES)
    astray = np.array([3.0, START[1] + 1.05, 0.0])
    np.testing.assert_array_equal(
        update_route(asked(10, pose=astray), planner, state, RULES).path.points[0], astray[:2]
    )


def test_a_ride_that_does_not_get_on_looks_for_another_way(plan_times):
    assert plan_times(140, lambda k: {"stalled": k == 120}) == [0, 120]


def test_only_when_stalled_those_who_stand_are_gone_round_as_if_they_were_things(asked):
    """Of radius 0.25 m: one stands at (5, 4), one walks at (7, 4); standing is below 0.3 m/s."""
    people = walkers([[5.0, 4.0, 0.1, 0.0], [7.0, 4.0, 0.5, 0.0]])
    live = LiveObstacles(corner=[20, 40], occupied=np.zeros((120, 120)), version=3)
    planner = Straight()
    state = update_route(asked(people=people, live=live), planner, None, RULES)
    update_route(asked(30, people=people, live=live, stalled=True), planner, state, RULES)
    update_route(
        asked(30, people=people, live=live, walls=SHUT),
        planner,
        replace(state, blocked_since=0.0),
        RULES,
    )
    first, stalled, blocked = (question.live for question in planner.asked)
    assert first is live
    assert blocked is live
    cells = np.argwhere(stalled.occupied) + live.corner
    centres = room().centres(cells)
    assert len(cells) == pytest.approx(np.pi * 0.25**2 / 0.05**2, rel=0.05)
    assert np.hypot(*(centres - [5.0, 4.0]).T).max() < 0.25
    assert not live.occupied.any()


def test_two_plans_are_a_while_apart(plan_times):
    # min_interval 0.5 s: 10 ticks, however much there is to plan for
    assert plan_times(31, lambda k: {"stalled": True}) == [0, 10, 20, 30]


def test_a_path_behind_a_chair_that_cannot_turn_is_replaced_at_most_every_two_seconds(plan_times):
    behind = {"cannot_turn": True}
    assert plan_times(81, lambda k: behind) == [0, 40, 80]
    refused = Straight()

    def change(k):
        refused.error = NoPath(start=(0.0, 0.0), goal=(1.0, 1.0), needed=0.3) if k else None
        return behind

    assert plan_times(81, change, refused) == [0, 40, 80]


def test_the_same_goal_and_wishes_made_anew_are_the_same(plan_times):
    def change(k):
        return {"request": request(wishes=(Wish(points=np.array([[5.0, 5.0]])),))}

    assert plan_times(9, change) == [0]


def test_a_new_goal_or_wish_does_not_wait(plan_times):
    other = request(goal=(8.0, 6.0))
    wish = request(wishes=(Wish(points=np.array([[5.0, 5.0]])),))
    for new in (other, wish):
        assert plan_times(9, lambda k, new=new: {"request": new if k >= 3 else request()}) == [0, 3]


# ------------------------------------------------------------------ the rider's hand


def hand(eta, leads_to):
    poses = np.linspace([*START[:2], 0.0], [*leads_to, 0.0], 11)
    return Authority(
        eta=eta,
        intent=1.0,
        deflection=np.array([1.0, 0.5]),
        twist=np.zeros(3),
        states=Reference(step=0.1, poses=poses, speeds=np.zeros(11)),
    )


@pytest.mark.parametrize(("eta", "at"), [(0.0, [0]), (0.49, [0]), (0.5, [0, 10]), (0.63, [0, 10])])
def test_while_the_rider_steers_the_path_follows_the_hand(plan_times, eta, at):
    # steering_eta 0.5, and no sooner than min_interval after the last plan
    assert plan_times(15, lambda k: {"authority": hand(eta, (3.0, 5.0))}) == at


@pytest.mark.parametrize(("left", "follows"), [(1.6, True), (1.4, False)])
def test_near_the_goal_the_path_does_not_follow_the_hand(asked, left, follows):
    """The last of the way is the chair's, wherever the hand leads."""
    planner = Straight()
    first = update_route(asked(), planner, None, RULES)
    near = replace(first, progress=first.path.length - left)
    later = update_route(asked(10, authority=hand(0.6, (3.0, 5.0))), planner, near, RULES)
    assert (later.path is not first.path) is follows


@pytest.mark.parametrize(("aside", "follows"), [(0.15, False), (0.25, True)])
def test_a_hand_that_leads_along_the_path_needs_no_other(asked, aside, follows):
    planner = Straight()
    first = update_route(asked(), planner, None, RULES)
    later = update_route(asked(10, authority=hand(0.6, (3.0, 4.0 + aside))), planner, first, RULES)
    assert (later.path is not first.path) is follows


def test_the_hand_is_not_followed_beyond_where_the_chair_docks(asked):
    """The path is 7 m long; a hand that leads 6 m along it and 1 m aside is followed for 5.5 m."""
    planner = Straight()
    first = update_route(asked(), planner, None, RULES)
    led = update_route(asked(10, authority=hand(0.6, (8.0, 5.0))), planner, first, RULES)
    begins = led.path.points[0]
    assert first.path.length - RULES.docking_distance - 0.7 < begins[0] - START[0] <= 5.5
    assert begins[1] > START[1]


def test_little_is_spent_on_following_the_hand_and_all_on_a_blocked_way(asked):
    steered, blocked = Straight(), Straight()
    state = update_route(asked(), steered, None, RULES)
    update_route(asked(10, authority=hand(0.6, (3.0, 5.0))), steered, state, RULES)
    for k in (0, 1, 20):
        state = update_route(
            asked(k, walls=SHUT if k else FREE), blocked, state if k else None, RULES
        )
    assert [each.effort for each in steered.asked] == [1.0, RULES.steering_effort]
    assert [each.effort for each in blocked.asked] == [1.0, 1.0]


def test_it_then_starts_where_the_hand_leads_as_far_as_the_chair_fits(asked, chair):
    planner = Straight()
    state = update_route(asked(), planner, None, RULES)
    steered = update_route(asked(10, authority=hand(0.6, (3.0, 5.0))), planner, state, RULES)
    np.testing.assert_allclose(steered.path.points[0], [3.0, 5.0])
    # a wall at y = 4.6 leaves the chair's half width and the rider's 0.05 m of clearance
    grid = room(boxes=[(0.0, 4.6, 12.0, 8.0)])
    fits = 4.6 - chair.inscribed_radius - 0.05
    bounded = update_route(
        asked(10, authority=hand(0.6, (3.0, 5.0)), walls=distance_field(grid)),
        planner,
        state,
        RULES,
    )
    assert fits - 0.1 - 1e-6 <= bounded.path.points[0, 1] <= fits  # the states are 0.1 m apart


# ------------------------------------------------------------------ when there is no path


def test_without_any_path_the_error_goes_on(asked):
    error = NoPath(start=(0.0, 0.0), goal=(1.0, 1.0), needed=0.3)
    with pytest.raises(NoPath):
        update_route(asked(), Straight(error), None, RULES)
    planner = Straight()
    state = update_route(asked(), planner, None, RULES)
    planner.error = error
    with pytest.raises(NoPath):
        update_route(asked(1, request=request(goal=(8.0, 6.0))), planner, state, RULES)


def test_a_path_there_is_is_kept_when_no_better_one_is_found(asked):
    planner = Straight()
    state = update_route(asked(), planner, None, RULES)
    planner.error = NoPath(start=(0.0, 0.0), goal=(1.0, 1.0), needed=0.3)
    later = update_route(asked(30, stalled=True), planner, state, RULES)
    assert later.path is state.path
    assert len(planner.asked) == 2


# ------------------------------------------------------------------ wishes


def test_a_wish_is_dropped_once_it_is_passed_and_measured_from_where_it_was_made(asked):
    planner = Straight()
    wishes = (
        Wish(points=np.array([[4.0, 4.5]])),
        Wish(kind="avoid", points=np.array([[4.0, 3.0]]), radius=0.5),
        Wish(points=np.array([[8.0, 4.5]])),
    )
    wished = request(wishes=wishes)
    state = update_route(asked(request=wished), planner, None, RULES)
    on = replace(state, progress=3.0)  # at x = 5: past the first, before the last
    later = update_route(asked(20, request=wished, stalled=True), planner, on, RULES)
    assert planner.asked[-1].wishes == wishes[1:]
    np.testing.assert_array_equal(planner.asked[-1].wish_origin, START[:2])
    assert later.wishes == wishes[1:]


# ------------------------------------------------------------------ progress checker

HERE = np.zeros(2)


def test_progress_is_counted_in_steps_that_matter():
    rules, memory, since = ProgressParameters(min_progress=0.3), None, []
    # way left at each second: 0.2 m a second, then nothing, then on
    for t, left in enumerate([5.0, 4.8, 4.6, 4.6, 4.6, 4.4, 4.2]):
        memory = check_progress(left, float(t), 0.0, memory, rules, position=HERE)
        since.append(memory.since)
    assert since == [0.0, 0.0, 2.0, 2.0, 2.0, 2.0, 6.0]


def test_a_new_path_starts_anew_and_going_back_is_no_progress():
    rules = ProgressParameters(min_progress=0.3)
    memory = check_progress(5.0, 0.0, 0.0, None, rules, position=HERE)
    back = check_progress(6.0, 1.0, 0.0, memory, rules, position=HERE)
    assert (back.remaining, back.since) == (5.0, 0.0)
    longer = check_progress(6.0, 1.0, 1.0, memory, rules, position=HERE)
    assert (longer.remaining, longer.since) == (6.0, 1.0)


def test_turning_towards_the_path_is_progress_and_turning_to_and_fro_is_not():
    rules, memory, since = ProgressParameters(min_turn=0.5), None, []
    # it turns away to give way, then about on the spot, and away and back once more
    for t, turn in enumerate([0.1, 1.5, 3.0, 2.2, 1.4, 0.2, 2.0, 0.2]):
        memory = check_progress(5.0, float(t), 0.0, memory, rules, position=HERE, turn=turn)
        since.append(memory.since)
    assert since == [0.0, 0.0, 0.0, 3.0, 4.0, 5.0, 5.0, 5.0]
    # the path has become shorter: a turn counts again
    for t, (left, turn) in enumerate([(4.0, 0.1), (4.0, 2.0), (4.0, 1.0)], 8):
        memory = check_progress(left, float(t), 0.0, memory, rules, position=HERE, turn=turn)
    assert memory.since == 10.0


def test_a_chair_that_stands_while_the_path_follows_the_hand_loses_time():
    """Each half second there is a new path: were each a fresh start, the ride never stalled."""
    rules, memory = ProgressParameters(min_progress=0.3), None
    for tick in range(8):
        t = 0.5 * tick
        memory = check_progress(
            5.0 + 0.1 * tick, t, t, memory, rules, position=HERE, replanned=True
        )
        assert memory.since == 0.0
    moved = check_progress(
        6.0, 4.0, 4.0, memory, rules, position=np.array([0.3, 0.0]), replanned=True
    )
    assert moved.since == 4.0


def test_a_chair_that_is_to_stand_or_cannot_see_loses_no_time():
    rules = ProgressParameters(min_progress=0.3)
    memory = check_progress(5.0, 0.0, 0.0, None, rules, position=HERE)
    rested = check_progress(5.0, 1.0, 0.0, memory, rules, position=HERE, hold=True)
    assert rested.since == 1.0
    # after a while without a look the clock starts anew
    assert check_progress(5.0, 20.0, 0.0, memory, rules, position=HERE).since == 20.0
    assert check_progress(5.0, 1.0, 0.0, memory, rules, position=HERE).since == 0.0


# ------------------------------------------------------------------ walls about the chair


@pytest.mark.parametrize("position", [(6.0, 4.0), (0.3, 0.3), (11.9, 7.9)])
def test_the_window_about_the_chair_is_the_maps_own_field(position):
    grid = room(boxes=[(5.0, 2.0, 5.5, 3.0)])
    static = distance_field(grid)
    live = LiveObstacles(corner=[10, 10], occupied=np.zeros((20, 20)), version=0)
    window = local_walls(grid, static, live, NO_CELLS, np.array(position), 1.5)
    inside = np.clip(position, [0.2, 0.2], [11.8, 7.8])
    points = inside + np.random.default_rng(0).uniform(-0.15, 0.15, (50, 2))
    np.testing.assert_allclose(window.at(points), static.at(points), atol=1e-5)


def test_a_chair_that_believes_itself_off_the_map_is_beside_a_wall():
    grid = room()
    none = LiveObstacles(corner=[0, 0], occupied=np.zeros((4, 4)), version=0)
    window = local_walls(grid, distance_field(grid), none, NO_CELLS, np.array([-30.0, 90.0]), 1.5)
    assert window.at(np.array([-30.0, 90.0])) < 0.0


def test_live_obstacles_come_nearer_than_the_maps_and_nowhere_farther():
    grid = room()
    static = distance_field(grid)
    occupied = np.zeros((40, 40), dtype=np.uint8)
    occupied[20, 20] = 1
    live = LiveObstacles(corner=[60, 100], occupied=occupied, version=1)
    window = local_walls(grid, static, live, NO_CELLS, np.array([6.0, 4.0]), 3.0)
    # the cell (80, 120) has its centre at (6.025, 4.025); its side is 0.025 m before that
    assert window.at(np.array([6.525, 4.025])) == pytest.approx(0.5 - 0.025, abs=1e-5)
    points = np.random.default_rng(0).uniform([3.2, 1.2], [8.8, 6.8], (200, 2))
    assert (window.at(points) <= static.at(points) + 1e-6).all()
    assert identical(local_walls(grid, static, live, NO_CELLS, np.array([6.0, 4.0]), 3.0), window)
