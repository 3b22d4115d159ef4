"""Doors and corners: the footprint passes, or the error names the place."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.floors import CHAIR, room

from cohelm.errors import NoPath
from cohelm.geometry import transform
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid, signed_distance
from cohelm.messages import Wish
from cohelm.planning import AStar, RouteProblem
from cohelm.planning.path_refinement.footprint import footprint_model, overlaps_along
from cohelm.planning.path_refinement.smoothing import curvature_of

WIDTH = 2.0 * CHAIR.inscribed_radius  # 0.61 m
AT = np.array([3.0, 2.0])  # the middle of every door


def halved(width, resolution, turned=0.0):
    """A 6 × 4 m room, halved by a wall 0.1 m thick with a door; the wall may be turned about it."""
    grid = room(6.0, 4.0, resolution)
    cells = np.stack(np.meshgrid(*(np.arange(n) for n in grid.shape), indexing="ij"), axis=-1)
    along, across = np.moveaxis(transform((0.0, 0.0, -turned), grid.centres(cells) - AT), -1, 0)
    wall = (np.abs(along) < 0.05) & (np.abs(across) > 0.5 * width)
    data = np.where(wall | grid.blocked(), OCCUPIED, FREE)
    return OccupancyGrid(data=data, resolution=resolution, X_MG=np.zeros(3))


def across(grid, **more):
    """From one side of the door to the other."""
    start, goal = np.array([1.2, 1.4]), np.array([4.8, 2.6])
    return RouteProblem(grid=grid, robot=CHAIR, start=start, goal=goal, **more)


def check(task, path):
    """What every path must be: the whole chair fits along it and can follow it."""
    assert np.array_equal(path.points[[0, -1]], [task.start, task.goal])
    assert task.grid.X_MG.tolist() == [0.0, 0.0, 0.0]
    clearance = clearance_of(task)
    body = footprint_model(CHAIR.outline, clearance, task.grid.resolution)
    assert not overlaps_along(body, path.points).any()
    bends = curvature_of(path.points)
    bends[path.pivots] = 0.0
    assert bends.max() <= CHAIR.max_curvature * (1.0 + 1e-6)


def clearance_of(task):
    return signed_distance(task.grid.blocked(), task.grid.resolution)


@pytest.mark.parametrize("turned", [0.0, np.pi / 6.0])
def test_a_door_two_centimetres_too_narrow_is_refused_by_name(turned):
    task = across(halved(WIDTH - 0.02, 0.01, turned))
    with pytest.raises(NoPath) as error:
        AStar().plan(task)
    passage = error.value.passage
    assert np.hypot(*(np.array(passage.point) - AT)) < 0.2
    # A jamb is known to a cell on either side; turned, its squares stand out by half a diagonal.
    assert passage.width == pytest.approx(WIDTH - 0.02, abs=0.015)
    assert passage.needed == pytest.approx(WIDTH)
    assert "0.01 m" in str(error.value)


@pytest.mark.parametrize("turned", [0.0, np.pi / 6.0])
@pytest.mark.parametrize("resolution", [0.01, 0.05])
def test_a_door_ten_centimetres_wider_is_passed(turned, resolution):
    task = across(halved(WIDTH + 0.10, resolution, turned))
    path = AStar().plan(task)
    check(task, path)
    assert not len(path.pivots)


def test_a_coarse_map_says_that_it_knows_no_better():
    with pytest.raises(NoPath, match=r"cells are 0\.05 m.*known no better") as error:
        AStar().plan(across(halved(WIDTH - 0.02, 0.05)))
    # 12 cells are free between the jambs, since a cell is blocked where its centre is.
    assert error.value.passage.width == pytest.approx(0.60)
    assert "\n" not in str(error.value)


def elbow(width, resolution=0.05, side=6.0, inner=1.6):
    """An L of two corridors of one width in solid walls; it goes up at the left, then right."""
    n = round(side / resolution)
    w, edge = round(width / resolution), round(inner / resolution)
    data = np.full((n, n), OCCUPIED)
    data[edge:-edge, edge : edge + w] = FREE
    data[-edge - w : -edge, edge:-edge] = FREE
    return OccupancyGrid(data=data, resolution=resolution, X_MG=np.zeros(3))


def round_the_elbow(width, **more):
    grid = elbow(width, **more)
    start = np.array([1.6 + 0.5 * width, 2.2])
    goal = np.array([3.5, 4.4 - 0.5 * width])
    return RouteProblem(grid=grid, robot=CHAIR, start=start, goal=goal)


def test_a_corner_that_the_disc_rounds_and_the_chair_does_not_is_refused():
    # The widest rectangle that a unicycle may turn in place needs two corners' sweep; below the
    # width at which a 1.11 × 0.61 m box passes a corner at all, even sliding, nothing helps:
    # its diagonal position needs w with (w − 0.61 cos 45° ...) > 0, about 0.82 m.
    task = round_the_elbow(0.80)
    with pytest.raises(NoPath, match="cannot turn") as error:
        AStar().plan(task)
    passage = error.value.passage
    assert passage.turns
    corner = np.array([1.6 + 0.40, 4.4 - 0.40])
    assert np.hypot(*(np.array(passage.point) - corner)) < 1.0


@pytest.mark.parametrize("width", [1.1, 1.3])
def test_a_wider_corner_is_rounded(width):
    task = round_the_elbow(width)
    check(task, AStar().plan(task))


def test_a_goal_where_the_chair_stands_in_no_direction_is_told_from_a_passage():
    # A shaft 1 m square, entered through a gap 0.65 m wide at one side of its left wall: the disc
    # of 0.61 m comes in and stands in the middle, the chair's 1.11 m fit in neither way.
    boxes = [(3, 0, 4, 1.85), (3, 2.5, 4, 4), (4, 0, 5, 1.5), (4, 2.5, 5, 4), (5, 0, 6, 4)]
    start, goal = np.array([1.5, 2.0]), np.array([4.5, 2.0])
    task = RouteProblem(grid=room(6.0, 4.0, boxes=boxes), robot=CHAIR, start=start, goal=goal)
    with pytest.raises(NoPath, match="closed by the walls around the goal"):
        AStar().plan(task)


@pytest.mark.parametrize(
    "more",
    [
        {"minimum_turning_radius": 1.2},
        {"footprint": ((0.9, 0.3), (0.0, 0.3), (0.0, -0.3), (0.9, -0.3))},  # axle at the very back
        {"footprint": ((0.6, 0.3), (0.2, 0.1), (-0.3, 0.3), (-0.3, -0.3), (0.6, -0.3))},
    ],
)
def test_other_chairs_have_routes_too(more):
    robot = CHAIR.model_validate({**CHAIR.model_dump(), **more})
    grid = room(10.0, 8.0, boxes=[(4.0, 0.0, 4.4, 5.0)])
    task = RouteProblem(
        grid=grid, robot=robot, start=np.array([1.5, 1.5]), goal=np.array([8.0, 1.5])
    )
    path = AStar().plan(task)
    body = footprint_model(robot.outline, clearance_of(task), 0.05)
    assert not overlaps_along(body, path.points).any()
    assert not len(path.pivots)
    assert curvature_of(path.points).max() <= robot.max_curvature * (1.0 + 1e-6)


def test_zones_are_named_where_they_alone_close_the_way():
    grid = room(6.0, 4.0)
    wish = Wish(
        kind="avoid", points=np.array([[3.0, 0.7], [3.0, 2.0], [3.0, 3.3]]), radius=0.8, hard=True
    )
    with pytest.raises(NoPath, match="zones to avoid") as error:
        AStar().plan(across(grid, wishes=(wish,)))
    assert error.value.passage is None


def test_walls_without_a_gap_have_no_passage():
    with pytest.raises(NoPath) as error:
        AStar().plan(across(halved(0.0, 0.05)))
    assert error.value.passage is None


def test_a_planner_that_may_spend_little_gives_up_where_a_long_search_finds_a_way():
    task = across(halved(WIDTH + 0.06, 0.01))
    check(task, AStar().plan(task))
    with pytest.raises(NoPath):
        AStar().plan(replace(task, effort=0.001))
    wide = across(halved(2.0 * WIDTH, 0.01))
    free, hasty = AStar().plan(wide), AStar().plan(replace(wide, effort=0.001))
    np.testing.assert_array_equal(hasty.points, free.points)  # no search is needed there
