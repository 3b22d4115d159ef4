"""Hybrid A* finds drivable paths, with turns on the spot where they are allowed."""

import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.planning.floors import CHAIR

from cohelm.maps import signed_distance
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.path_refinement.configuration_space import (
    ConfigurationSpace,
    infeasible_points,
)
from cohelm.planning.path_refinement.footprint import (
    directions,
    footprint_model,
    overlaps,
    overlaps_along,
    turn_between,
)
from cohelm.planning.path_refinement.hybrid_astar import (
    SearchLimits,
    drive_arc,
    dubins_words,
    search_poses,
)
from cohelm.planning.path_refinement.local_repair import RefinedLine, repair
from cohelm.planning.path_refinement.smoothing import curvature_of
from cohelm.planning.path_refinement.waypoint_chaining import PoseBudget, all_headings

RES = 0.05
RADIUS = CHAIR.inscribed_radius
NONE = np.empty(0, dtype=np.int64)


def space_of(blocked):
    clearance = signed_distance(blocked, RES)
    weights = Weights.of(np.where(clearance > RADIUS, 1.0, np.inf).astype(np.float32))
    body = footprint_model(CHAIR.outline, clearance, RES)
    return ConfigurationSpace(
        footprint=body,
        grown=footprint_model(1.02 * CHAIR.outline, clearance, RES),
        weights=weights.packed,
        heaviest=weights.heaviest,
        clearance=body.clearance,
        floor=RADIUS,
        radius=RADIUS,
        curvature=CHAIR.max_curvature,
    )


def corridor(width, length=8.0, end=False):
    """A corridor along x in solid walls, from x = 1."""
    blocked = np.ones((80, round((length + 2.0) / RES)), dtype=bool)
    half = round(0.5 * width / RES)
    blocked[40 - half : 40 + half, round(1.0 / RES) : round((1.0 + length) / RES)] = False
    return blocked


def check(space, found, start, goal):
    points = found.points
    assert np.allclose(points[[0, -1]], [start[:2], goal[:2]], atol=1e-6)
    assert not infeasible_points(space, points, found.pivots).any()
    steps = np.hypot(*np.diff(points, axis=0).T)
    assert steps.max() < 0.101


@settings(max_examples=100, deadline=None)
@given(
    pose=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1)),
    goal=st.tuples(st.floats(-5, 5), st.floats(-5, 5), st.floats(-3.1, 3.1)),
    to_point=st.booleans(),
)
def test_words_lead_to_the_goal(pose, goal, to_point):
    start, end = np.array(pose), np.array(goal)
    if to_point:
        end[2] = np.nan
    tried = dubins_words(start, end, 0.4)
    found = np.isfinite(tried).all(axis=(1, 2))
    # Arc, line and arc on one side always exists; to a point unless it is inside the circle.
    assert found[:2].all() or to_point
    for word in tried[found]:
        here = start.copy()
        for kappa, length in word:
            there = np.empty(3)
            drive_arc(here, kappa, length, there)
            here = there
        assert here[:2] == pytest.approx(end[:2], abs=1e-6)
        if not to_point:
            assert math.cos(here[2] - end[2]) == pytest.approx(1.0, abs=1e-9)


def test_a_free_floor_is_crossed_in_a_straight_line():
    space = space_of(np.zeros((80, 160), dtype=bool))
    start, goal = np.array([1.5, 2.0, 0.0]), np.array([6.5, 2.0, 0.0])
    found, expansions = search_poses(space, start[None], goal, SearchLimits(1.5, True, 2000))
    check(space, found, start, goal)
    assert np.abs(found.points[:, 1] - 2.0).max() < 1e-9
    assert not len(found.pivots)
    assert expansions <= 2 + 100


@pytest.mark.parametrize("heading", [0.0, 1.0, 2.5, np.pi])
def test_any_heading_is_left_on_a_curve_where_there_is_room(heading):
    space = space_of(np.zeros((160, 160), dtype=bool))
    start, goal = np.array([4.0, 4.0, heading]), np.array([6.0, 4.0, 0.0])
    found, _ = search_poses(space, start[None], goal, SearchLimits(1.5, False, 4000))
    check(space, found, start, goal)
    assert not len(found.pivots)
    first, last = directions(found.points)[[0, -1]]
    assert abs(turn_between(heading, first)) < 0.2
    assert abs(last) < 0.2
    assert curvature_of(found.points).max() <= CHAIR.max_curvature


