"""A world in which rider and chair see and want different things."""

import dataclasses

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.simulation import GoalChange, SplitCells, World, with_cells
from cohelm.simulation.api import RiderAct
from cohelm.simulation.split_knowledge import grid_views


class Noting:
    """A rider without a device who notes every view."""

    def __init__(self):
        self.views = []

    def act(self, view, memory, rng):
        self.views.append(view)
        return RiderAct(command=None)


def drive(world, speed, ticks):
    for _ in range(ticks):
        world.advance(Decision(twist=np.array([speed, 0.0, 0.0]), reason=None))


def test_views_are_made_once_and_are_the_truth_without_a_split(make_grid):
    grid = make_grid()
    assert grid_views(grid, None).sensed is grid
    cells = np.zeros(grid.shape, dtype=bool)
    split = SplitCells(unsensed=cells, avoided=cells)
    assert grid_views(grid, split) is grid_views(grid, split)
    assert with_cells(grid, cells, 100) is grid


def test_the_chair_touches_what_its_sensors_miss(make_setup, make_grid):
    wall = (4.0, 0.0, 4.2, 10.0)
    grid = make_grid(boxes=(wall,))
    hidden = grid.occupied() & ~make_grid().occupied()
    split = SplitCells(unsensed=hidden, avoided=np.zeros_like(hidden))
    world = World(make_setup(grid=grid, split=split), seed=0)
    open_world = World(make_setup(grid=make_grid()), seed=0)
    scans = [each.observe().scans[0].ranges for each in (world, open_world)]
    assert np.array_equal(*scans, equal_nan=True)
    drive(world, 0.5, 80)
    assert world.truth.gap_wall <= 0.0 or world.truth.hit_wall


def test_floor_to_avoid_ends_the_rider_s_view_and_touches_nothing(make_setup, make_grid):
    grid = make_grid()
    wet = make_grid(boxes=((4.0, 0.0, 4.5, 10.0),)).occupied() & ~grid.occupied()
    split = SplitCells(unsensed=np.zeros_like(wet), avoided=wet)
    rider = Noting()
    world = World(make_setup(grid=grid, split=split, rider=rider), seed=0)
    assert rider.views[-1].free[22] == pytest.approx(2.0, abs=0.11)
    drive(world, 0.5, 80)
    assert not world.truth.hit_wall
    assert world.truth.pose[0] > 3.0


def test_the_rider_changes_the_goal_near_the_place_and_keeps_to_it(make_setup):
    change = GoalChange(
        near=np.array([4.0, 5.0]),
        within=0.5,
        goal=np.array([4.0, 9.0]),
        route=np.array([[4.0, 5.0], [4.0, 9.0]]),
    )
    rider = Noting()
    setup = make_setup(rider=rider, goal_change=change)
    assert setup.last_goal.tolist() == [4.0, 9.0]
    assert dataclasses.replace(setup, goal_change=None).last_goal.tolist() == [10.0, 5.0]
    world = World(setup, seed=0)
    drive(world, 0.8, 160)
    changed = np.array([view.goal[1] == 9.0 for view in rider.views])
    first = int(np.argmax(changed))
    assert changed[first:].all()
    assert not changed[:first].any()
    assert np.hypot(*(rider.views[first].pose[:2] - change.near)) <= 0.5
    assert np.hypot(*(rider.views[-1].pose[:2] - change.near)) > 0.5
    assert np.array_equal(rider.views[-1].route, change.route)
