"""Paths are clear and straight, wishes are reported, and errors have a reason."""

import os
import warnings
from dataclasses import replace
from pathlib import Path as File

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.planning.floors import CHAIR, problem, room

from cohelm import plugins
from cohelm.errors import (
    GoalBlocked,
    NoPath,
    OutsideMap,
    PlanningTimeout,
    StartBlocked,
)
from cohelm.geometry import arc_length, nearest_on_polyline, transform
from cohelm.maps import MapWarning, OccupancyGrid, distance_field, read_map
from cohelm.messages import LiveObstacles, Wish
from cohelm.planning import AStar, SoftPreferenceField, SoftVia, UserPreferenceField

PLANNERS = [plugins.build("global_planners", name) for name in plugins.names("global_planners")]
EXACT = [AStar(), UserPreferenceField(), SoftPreferenceField(), SoftVia()]
"""Those whose path comes nearer to a point if it moves at all."""
RAYLEIGH = {"density": "rayleigh"}
needed = CHAIR.inscribed_radius + 0.05


def wall_with_door(width, resolution=0.05):
    """A 10 × 6 m room, halved at x = 5 by a wall 0.2 m thick with a door about y = 3."""
    low, high = 3.0 - width / 2.0, 3.0 + width / 2.0
    return room(10, 6, resolution, boxes=[(4.9, 0, 5.1, low), (4.9, high, 5.1, 6)])


def crossing(points, x):
    """y where a polyline crosses the line at x."""
    i = np.flatnonzero((points[:-1, 0] < x) & (points[1:, 0] >= x))
    assert len(i) == 1
    a, b = points[i[0]], points[i[0] + 1]
    return a[1] + (b[1] - a[1]) * (x - a[0]) / (b[0] - a[0])


def check(path, task):
    """What every path must be."""
    assert np.array_equal(path.points[0], task.start)
    assert np.array_equal(path.points[-1], task.goal)
    steps = np.hypot(*np.diff(path.points, axis=0).T)
    assert path.length == pytest.approx(steps.sum())
    assert steps.max() < 0.11
    walls = distance_field(task.grid)
    ends = min(walls.at(task.start), walls.at(task.goal))
    dense = (path.points[:-1, None] * [[0.75], [0.5], [0.25]]) + (
        path.points[1:, None] * [[0.25], [0.5], [0.75]]
    )
    clear = walls.at(np.concatenate([path.points, dense.reshape(-1, 2)]))
    # Between the points, a curved line's chords may come a millimetre nearer than the points do.
    assert clear.min() >= min(needed, ends) - 2e-3
    return clear.min()


@pytest.mark.parametrize("planner", PLANNERS)
def test_free_space_is_crossed_in_a_straight_line(planner):
    task = problem(room(12, 8), (2.01, 2.03), (10.3, 5.57))
    path = planner.plan(task)
    check(path, task)
    assert path.length == pytest.approx(np.hypot(10.3 - 2.01, 5.57 - 2.03), rel=1e-6)
    # A* itself may only walk in eight directions: octile distance of the cells, 166 by 70.
    assert path.cost == pytest.approx((166 + 70 * (np.sqrt(2) - 1)) * 0.05, abs=0.06)


@pytest.mark.parametrize("width", [0.8, 0.9, 1.0, 1.2])
@pytest.mark.parametrize("start_y", [1.0, 3.0, 5.0])
def test_doors_are_crossed_about_the_middle(width, start_y):
    # The chair of 0.61 m keeps 0.05 m on either side: in a door of 0.8 m it may be 0.045 m aside.
    aside = max(0.5 * (width - 0.61) - 0.05, 0.05)
    task = problem(wall_with_door(width), (1.5, start_y), (8.5, 1.0))
    path = AStar().plan(task)
    check(path, task)
    for x in (4.9, 5.0, 5.1):
        assert crossing(path.points, x) == pytest.approx(3.0, abs=min(aside, 0.1))


def test_a_door_narrower_than_the_chair_is_closed():
    # 0.60 m between the jambs, and the chair with its clearance is 0.71 m wide.
    with pytest.raises(NoPath) as error:
        AStar().plan(problem(wall_with_door(0.6), (1.5, 3.0), (8.5, 3.0)))
    assert error.value.needed == pytest.approx(needed)


