"""Contradictions to the map as places for the page: grouped, sent once, and never a change."""

import numpy as np
import pytest

from cohelm.health import MapChanges
from cohelm.health.map_changes import CELL, PERSISTENT
from cohelm.live.control.navigator_process import NavigatorServer
from cohelm.live.control.view_model import MAX_CELLS, MAX_DIFFERENCES, map_differences
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig


def rows(*cells):
    return np.array(cells, dtype=np.int64).reshape(-1, 3)


def test_cells_that_touch_are_one_place_of_one_kind():
    found = map_differences(rows((4, 4, 0), (5, 5, 0), (6, 5, 0), (5, 4, 1), (9, 9, 0))).found
    assert [(each.kind, len(each.cells)) for each in found] == [
        ("gone", 3),
        ("gone", 1),
        ("new", 1),
    ]
    # The mean of the three centres is ((4 + 5 + 6) / 3 + 0.5) · 0.25 m, nearest to the second cell.
    assert (found[0].x, found[0].y) == ((5 + 0.5) * CELL, (5 + 0.5) * CELL)


def test_the_order_of_the_rows_does_not_matter():
    rng = np.random.default_rng(3)
    some = np.unique(
        np.column_stack([rng.integers(0, 12, (60, 2)), rng.integers(0, 2, 60)]), axis=0
    )
    assert map_differences(some) == map_differences(rng.permutation(some))
    assert sum(len(each.cells) for each in map_differences(some).found) == len(some)


def test_a_message_stays_small_however_wrong_the_map_is():
    wall = np.column_stack([np.arange(300), np.zeros(300, int), np.zeros(300, int)])
    spots = np.column_stack([np.arange(0, 900, 3), np.full(300, 9), np.ones(300, int)])
    found = map_differences(np.vstack([wall, spots])).found
    assert len(found) == MAX_DIFFERENCES
    assert len(found[0].cells) == MAX_CELLS


@pytest.fixture(scope="module")
def ride_setup():
    return build_scenario(load_scenario("empty"), 0)


def test_pages_get_what_earlier_rides_have_seen_once(ride_setup):
    """Behind the chair's horizon nothing speaks for or against it."""
    rig = Rig(ride_setup)
    rig.navigator.mind = NavigatorServer(
        ride_setup, MapChanges(rows((4000, 4000, 0)), np.array([PERSISTENT]))
    )
    grid = ride_setup.grid.data.copy()
    rig.steps(40)
    (sent,) = rig.of("map_differences")
    (place,) = sent.found
    assert (place.kind, place.x, place.y, sent.cell) == ("gone", 1000.125, 1000.125, CELL)
    assert np.array_equal(ride_setup.grid.data, grid)  # the map stays as it is


def test_a_ride_that_finds_the_map_right_says_nothing(ride_setup):
    rig = Rig(ride_setup)
    rig.steps(40)
    assert rig.of("map_differences") == []