def test_in_a_bay_wide_enough_to_turn_and_too_small_for_a_curve_it_turns_on_the_spot():
    # A bay 1.7 m square at the end of a corridor 0.9 m wide: 2 × 0.718 m lets the chair turn in
    # it, and an arc of radius 0.305 m about a centre 0.305 m aside sweeps 2 × (0.305 + 0.891) m.
    blocked = corridor(0.9)
    blocked[23:57, round(9.0 / RES) : round(9.7 / RES)] = False
    blocked[23:57, round(8.0 / RES) : round(9.0 / RES)] = False
    blocked = np.pad(blocked, ((0, 0), (0, 20)), constant_values=True)
    space = space_of(blocked)
    start, goal = np.array([3.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    none, _ = search_poses(space, start[None], goal, SearchLimits(7.5, False, 20_000))
    assert none is None
    found, _ = search_poses(space, start[None], goal, SearchLimits(7.5, True, 20_000))
    check(space, found, start, goal)
    assert len(found.pivots) >= 1
    assert (found.points[found.pivots, 0] > 8.0).all()


def test_where_it_cannot_turn_it_cannot():
    space = space_of(corridor(0.9))
    start, goal = np.array([4.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    for pivots in (False, True):
        none, expansions = search_poses(space, start[None], goal, SearchLimits(9.0, pivots, 50_000))
        assert none is None
        assert expansions < 50_000  # everything was tried


def test_the_budget_is_kept():
    space = space_of(corridor(0.9))
    start, goal = np.array([4.0, 2.0, 0.0]), np.array([2.0, 2.0, np.pi])
    assert search_poses(space, start[None], goal, SearchLimits(9.0, True, 50)) == (None, 50)


def test_any_direction_will_do_where_none_is_asked():
    space = space_of(corridor(0.8))
    start, goal = np.array([4.0, 2.0, np.nan]), np.array([2.0, 2.0, np.nan])
    found, _ = search_poses(space, all_headings(start), goal, SearchLimits(2.0, False, 4000))
    check(space, found, start, goal)
    assert abs(turn_between(np.pi, found.start_heading)) < 0.3


# --------------------------------------------------------------------------------- both gears


def poses_of(found):
    """(poses (k, 3) with true headings, True (k,) where the chair drives backwards)."""
    ends = [0, *found.cusps, len(found.points) - 1]
    poses, backward = [], []
    for i, (a, b) in enumerate(itertools.pairwise(ends)):
        back = found.backs_out ^ (i % 2 == 1)
        along = directions(found.points[a : b + 1]) + (math.pi if back else 0.0)
        poses.append(np.column_stack([found.points[a:b], along]))
        backward += [back] * (b - a)
    return np.concatenate(poses), np.array(backward)


def check_gears(space, found, start, goal):
    """Nothing overlaps at the true headings, which turn no faster than the chair can."""
    assert np.allclose(found.points[[0, -1]], [start[:2], goal[:2]], atol=1e-6)
    poses, _ = poses_of(found)
    assert not any(overlaps(space.footprint, *pose) for pose in poses)
    turns = np.abs([turn_between(a, b) for a, b in itertools.pairwise(poses[:, 2])])
    turns[np.concatenate([found.pivots - 1, found.pivots]).clip(0, len(turns) - 1)] = 0.0
    assert turns.max(initial=0.0) <= 0.1 * CHAIR.max_curvature * 1.05


def lift():
    """A lift of 1.1 x 1.4 m with a door of 0.9 m at the left end of a hall of 2 x 3 m."""
    blocked = np.ones((80, 120), dtype=bool)
    blocked[29:51, 20:48] = False  # the car, x from 1.0 to 2.4 m
    blocked[31:49, 48:50] = False  # its door
    blocked[20:60, 50:110] = False  # the hall, to x = 5.5 m
    return blocked


BOTH = SearchLimits(3.0, True, 20_000, reverse=True)


def test_a_dead_end_is_left_backwards():
    space = space_of(corridor(0.9))
    start, goal = np.array([7.0, 2.0, 0.0]), np.array([2.0, 2.0, np.nan])
    found, _ = search_poses(space, start[None], goal, BOTH)
    check_gears(space, found, start, goal)
    assert found.backs_out
    assert not len(found.cusps)
    # five metres backwards, worth ten, on free cells
    assert found.cost == pytest.approx(10.0, abs=0.2)


def test_a_lift_is_left_backwards_and_the_hall_crossed_forward():
    space = space_of(lift())
    start, goal = np.array([1.7, 2.0, np.pi]), np.array([4.6, 2.0, 0.0])
    found, _ = search_poses(space, start[None], goal, BOTH)
    check_gears(space, found, start, goal)
    assert found.backs_out
    _, backward = poses_of(found)
    assert not backward[-5:].any()
    none, _ = search_poses(space, start[None], goal, BOTH._replace(reverse=False))
    assert none is None


def test_a_place_with_room_for_the_rear_alone_is_entered_backwards():
    space = space_of(lift())
    start = np.array([4.8, 2.0, np.pi])
    goal = np.array([1.52, 2.0, np.nan])  # 0.52 m before the wall; the front reaches 0.65 m
    found, _ = search_poses(space, all_headings(goal), start, BOTH._replace(from_end=True))
    check_gears(space, found, start, goal)
    poses, backward = poses_of(found)
    assert backward[-1]
    assert abs(turn_between(poses[-1, 2], 0.0)) < 0.2


def test_the_other_end_of_the_search_has_the_same_costs():
    space = space_of(lift())
    start, goal = np.array([1.7, 2.0, np.pi]), np.array([4.0, 2.0, np.pi])
    out, _ = search_poses(space, start[None], goal, BOTH)
    back, _ = search_poses(space, goal[None], start, BOTH._replace(from_end=True))
    assert back.cost == pytest.approx(out.cost, rel=0.1)
    assert back.backs_out == out.backs_out
    assert back.start_heading == pytest.approx(start[2])


def test_a_cost_that_must_not_be_reached_is_not():
    space = space_of(corridor(0.9))
    start, goal = np.array([7.0, 2.0, 0.0]), np.array([2.0, 2.0, np.nan])
    none, _ = search_poses(space, start[None], goal, BOTH._replace(below=9.0))
    assert none is None


# ------------------------------------------------------------------------------------ repairs


def test_a_line_that_fits_is_left_alone():
    space = space_of(corridor(1.0))
    line = np.stack([np.linspace(2.0, 7.0, 51), np.full(51, 2.0)], axis=-1)
    budget = PoseBudget(1000)
    fitted = repair(space, RefinedLine(points=line, pivots=NONE), np.empty((0, 2)), budget)
    assert np.array_equal(fitted.points, line)
    assert fitted.stuck is None
    assert budget.left == 1000


def test_a_start_beside_a_wall_is_left_along_it():
    # A wall at y = 1; the line leaves it at right angles, where the chair's back would be in it.
    blocked = np.zeros((100, 160), dtype=bool)
    blocked[:20] = True
    space = space_of(blocked)
    line = np.stack([np.full(26, 4.0), np.linspace(1.4, 3.9, 26)], axis=-1)
    assert overlaps_along(space.footprint, line)[0]
    fitted = repair(
        space, RefinedLine(points=line, pivots=NONE), np.empty((0, 2)), PoseBudget(12_000)
    )
    assert fitted.stuck is None
    assert not len(fitted.pivots)
    assert np.allclose(fitted.points[[0, -1]], line[[0, -1]])
    assert not infeasible_points(space, fitted.points, fitted.pivots).any()
    # The rear corner stays off the wall: 0.46 sin θ + 0.305 cos θ ≤ 0.4, so sin θ ≤ 0.213.
    assert abs(math.sin(directions(fitted.points)[0])) < 0.213


def test_a_pin_on_a_stretch_that_is_replaced_is_still_passed():
    blocked = np.zeros((120, 200), dtype=bool)
    blocked[52:56, 96:100] = True  # beside the corner, where the chair's side swings
    space = space_of(blocked)
    east = np.stack([np.arange(2.0, 5.01, 0.1), np.full(31, 3.2)], axis=-1)
    north = np.stack([np.full(20, 5.0), np.arange(3.3, 5.25, 0.1)], axis=-1)
    line = np.concatenate([east, north])
    assert infeasible_points(space, line, np.empty(0, dtype=np.int64)).any()
    waypoint = np.array([[5.0, 3.2]])
    fitted = repair(space, RefinedLine(points=line, pivots=NONE), waypoint, PoseBudget(12_000))
    assert fitted.stuck is None
    assert np.hypot(*(fitted.points - waypoint).T).min() < RES


def test_where_nothing_fits_the_place_is_told():
    # Straight along a corridor 0.9 m wide, and back: nothing turns there.
    space = space_of(corridor(0.9))
    line = np.stack([[*np.linspace(3, 6, 31), *np.linspace(5.9, 3.1, 29)], np.full(60, 2.0)], -1)
    fitted = repair(space, RefinedLine(points=line, pivots=NONE), line[30:31], PoseBudget(6000))
    assert fitted.stuck == pytest.approx([6.0, 2.0], abs=0.5)


def test_no_loop_is_driven_where_a_wider_curve_does():
    # A corridor 1.2 m wide bends at a right angle; the line takes the bend as sharp as it can.
    blocked = np.ones((140, 140), dtype=bool)
    blocked[40:64, 10:104] = blocked[40:130, 80:104] = False
    space = space_of(blocked)
    east = np.stack([np.arange(1.5, 4.61, 0.1), np.full(32, 2.6)], axis=-1)
    north = np.stack([np.full(28, 4.6), np.arange(2.7, 5.41, 0.1)], axis=-1)
    line = RefinedLine(points=np.concatenate([east, north]), pivots=NONE)
    fitted = repair(space, line, np.empty((0, 2)), PoseBudget(12_000))
    assert fitted.stuck is None
    assert not len(fitted.pivots)
    turns = np.diff(np.unwrap(directions(fitted.points)))
    assert np.ptp(np.cumsum(turns)) < np.pi  # a loop adds a whole turn