def test_keeps_its_distance_where_there_is_room():
    box = (4.0, 0.0, 6.0, 3.0)
    task = problem(room(10, 6, boxes=[box]), (1.0, 1.0), (9.0, 1.0))
    assert AStar().plan(task).length > 8.0
    low = AStar(AStar.Parameters(cost_weight=0.0)).plan(task)
    high = AStar().plan(task)
    around = distance_field(room(10, 6, boxes=[box]))
    inner = slice(10, -10)
    assert around.at(high.points[inner]).min() >= 0.6
    assert around.at(low.points[inner]).min() < 0.5


@pytest.mark.parametrize("mirror", [(1, -1), (-1, 1)])
def test_a_mirrored_floor_costs_the_same(mirror):
    grid = room(10, 6, boxes=[(3, 0, 4, 3.5), (6, 2, 7, 6)])
    flipped = OccupancyGrid(
        data=grid.data[:: mirror[1], :: mirror[0]], resolution=grid.resolution, X_MG=grid.X_MG
    )
    start, goal = np.array([1.02, 1.03]), np.array([9.02, 4.52])
    path = AStar().plan(problem(grid, start, goal))
    size = np.array([10.0, 6.0])
    across = [np.where(np.array(mirror) < 0, size - p, p) for p in (start, goal)]
    mirrored = AStar().plan(problem(flipped, *across))
    assert mirrored.cost == pytest.approx(path.cost, rel=1e-12)


def test_a_turned_map_turns_the_path():
    boxes = [(3, 0, 4, 3.5)]
    X = np.array([5.0, -2.0, 0.7])
    points = np.array([[1.02, 1.03], [8.52, 1.52]])
    straight = AStar().plan(problem(room(10, 6, boxes=boxes), *points))
    turned = AStar().plan(problem(room(10, 6, boxes=boxes, X_MG=X), *transform(X, points)))
    assert turned.cost == pytest.approx(straight.cost, rel=1e-9)
    assert np.allclose(turned.points, transform(X, straight.points), atol=1e-6)


def test_the_same_problem_gives_the_same_path():
    task = problem(wall_with_door(1.0), (1.5, 1.0), (8.5, 5.0), prefer=[(5.0, 3.0)])
    for planner in PLANNERS:
        a, b = planner.plan(task), planner.plan(task)
        assert a.points.tobytes() == b.points.tobytes()


# ------------------------------------------------------------------------------------ errors


def test_a_start_inside_an_obstacle():
    with pytest.raises(StartBlocked) as error:
        AStar().plan(problem(room(6, 6, boxes=[(2, 2, 4, 4)]), (3.0, 3.0), (1.0, 5.0)))
    assert error.value.needed == CHAIR.inscribed_radius
    assert error.value.clearance < 0.0


def test_a_goal_beside_a_wall():
    # The wall's inner face is at 0.05, the goal's cell centre at 0.275.
    with pytest.raises(GoalBlocked) as error:
        AStar().plan(problem(room(6, 6), (3.0, 3.0), (0.26, 3.0)))
    assert error.value.clearance == pytest.approx(0.225)
    assert error.value.needed == pytest.approx(needed)


@pytest.mark.parametrize("outside", [(-1.0, 3.0), (3.0, 6.5), (np.nan, 3.0), (np.inf, 3.0)])
def test_a_point_off_the_map(outside):
    grid = room(6, 6)
    with pytest.raises(OutsideMap, match="start"):
        AStar().plan(problem(grid, outside, (3.0, 3.0)))
    with pytest.raises(OutsideMap, match="goal"):
        AStar().plan(problem(grid, (3.0, 3.0), outside))


def test_no_way():
    with pytest.raises(NoPath):
        AStar().plan(problem(room(10, 6, boxes=[(5, 0, 5.2, 6)]), (2, 3), (8, 3)))


