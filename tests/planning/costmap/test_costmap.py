"""Costs have Nav2's values, and live obstacles change only their window."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.maps import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from cohelm.messages import LiveObstacles
from cohelm.planning import Inflation, build_costmap, combine
from cohelm.planning.problem import CostmapParameters, weigh


def grid_of(data, resolution=0.1):
    return OccupancyGrid(data=data, resolution=resolution, X_MG=np.zeros(3))


def one_wall(cols=40):
    data = np.full((1, cols), FREE)
    data[0, 0] = OCCUPIED
    return grid_of(data)


def test_inflation_follows_the_formula():
    # The wall's surface is at x = 0.1; the centre of column j is 0.1 j − 0.05 from it.
    inflation = Inflation(inflation_radius=1.0, cost_scaling_factor=4.0)
    cost = build_costmap(one_wall(), 0.36, inflation).cost[0]
    assert cost[0] == 254
    assert cost[1:5].tolist() == [253] * 4  # 0.05, 0.15, 0.25, 0.35 ≤ 0.36
    for j in range(5, 11):
        assert cost[j] == int(252.0 * math.exp(-4.0 * (0.1 * j - 0.05 - 0.36)))
    assert not cost[11:].any()  # 1.05 > 1.0


def test_unknown_blocks_and_stays_unknown():
    data = np.full((5, 5), FREE)
    data[2, 2] = UNKNOWN
    cost = build_costmap(grid_of(data), 0.06, Inflation()).cost
    assert cost[2, 2] == 255
    assert cost[2, 1] == 253


def test_occupancy_blocks_above_half():
    cost = build_costmap(grid_of(np.array([[50, 51]]), 5.0), 0.3, Inflation()).cost
    assert cost.tolist() == [[0, 254]]


def test_nothing_costs_nothing():
    costmap = build_costmap(grid_of(np.zeros((30, 40))), 0.3, Inflation())
    assert not costmap.cost.any()
    assert np.isfinite(costmap.clearance).all()


def test_the_maps_part_is_kept():
    grid = one_wall()
    assert build_costmap(grid, 0.3, Inflation()) is build_costmap(grid, 0.3, Inflation())


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_live_obstacles_count_like_those_of_the_map(seed):
    """A window of live obstacles gives the costs of a map that has them drawn in."""
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((60, 70)) < 0.004, OCCUPIED, FREE)
    occupied = (rng.random((12, 15)) < 0.05).astype(np.uint8)
    corner = rng.integers(0, [48, 55])
    live = LiveObstacles(corner=corner, occupied=occupied, version=1)
    drawn = data.copy()
    part = drawn[corner[0] : corner[0] + 12, corner[1] : corner[1] + 15]
    part[occupied > 0] = OCCUPIED
    with_live = build_costmap(grid_of(data), 0.36, Inflation(), live)
    with_drawn = build_costmap(grid_of(drawn), 0.36, Inflation())
    assert np.array_equal(with_live.cost, with_drawn.cost)
    near = with_drawn.clearance < Inflation().inflation_radius
    assert np.allclose(with_live.clearance[near], with_drawn.clearance[near], atol=1e-6)


@pytest.mark.parametrize("corner", [(-4, -4), (-4, 36), (26, -4), (26, 36), (10, 10)])
def test_a_window_may_lie_across_the_border(corner):
    # 9 × 9 live cells, all occupied; those on the 30 × 40 grid are obstacles.
    live = LiveObstacles(corner=corner, occupied=np.ones((9, 9)), version=1)
    cost = build_costmap(grid_of(np.zeros((30, 40))), 0.3, Inflation(), live).cost
    (r, c), inside = corner, np.zeros((30, 40), dtype=bool)
    inside[max(r, 0) : r + 9, max(c, 0) : c + 9] = True
    assert np.array_equal(cost == 254, inside)


def test_an_obstacle_off_the_map_is_felt_on_it():
    live = LiveObstacles(corner=(0, -2), occupied=np.array([[1, 0]]), version=1)
    cost = build_costmap(grid_of(np.zeros((1, 9))), 0.2, Inflation(), live).cost[0]
    # The obstacle's surface is at x = −0.1, so the first cell's centre is 0.15 away.
    assert cost[0] == 253
    assert 0 < cost[1] < 253


def test_a_window_far_off_the_map_changes_nothing():
    live = LiveObstacles(corner=(500, 500), occupied=np.ones((3, 3)), version=1)
    grid = one_wall()
    base = build_costmap(grid, 0.3, Inflation())
    assert build_costmap(grid, 0.3, Inflation(), live) is base


def test_layers_combine_by_maximum():
    costmap = build_costmap(one_wall(), 0.3, Inflation())
    layer = np.full(costmap.cost.shape, 100, dtype=np.uint8)
    combined = combine(costmap, layer)
    assert np.array_equal(combined.cost, np.maximum(costmap.cost, 100))
    assert combined.clearance is costmap.clearance
    assert combined.walls is costmap.walls


def test_live_obstacles_make_anew_their_window_and_nothing_else():
    grid = grid_of(np.full((600, 600), FREE), 0.05)
    live = LiveObstacles(corner=(250, 200), occupied=np.ones((100, 80)), version=1)
    costmap = build_costmap(grid, 0.36, Inflation(inflation_radius=1.0), live)
    (patch,) = costmap.patches
    # On each side the 1 m that obstacles inflate, 20 cells, and one more.
    assert (patch.rows, patch.cols) == (slice(229, 371), slice(179, 301))
    base = build_costmap(grid, 0.36, Inflation(inflation_radius=1.0))
    assert costmap.base is base.base
    changed = np.argwhere(costmap.cost != base.cost)
    assert (changed >= [229, 179]).all()
    assert (changed < [371, 301]).all()


def test_the_weights_of_the_maps_part_are_kept():
    grid, parameters = grid_of(np.full((20, 30), FREE)), CostmapParameters()
    costmap = build_costmap(grid, 0.3, parameters.inflation)
    assert weigh(costmap, (5, 5), parameters) is weigh(costmap, (9, 9), parameters)
