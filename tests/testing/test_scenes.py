"""The scenes and strategies that the checks stand on are themselves right."""

import numpy as np
import pytest
from hypothesis import given

from cohelm.control.api import LocalProblem
from cohelm.geometry import compose, distance_to_polygon, transform
from cohelm.testing import strategies
from cohelm.testing.scenes import open_floor, room, scan_of, straight_on, walkers, walls_of


def test_a_scan_of_a_bare_room_by_hand():
    # at (3, 4) in 12 × 8 m with walls of 0.1 m; beams at −180°, −90°, 0° and 90°
    scan = scan_of(pose=(3.0, 4.0, 0.0), beams=4)
    assert scan.ranges == pytest.approx([2.9, 3.9, 8.9, 3.9])


def test_a_disc_ahead_is_met_at_its_near_side_and_hides_the_wall():
    scan = scan_of(pose=(3.0, 4.0, 0.0), beams=4, discs=[[5.0, 4.0, 0.25]])
    assert scan.ranges == pytest.approx([2.9, 3.9, 1.75, 3.9])


def test_beyond_its_reach_a_scanner_sees_nothing():
    assert np.isinf(scan_of(pose=(1.0, 4.0, 0.0), beams=4).ranges).tolist() == [0, 0, 1, 0]


def test_every_echo_of_a_bare_room_is_on_its_wall():
    pose, mount = np.array([3.0, 4.0, 0.7]), np.array([0.2, -0.1, 0.3])
    scan = scan_of(pose=pose, mount=mount, range_max=20.0)
    angle = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
    ends = scan.ranges[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    on_map = transform(compose(pose, mount), ends)
    # the field is bilinear between centres of 5 cm cells: in a corner it is off by up to a cell
    assert np.abs(walls_of(room()).at(on_map)).max() < 0.05


def test_an_open_floor_has_no_wall_and_no_slope():
    sampled = open_floor().with_gradient(np.array([[0.0, 0.0], [5.3, -7.1]]))
    assert sampled.tolist() == [[40.0, 0.0, 0.0]] * 2


def test_who_walks_straight_on_is_where_the_speed_leads():
    ahead = straight_on(walkers([[1.0, 2.0, 0.5, -1.0]]), 4, 0.5).mean[0, 0]
    assert ahead[-1] == pytest.approx([2.0, 0.0])  # 2 s at (0.5, −1) m/s


@given(strategies.polygons())
def test_polygons_contain_their_centre(polygon):
    assert distance_to_polygon(polygon, 0.0, 0.0) < 0.0


@given(strategies.grids())
def test_grids_are_what_a_map_can_be(grid):
    assert set(np.unique(grid.data)) <= {-1, 0, 100}
    assert np.array_equal(grid.cells(grid.centres([0, 0])), [0, 0])


@given(strategies.local_problems())
def test_local_problems_agree_with_themselves(problem):
    assert isinstance(problem, LocalProblem)
    assert len(problem.predictions.weight) == len(problem.people)
    assert problem.reference.poses[0] == pytest.approx(problem.pose)
