"""A path leaves the zone around its start and does not enter it again."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.floors import problem, room

from cohelm.geometry import inside_polygon
from cohelm.maps import FREE, OCCUPIED, CostmapFilter, OccupancyGrid
from cohelm.messages import Wish
from cohelm.planning import AStar


def horseshoe(grid):
    """A keepout mask: two legs, 2 m wide, joined at their far left; the gap between is 3 m wide."""
    y, x = (np.indices(grid.shape) + 0.5) * grid.resolution
    closed = (x < 12.0) & (
        ((y > 3.0) & (y < 5.0)) | ((y > 8.0) & (y < 10.0)) | ((x < 2.0) & (y > 3.0) & (y < 10.0))
    )
    data = np.where(closed, OCCUPIED, FREE)
    mask = OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)
    return CostmapFilter(type="keepout", mask=mask), closed


@pytest.mark.parametrize("goal", [(6.0, 6.5), (6.0, 11.5), (13.5, 6.5), (3.5, 6.5)])
def test_a_zone_is_left_once_and_not_entered_again(goal):
    grid = room(20.0, 13.0, 0.1)
    mask, closed = horseshoe(grid)
    task = problem(grid, (6.0, 4.0), goal, filters=(mask,))
    path = AStar().plan(task)
    inside = closed[tuple(grid.cells(path.points).T)]
    left = int(np.argmin(inside))
    assert left > 0
    assert not inside[left:].any()


def test_a_zone_drawn_about_the_chair_is_left():
    corners = np.array([[4.0, 3.0], [6.0, 3.0], [6.0, 5.0], [4.0, 5.0]])
    wish = Wish(points=corners, kind="avoid", hard=True)
    task = replace(problem(room(12.0, 8.0, 0.1), (4.5, 4.0), (10.0, 4.0)), wishes=(wish,))
    path = AStar().plan(task)
    inside = inside_polygon(corners, path.points)
    assert inside[0]
    assert not inside[int(np.argmin(inside)) :].any()