def test_a_live_obstacle_closes_the_door():
    grid = wall_with_door(1.2)
    task = problem(grid, (1.5, 3.0), (8.5, 3.0))
    AStar().plan(task)
    row, col = grid.cells((5.0, 3.0))
    live = LiveObstacles(corner=(row - 3, col - 3), occupied=np.ones((6, 6)), version=1)
    with pytest.raises(NoPath):
        AStar().plan(problem(grid, (1.5, 3.0), (8.5, 3.0), live=live))


def test_the_budget():
    planner = AStar(AStar.Parameters(max_expansions=20))
    with pytest.raises(PlanningTimeout):
        planner.plan(problem(room(10, 6), (1, 1), (9, 5)))


@pytest.mark.parametrize("gap", [0.0, 0.01, 0.04])
def test_a_chair_that_stopped_beside_a_wall_can_leave(gap):
    # Planning keeps 0.355 m; the chair touches at 0.305.
    start = (0.05 + CHAIR.inscribed_radius + gap, 3.0)
    task = problem(room(10, 6), start, (8.0, 3.0))
    path = AStar().plan(task)
    check(path, task)
    clear = distance_field(task.grid).at(path.points)
    # It leaves the wall's neighbourhood at once: 5 cm are missing, and it takes no half metre.
    assert (clear[6:] >= needed).all()


def test_goal_and_start_in_one_place():
    path = AStar().plan(problem(room(6, 6), (3.0, 3.0), (3.0, 3.0)))
    assert path.length == 0.0
    assert path.cost == 0.0


# ------------------------------------------------------------------------------------ wishes


def island(**more):
    """Two equal ways round a box."""
    return problem(room(12, 9, boxes=[(4, 3, 8, 6)]), (1.5, 4.5), (10.5, 4.5), **more)


@pytest.mark.parametrize("planner", PLANNERS)
def test_without_wishes_every_planner_is_plain(planner):
    plain, path = AStar().plan(island()), planner.plan(island())
    assert np.array_equal(plain.points, path.points)
    assert np.array_equal(path.points, path.without_wishes)
    assert path.cost == plain.cost
    assert path.wishes.closest.shape == (0,)
    assert path.wishes.extra_length == path.wishes.extra_cost == 0.0
    assert plugins.build("global_planners", path.method).__class__ is planner.__class__


@pytest.mark.parametrize("planner", EXACT[1:])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_wish_chooses_the_side(planner, side):
    task = island(prefer=[(6.0, 4.5 + side * 2.8)])
    path = planner.plan(task)
    check(path, task)
    assert np.sign(crossing(path.points, 6.0) - 4.5) == side


@pytest.mark.parametrize("planner", EXACT[1:])
def test_the_report_says_what_the_wish_does(planner):
    point = (6.0, 8.0)
    task = island(prefer=[point])
    plain, path = AStar().plan(task), planner.plan(task)
    for p in (plain, path):
        nearest = nearest_on_polyline(p.points, *point)[1]
        assert p.wishes.closest.tolist() == [pytest.approx(nearest)]
    assert plain.wishes.extra_cost == plain.wishes.extra_length == 0.0
    assert path.wishes.closest[0] <= plain.wishes.closest[0] + 0.05  # half a step of the path
    assert np.array_equal(path.without_wishes, plain.points)
    assert path.wishes.extra_length == pytest.approx(path.length - plain.length)
    assert path.wishes.extra_cost == pytest.approx(path.cost - plain.cost)
    # A* is optimal under the costs without wishes, so a wish never makes a path cheaper.
    assert path.wishes.extra_cost >= -1e-9


@pytest.mark.parametrize("planner", EXACT)
def test_a_zone_to_avoid_has_its_price_too(planner):
    plain = AStar().plan(island())
    side = float(np.interp(6.0, *plain.points.T))
    zone = Wish(kind="avoid", points=np.array([[6.0, side]]), radius=1.0)
    path = planner.plan(replace(island(), wishes=(zone,)))
    assert (np.interp(6.0, *path.points.T) - 4.5) * (side - 4.5) < 0.0  # the other side
    assert path.wishes.avoided[0] > 0.0
    assert path.wishes.extra_cost >= 0.0
    assert np.array_equal(path.without_wishes, plain.points)


