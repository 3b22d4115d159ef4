"""Iterative A*: discs push the path to the wished line, and the iteration ends."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.floors import problem, room

from cohelm.geometry import nearest_on_polyline
from cohelm.messages import Wish
from cohelm.planning import AStar, IterativeAStar
from cohelm.planning.planners.wishes import wished_line


def island(*wishes):
    """Two equal ways round a box."""
    task = problem(room(12, 9, boxes=[(4, 3, 8, 6)]), (1.5, 4.5), (10.5, 4.5))
    return replace(task, wishes=wishes)


def stray(path, task):
    line = wished_line(task)
    return max(nearest_on_polyline(line, x, y)[1] for x, y in path.points)


def planned(task, **parameters):
    return IterativeAStar(IterativeAStar.Parameters(**parameters)).plan(task)


@pytest.mark.parametrize("y", [1.5, 7.5])
def test_discs_drive_the_path_to_the_wished_side(y):
    task = island(Wish(points=np.array([[6.0, y]])))
    path = planned(task)
    assert np.interp(6.0, *path.points.T) == pytest.approx(y, abs=1.0)


def test_a_stroke_is_followed():
    line = np.array([[1.5, 4.5], [2.0, 7.5], [10.0, 7.5], [10.5, 4.5]])
    task = island(Wish(kind="stroke", points=line))
    plain, path = AStar().plan(task), planned(task)
    assert stray(path, task) < stray(plain, task)
    assert path.wishes.along[0] < 0.25


@pytest.mark.parametrize("rounds", [1, 2, 5, 20])
def test_more_rounds_stray_no_farther(rounds):
    task = island(Wish(points=np.array([[6.0, 7.0]])))
    fewer, more = planned(task, rounds=rounds), planned(task, rounds=rounds + 5)
    assert stray(more, task) <= stray(fewer, task) + 0.15  # smoothing is not in the rounds


def test_one_round_is_plain():
    task = island(Wish(points=np.array([[6.0, 1.5]])))
    plain = AStar().plan(task)
    assert np.array_equal(planned(task, rounds=1).points, plain.points)
    assert np.array_equal(planned(task, near_enough=50.0).points, plain.points)


def test_no_path_left_is_a_normal_outcome():
    # A corridor: the first disc closes it, and the path so far is what there is.
    task = problem(room(12, 1.6), (1.0, 0.8), (11.0, 0.8), prefer=[(6.0, 5.0)])
    path = planned(task, disc_radius=1.0)
    assert np.array_equal(path.points, AStar().plan(task).points)


def test_start_and_goal_stay_free():
    task = island(Wish(points=np.array([[1.6, 8.0], [10.4, 8.0]])))
    path = planned(task, disc_radius=5.0)
    assert np.array_equal(path.points[[0, -1]], [task.start, task.goal])
