import numpy as np
import pytest

from cohelm.maps import CostmapFilter, OccupancyGrid, distance_field
from cohelm.planning.along import least_gap, poses_along, time_in_speed_zones

ORIGIN = np.zeros(3)


def test_poses_head_along_the_line():
    poses = poses_along(np.array([[0.0, 0.0], [2.0, 2.0]]), 0.5)
    assert poses[:, 2] == pytest.approx(np.pi / 4)
    assert poses[[0, -1], :2].tolist() == [[0.0, 0.0], [2.0, 2.0]]


def test_a_line_of_one_point_has_a_pose():
    assert poses_along(np.array([[1.0, 2.0], [1.0, 2.0]]), 0.5)[0].tolist() == [1.0, 2.0, 0.0]


def test_the_gap_along_a_wall(chair):
    # A wall along y < 0.5; the chair, 0.61 m wide, drives 1 m above it: 1 − 0.305 = 0.695 m, and
    # the discs that stand for it reach out by up to 3 cm more.
    data = np.zeros((80, 120), dtype=np.int8)
    data[:10] = 100
    walls = distance_field(OccupancyGrid(data=data, resolution=0.05, X_MG=ORIGIN))
    gap = least_gap(np.array([[1.0, 1.5], [5.0, 1.5]]), chair, walls)
    assert 0.695 - 0.03 - 1e-3 <= gap <= 0.695 + 1e-3


def test_speed_zones_cost_what_the_slower_half_takes():
    # Half of 4 m at 50 % of 1.0 m/s instead of 0.8: 2/0.5 − 2/0.8 = 1.5 s.
    data = np.zeros((10, 40), dtype=np.int8)
    data[:, 20:] = 50
    slow = CostmapFilter(
        type="speed_percent", mask=OccupancyGrid(data=data, resolution=0.1, X_MG=ORIGIN)
    )
    line = np.array([[0.0, 0.5], [4.0, 0.5]])
    assert time_in_speed_zones(line, (slow,), 0.8, 1.0) == pytest.approx(1.5, abs=0.05)
    assert time_in_speed_zones(line, (), 0.8, 1.0) == 0.0
