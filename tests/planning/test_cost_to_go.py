"""Cost-to-go against lengths that are known."""

import numpy as np
import pytest

from cohelm.planning import cost_to_go
from cohelm.planning.cost_fields import UNREACHABLE
from cohelm.testing.scenes import room

POINTS = np.array([[2.03, 4.03], [10.03, 4.03]])


def test_in_an_empty_room_it_is_the_distance_up_to_the_grid():
    fields = cost_to_go(room(), 0.35, POINTS)
    for at in ((6.0, 4.0), (3.0, 2.0), (10.0, 6.5)):
        straight = np.hypot(*(POINTS - at).T)
        found = fields.at(np.array(at))
        # steps in eight directions are at most 8 % longer; a cell is 0.1 m
        assert (found >= straight - 0.15).all()
        assert (found <= 1.083 * straight + 0.15).all()


def test_a_wall_is_driven_round_and_a_closed_room_is_unreachable():
    wall = room(boxes=[(5.9, 0.0, 6.1, 6.0)])
    east = np.array([10.03, 4.03])
    assert cost_to_go(wall, 0.35, POINTS).at(east)[0] > 9.0
    shut = room(boxes=[(5.9, 0.0, 6.1, 8.0)])
    assert cost_to_go(shut, 0.35, POINTS).at(east)[0] >= 0.1 * UNREACHABLE
    assert cost_to_go(shut, 0.35, POINTS).at(east)[1] < 0.1


def test_a_gap_as_wide_as_the_chair_stays_open():
    gap = room(boxes=[(5.9, 0.0, 6.1, 3.6), (5.9, 4.35, 6.1, 8.0)])
    assert cost_to_go(gap, 0.35, POINTS).at(POINTS[1])[0] < 9.0
    assert cost_to_go(gap, 0.45, POINTS).at(POINTS[1])[0] >= 0.1 * UNREACHABLE


def test_beside_a_wall_the_cost_goes_on():
    fields = cost_to_go(room(), 0.35, POINTS)
    middle, wall = fields.at(np.array([0.5, 4.03])), fields.at(np.array([0.2, 4.03]))
    assert wall == pytest.approx(middle + 0.3, abs=0.1)


def test_a_point_in_a_wall_is_nowhere_and_one_beside_it_is_where_the_chair_can_stand():
    points = np.array([[6.0, 4.0], [6.0, 0.2], [50.0, 4.0]])
    fields = cost_to_go(room(boxes=[(4.0, 2.0, 8.0, 6.0)]), 0.35, points)
    inside, beside, outside = fields.at(np.array([2.0, 1.0]))
    assert inside >= 0.1 * UNREACHABLE
    assert outside >= 0.1 * UNREACHABLE
    assert beside == pytest.approx(4.0, abs=0.5)


def test_a_line_ends_at_the_wall():
    fields = cost_to_go(room(), 0.35, POINTS)
    here = np.array([6.0, 4.0])
    assert fields.reached(here, 0.0, 1.0) == pytest.approx([7.0, 4.0])
    end = fields.reached(here, np.pi / 2.0, 10.0)
    assert end[1] == pytest.approx(8.0 - 0.1 - 0.35, abs=0.15)
    outward = np.array([0.2, 4.0])
    assert fields.reached(outward, np.pi, 1.0) == pytest.approx(outward)


def test_no_places_are_no_trouble():
    fields = cost_to_go(room(), 0.35, np.empty((0, 2)))
    assert fields.at(np.array([6.0, 4.0])).shape == (0,)
