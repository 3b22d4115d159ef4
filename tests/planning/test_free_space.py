import math

import numpy as np
import pytest

from cohelm.maps import OccupancyGrid
from cohelm.planning.free_space import check_free_space
from cohelm.robots import load_robot


@pytest.fixture(scope="module")
def room():
    """A room of 6 × 4 m with walls of one cell and a corridor 0.9 m wide to the right of it."""
    cells = np.zeros((80, 200), dtype=np.int8)
    cells[[0, -1]] = 100
    cells[:, [0, -1]] = 100
    cells[:31, 120:] = 100
    cells[49:, 120:] = 100
    return OccupancyGrid(data=cells, resolution=0.05, X_MG=[-1.0, -2.0, 0.0])


@pytest.fixture(scope="module")
def robot():
    return load_robot("quantum_q6_edge")


def test_the_chair_fits_and_turns_in_the_middle_of_a_room(room, robot):
    check = check_free_space(room, robot, (2.0, 0.0))
    assert check.fits
    assert check.turns
    assert check.nearest == (2.0, 0.0)
    assert check.clearance == pytest.approx(1.95, abs=0.03)


def test_in_a_narrow_corridor_it_fits_along_it_only(room, robot):
    check = check_free_space(room, robot, (7.0, 0.0))
    assert (check.fits, check.turns) == (True, False)
    assert check_free_space(room, robot, (7.0, 0.0), 0.0).fits
    across = check_free_space(room, robot, (7.0, 0.0), math.pi / 2)
    assert not across.fits
    assert check_free_space(room, robot, across.nearest, math.pi / 2).fits


@pytest.mark.parametrize("point", [(8.0, 1.9), (-0.9, 0.0), (-30.0, 0.0)])
def test_a_blocked_point_names_the_nearest_free_one(room, robot, point):
    check = check_free_space(room, robot, point)
    assert not check.fits
    assert check_free_space(room, robot, check.nearest).fits


def test_no_free_point_is_none(robot):
    blocked = OccupancyGrid(data=np.full((40, 40), 100), resolution=0.05, X_MG=[0.0, 0.0, 0.0])
    assert check_free_space(blocked, robot, (1.0, 1.0)).nearest is None
