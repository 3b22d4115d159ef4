"""The tightest passage: its place, its width and the error text."""

from dataclasses import replace

import numpy as np
import pytest
from tests.planning.floors import CHAIR, problem, room

from cohelm.errors import NoPath, Passage
from cohelm.maps import FREE, OCCUPIED, signed_distance
from cohelm.planning import AStar
from cohelm.planning.planners.route import gap_at, no_path, tightest_passage
from cohelm.planning.problem import prepare


def gap_of(blocked, cell, along=None, resolution=0.1):
    walls = signed_distance(blocked, resolution)
    return gap_at(walls, resolution, np.array(cell), along, 1.0)


@pytest.mark.parametrize("cells", [1, 2, 5, 6])
def test_a_gap_is_as_wide_as_the_free_cells_between(cells):
    blocked = np.zeros((30, 20), dtype=bool)
    blocked[:, 10] = True
    blocked[12 : 12 + cells, 10] = False
    middle, width = gap_of(blocked, (12 + cells // 2, 10), 0.0)
    assert width == pytest.approx(0.1 * cells)
    assert middle == pytest.approx([1.05, 1.2 + 0.05 * cells])


def test_the_direction_may_be_left_to_the_nearest_obstacle():
    blocked = np.zeros((30, 30), dtype=bool)
    blocked[:, 8] = blocked[:, 14] = True
    for cell in ((15, 10), (15, 12)):
        middle, width = gap_of(blocked, cell)
        assert width == pytest.approx(0.5)
        assert middle[0] == pytest.approx(1.15)


def test_beside_a_lone_obstacle_the_gap_is_twice_the_clearance():
    blocked = np.zeros((30, 30), dtype=bool)
    blocked[15, 12] = True
    middle, width = gap_of(blocked, (15, 15), np.pi / 2.0)
    assert width == pytest.approx(2 * 0.25)
    assert middle == pytest.approx([1.55, 1.55])


def two_doors(near, far):
    """A room halved at x = 5 with a door about y = 2 and another about y = 8, 0.05 m cells."""
    return room(
        10,
        10,
        boxes=[
            (4.9, 0.0, 5.1, 2.0 - near / 2),
            (4.9, 2.0 + near / 2, 5.1, 8.0 - far / 2),
            (4.9, 8.0 + far / 2, 5.1, 10.0),
        ],
    )


def test_of_two_doors_the_one_that_lacks_much_less_is_named():
    ground = prepare(
        problem(two_doors(0.2, 0.5), (2, 2), (8, 2), clearance=0.0), AStar.Parameters()
    )
    passage = tightest_passage(ground)
    assert passage.point == pytest.approx((5.0, 8.0), abs=0.2)
    assert passage.width == pytest.approx(0.5)


def test_of_two_doors_alike_the_nearer_one_is_named():
    ground = prepare(
        problem(two_doors(0.5, 0.5), (2, 2), (8, 2), clearance=0.0), AStar.Parameters()
    )
    assert tightest_passage(ground).point == pytest.approx((5.0, 2.0), abs=0.2)


def test_what_is_wide_enough_is_no_passage_to_name():
    ground = prepare(problem(two_doors(1.0, 1.0), (2, 2), (8, 2)), AStar.Parameters())
    assert tightest_passage(ground) is None


def test_the_clearance_asked_for_counts():
    with pytest.raises(NoPath) as error:
        AStar().plan(problem(two_doors(0.7, 0.2), (2, 2), (8, 2), clearance=0.1))
    passage = error.value.passage
    assert passage.width == pytest.approx(0.7)
    assert passage.needed == pytest.approx(2.0 * (CHAIR.inscribed_radius + 0.1))


def test_a_sentence_says_what_is_missing_and_how_well_that_is_known():
    said = str(Passage(point=(1.0, 2.0), width=0.59, needed=0.61, resolution=0.05))
    assert "(1.00, 2.00) is 0.59 m wide" in said
    assert "0.02 m are missing" in said
    assert "cells are 0.05 m" in said
    kept = Passage(point=(1.0, 2.0), width=0.7, needed=0.81, resolution=0.05, clearance=0.1)
    assert "needs 0.81 m (0.61 m and 0.10 m on either side): 0.11 m are missing" in str(kept)
    nearly = str(Passage(point=(1.0, 2.0), width=1.0, needed=0.99, resolution=0.05, clearance=0.19))
    assert "too close to tell" in nearly
    assert "missing" not in nearly
    turns = str(Passage(point=(1.0, 2.0), width=0.9, needed=1.44, resolution=0.05, turns=True))
    assert "cannot turn" in turns
    assert "missing" not in turns


def test_a_long_way_with_many_bends_is_as_drivable_as_a_short_one():
    """A serpentine of 19 walls, whose gaps of 3 m alternate between both sides of a hall."""
    walls = [
        (10.0 * k, 3.0 * (k % 2 == 0), 10.0 * k + 0.4, 24.0 - 3.0 * (k % 2 == 1))
        for k in range(1, 20)
    ]
    hall = room(200.0, 24.0, boxes=walls)
    path = AStar().plan(problem(hall, (3.0, 3.0), (197.0, 21.0), clearance=0.0))
    assert 19 * 10.0 + 19 * 15.0 > path.length > 19 * 10.0 + 19 * 10.0


def test_any_number_of_bends_that_are_too_tight_is_passed_by():
    """Seven passages 0.75 m wide with two bends each, and a straight one 1.5 m wide behind them."""
    grid = room(26.0, 27.5)
    data = grid.data.copy()
    data[:, 200:280] = OCCUPIED
    for low in range(20, 20 + 7 * 50, 50):
        data[low : low + 15, 200:247] = FREE
        data[low : low + 37, 232:247] = FREE
        data[low + 22 : low + 37, 232:280] = FREE
    data[-60:-30, 200:280] = FREE
    path = AStar().plan(problem(replace(grid, data=data), (5.0, 3.0), (21.0, 3.0)))
    assert path.points[:, 1].max() > 24.5


def test_a_passage_that_is_wide_enough_is_not_called_too_narrow():
    wide = str(Passage(point=(1.0, 2.0), width=1.95, needed=1.44, resolution=0.05, turns=True))
    assert "wide enough" in wide
    assert "cannot turn" not in wide


def test_the_passage_that_is_too_narrow_is_named_and_not_a_wide_one():
    ground = prepare(problem(two_doors(1.0, 2.0), (2, 2), (8, 2)), AStar.Parameters())
    wide, narrow = np.array([5.0, 8.0]), np.array([5.0, 2.0])
    for stuck in ([narrow], [wide, narrow]):
        passage = no_path(ground, AStar.Parameters(), stuck).passage
        assert passage.width == pytest.approx(1.0)
    assert "wide enough" in str(no_path(ground, AStar.Parameters(), [wide]))
