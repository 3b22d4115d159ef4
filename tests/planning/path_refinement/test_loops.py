"""No path contains a loop: where it turns back, the chair turns on the spot."""

import numpy as np
import pytest
from tests.planning.floors import CHAIR, room

from cohelm.errors import PlanningError
from cohelm.maps import distance_field
from cohelm.messages import Wish
from cohelm.planning import AStar, RouteProblem, SoftVia
from cohelm.planning.path_measures import min_gap
from cohelm.planning.path_refinement.loops import find_loop, reversal_points

_NONE = np.empty(0, dtype=np.int64)


def arc(turn, radius=0.4):
    angle = np.linspace(0.0, turn, max(int(turn * radius / 0.05), 2))
    curve = radius * np.stack([np.sin(angle), 1.0 - np.cos(angle)], axis=-1)
    ahead = np.array([np.cos(turn), np.sin(turn)])
    before, after = np.arange(-2.0, 0.0, 0.1), np.arange(0.1, 2.0, 0.1)
    head = np.stack([before, np.zeros_like(before)], axis=-1)
    return np.concatenate([head, curve, curve[-1] + after[:, None] * ahead])


@pytest.mark.parametrize(("degrees", "ring"), [(90, False), (180, False), (300, True), (400, True)])
def test_a_ring_is_a_curve_that_comes_back_to_where_it_was(degrees, ring):
    assert (find_loop(arc(np.deg2rad(degrees)), _NONE)[0] >= 0) is ring


def test_out_and_back_is_a_ring_but_for_a_turn_on_the_spot():
    x = np.concatenate([np.arange(0.0, 2.0, 0.1), np.arange(2.0, -0.05, -0.1)])
    line = np.stack([x, np.zeros_like(x)], axis=-1)
    assert reversal_points(line).tolist() == [20]
    assert find_loop(line, _NONE)[0] >= 0
    assert find_loop(line, np.array([20])) == (-1, -1)


def storey(seed):
    """A room of 16 × 12 m with blocks, two ends and three points to be passed in order."""
    rng = np.random.default_rng(seed)
    corner = rng.uniform([2.0, 2.0], [12.0, 8.0], size=(4, 2))
    size = rng.uniform(0.5, 3.0, size=(4, 2))
    grid = room(16.0, 12.0, 0.05, boxes=[(*c, *(c + s)) for c, s in zip(corner, size, strict=True)])
    walls = distance_field(grid)
    places = rng.uniform([1.2, 1.2], [14.8, 10.8], size=(60, 2))
    start, goal, *points = places[walls.at(places) > 0.75][:5]
    return grid, start, goal, np.array(points)


@pytest.mark.parametrize("kind", ["attract", "stroke"])
@pytest.mark.parametrize("seed", range(8))
def test_no_line_goes_round_in_a_ring(seed, kind):
    grid, start, goal, points = storey(seed)
    wishes = (Wish(points=points, kind=kind),)
    task = RouteProblem(grid=grid, robot=CHAIR, start=start, goal=goal, wishes=wishes)
    try:
        path = SoftVia().plan(task)
    except PlanningError:
        pytest.skip("no way leads there")
    assert find_loop(path.points, path.pivots) == (-1, -1)
    assert min_gap(path, CHAIR, distance_field(grid)) > 0.0


@pytest.mark.parametrize("clearance", [0.0, 0.05, 0.1, 0.15])
def test_the_whole_chair_keeps_the_clearance_asked_for(clearance):
    # A door of 1.1 m, 3 m of free floor before it: the chair of 0.61 m has 0.24 m on either side.
    grid = room(12.0, 8.0, 0.05, boxes=[(6.0, 0.0, 6.2, 3.0), (6.0, 4.1, 6.2, 8.0)])
    start, goal = np.array([1.5, 1.5]), np.array([10.5, 6.5])
    task = RouteProblem(grid=grid, robot=CHAIR, start=start, goal=goal, clearance=clearance)
    path = AStar().plan(task)
    assert min_gap(path, CHAIR, distance_field(grid)) >= clearance - 1e-6


@pytest.mark.parametrize("rise", [-4.0, -2.0, 2.0, 4.0])
def test_a_door_is_not_grazed_where_there_is_room_to_come_straight(rise):
    grid = room(12.0, 12.0, 0.05, boxes=[(6.0, 0.0, 6.2, 5.5), (6.0, 6.5, 6.2, 12.0)])
    start, goal = np.array([2.0, 6.0 - rise]), np.array([10.0, 6.0 + rise])
    task = RouteProblem(grid=grid, robot=CHAIR, start=start, goal=goal)
    path = AStar().plan(task)
    assert min_gap(path, CHAIR, distance_field(grid)) >= 0.05