@pytest.mark.parametrize("reach", [0.3, 0.8, 1.5])
def test_the_compromise_comes_as_near_as_it_paid_for(reach):
    # In the open, with λ = 2, a point beside the way is passed through to a cell and its rounding.
    task = problem(room(12, 8), (1.5, 4.0), (10.5, 4.0), prefer=[(6.0, 4.0 + reach)])
    path = SoftVia().plan(task)
    check(path, task)
    assert path.wishes.closest[0] < 0.08
    assert path.length < 2.0 * np.hypot(4.5, reach) + 0.1


def test_what_cannot_be_reached_is_a_compromise():
    # The box's middle: the way need not leave its own side of it, 1.5 m and the chair's clearance.
    path = SoftVia().plan(island(prefer=[(6.0, 4.5)]))
    assert 1.5 + needed - 0.05 <= path.wishes.closest[0] < 2.6


def test_every_attracting_point_is_reported_and_no_other():
    wishes = (
        Wish(points=np.array([[6.0, 8.0], [2.0, 2.0]])),
        Wish(kind="avoid", points=np.array([[6.0, 1.0]]), radius=0.5),
        Wish(points=np.array([[10.0, 7.0]])),
    )
    task = replace(island(), wishes=wishes)
    for planner in PLANNERS:
        assert planner.plan(task).wishes.closest.shape == (3,)


POINTS = st.tuples(st.floats(-50, 60), st.floats(-50, 60))
WISHES = st.builds(
    Wish,
    kind=st.sampled_from(["attract", "stroke", "avoid"]),
    points=st.lists(POINTS, max_size=3).map(lambda points: np.array(points).reshape(-1, 2)),
    radius=st.floats(0.0, 1.0),
)


@settings(max_examples=40, deadline=None)
@given(
    wishes=st.lists(WISHES, max_size=3).map(tuple),
    planner=st.sampled_from(
        [*PLANNERS, plugins.build("global_planners", {"use": "upf", "preference": RAYLEIGH})]
    ),
)
def test_no_wish_breaks_a_plan(wishes, planner):
    task = replace(island(), wishes=wishes)
    path = planner.plan(task)
    check(path, task)
    for values in (path.wishes.closest, path.wishes.along, path.wishes.avoided):
        assert np.isfinite(values).all()
    assert np.isfinite(path.cost)
    assert np.isfinite([path.wishes.extra_length, path.wishes.extra_cost]).all()


@pytest.mark.parametrize("planner", PLANNERS)
def test_a_wish_on_the_robot_itself(planner):
    task = island(prefer=[(1.5, 4.5)])
    assert planner.plan(task).wishes.closest[0] == 0.0


# ------------------------------------------------------------------------------------ real maps


@pytest.mark.data
@pytest.mark.parametrize(
    "name",
    [
        "utexas_gdc_1",
        pytest.param("aws_hospital_sim", marks=pytest.mark.slow),
        pytest.param("intel_lab", marks=pytest.mark.slow),
        "nav2_depot",
    ],
)
def test_real_floors(name):
    data = os.environ.get("COHELM_DATA")
    file = File(data or "") / "ros_maps" / f"{name}.yaml"
    if not data or not file.is_file():
        pytest.skip(f"COHELM_DATA names no folder with ros_maps/{name}.yaml")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MapWarning)
        grid = read_map(file)
    free = np.argwhere(distance_field(grid).distance > 0.45)
    rng = np.random.default_rng(0)
    planned = 0
    for _ in range(12):
        start, goal, wish = grid.centres(free[rng.integers(len(free), size=3)])
        task = problem(grid, start, goal, prefer=[wish])
        for planner in PLANNERS:
            try:
                path = planner.plan(task)
            except NoPath:
                continue
            check(path, task)
            planned += 1
            turns = np.abs(np.diff(np.unwrap(np.arctan2(*np.diff(path.points, axis=0).T[::-1]))))
            turns[path.pivots - 1] = turns[path.cusps - 1] = 0.0
            assert turns.max() < np.pi / 3  # no zigzag: at most 60° from point to point
            assert len(path.pivots) <= 2  # about the wish and at an end, if at all
            assert arc_length(path.points)[-1] == pytest.approx(path.length)
    assert planned > 6
