"""Each costmap layer, on grids of any pose, and only in its window."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.geometry import compose, distance_to_polygon, inverse, transform
from cohelm.maps import FREE, OCCUPIED, UNKNOWN, CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, Wish
from cohelm.planning import Inflation, build_costmap
from cohelm.planning.costmap.layers.people import (
    CrowdingCosts,
    GroupCosts,
    crowding_patches,
    group_patch,
)
from cohelm.planning.costmap.layers.static import keepout_costs
from cohelm.planning.costmap.layers.zones import ZoneCosts, distance_to_zone, zone_patch

RADIUS = 0.3
SQUARE = np.array([[1.0, 1.0], [3.0, 1.0], [3.0, 2.0], [1.0, 2.0]])


def floor(rows=40, cols=60, resolution=0.1, X_MG=(0.0, 0.0, 0.0), data=None):
    data = np.zeros((rows, cols)) if data is None else data
    return OccupancyGrid(data=data, resolution=resolution, X_MG=np.array(X_MG))


def avoid(points, radius=0.0, *, hard=False):
    return Wish(kind="avoid", points=np.array(points, dtype=float), radius=radius, hard=hard)


def patch_of(wish, grid, zones=None):
    return zone_patch(wish, grid, RADIUS, Inflation(), zones or ZoneCosts())


def spread_out(patches, shape):
    """The costs (rows, cols) of patches, by maximum."""
    cost = np.zeros(shape, dtype=np.uint8)
    for patch in patches:
        there = cost[patch.rows, patch.cols]
        np.maximum(there, patch.cost, out=there)
    return cost


def points_of(grid):
    rows, cols = np.indices(grid.shape)
    return grid.centres(np.stack([rows, cols], axis=-1))


# --------------------------------------------------------------------------- zones


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), k=st.integers(1, 4))
def test_a_soft_zone_costs_by_the_distance_to_it(seed, k):
    """c inside, falling evenly to 0 over the margin, in any pose of the grid."""
    rng = np.random.default_rng(seed)
    grid = floor(X_MG=[*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)])
    points = transform(grid.X_MG, SQUARE[:k] + rng.uniform(-2.0, 2.0, 2))
    wish = avoid(points, rng.uniform(0.0, 0.6))
    zones = ZoneCosts(cost=200.0, margin=rng.uniform(0.2, 1.0))
    patch = patch_of(wish, grid, zones)
    found = spread_out([patch] if patch is not None else [], grid.shape)
    distance = np.array([distance_to_zone(wish, p) for p in points_of(grid).reshape(-1, 2)])
    expected = 200.0 * np.clip(1.0 - distance / zones.margin, 0.0, 1.0)
    assert np.abs(found.ravel() - expected).max() <= 0.51  # rounded


def test_the_distance_to_a_zone():
    point, line, area = SQUARE[:1], SQUARE[:2], SQUARE
    at = np.array([2.0, 1.5])
    assert distance_to_zone(avoid(point, 0.2), at) == pytest.approx(np.hypot(1.0, 0.5) - 0.2)
    assert distance_to_zone(avoid(line, 0.2), at) == pytest.approx(0.3)
    assert distance_to_zone(avoid(area, 0.2), at) == pytest.approx(-0.7)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_hard_zone_is_an_obstacle_drawn_into_the_map(seed):
    """Its cells cost and keep away what occupied cells would."""
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((40, 60)) < 0.003, OCCUPIED, FREE)
    grid = floor(data=data)
    wish = avoid(SQUARE + rng.uniform([-3, -2], [4, 3]), rng.uniform(0.0, 0.5), hard=True)
    patch = patch_of(wish, grid)
    found = build_costmap(grid, RADIUS, Inflation(), patches=[patch] if patch is not None else [])
    drawn = data.copy()
    inside = [
        distance_to_polygon(wish.points, *p) <= wish.radius for p in points_of(grid).reshape(-1, 2)
    ]
    drawn[np.reshape(inside, grid.shape)] = OCCUPIED
    expected = build_costmap(floor(data=drawn), RADIUS, Inflation())
    near = (expected.clearance > 0) & (expected.clearance < Inflation().inflation_radius)
    assert np.array_equal(found.cost == 254, expected.cost == 254)
    whole = (wish.points.min(0) > wish.radius).all() and (
        wish.points.max(0) < np.array([6.0, 4.0]) - wish.radius
    ).all()
    if whole:  # what lies off the map is felt on it too, which a drawing cannot show
        assert np.array_equal(found.cost, expected.cost)
        assert np.allclose(found.clearance[near], expected.clearance[near], atol=1e-6)
    walls = build_costmap(grid, RADIUS, Inflation())
    assert np.array_equal(found.walls, walls.clearance)


@pytest.mark.parametrize("points", [SQUARE[:1], SQUARE[[0, 2]]])
def test_a_hard_zone_is_never_too_thin_to_count(points):
    # 0.1 m cells, no radius at all: still the cells that the line crosses are closed.
    cost = spread_out([patch_of(avoid(points, hard=True), floor())], (40, 60))
    for share in np.linspace(0.0, 1.0, 200):
        row, col = floor().cells(points[0] + share * (points[-1] - points[0]))
        assert cost[row, col] == 254


def test_a_zone_far_off_the_map_says_nothing():
    assert patch_of(avoid([[50.0, 50.0]], 1.0), floor()) is None


def test_a_hard_zone_just_off_the_map_is_felt_on_it():
    cost = spread_out([patch_of(avoid([[-0.2, 1.0]], 0.1, hard=True), floor())], (40, 60))
    assert cost[10, 0] == 253  # 0.05 + 0.1 m from its surface, and 0.3 m blocks


@given(small=st.floats(0.0, 1.0), more=st.floats(0.0, 1.0))
@settings(max_examples=20, deadline=None)
def test_a_larger_zone_costs_no_less(small, more):
    for hard in (False, True):
        less = spread_out([patch_of(avoid(SQUARE[:1], small, hard=hard), floor())], (40, 60))
        larger = avoid(SQUARE[:1], small + more, hard=hard)
        assert (spread_out([patch_of(larger, floor())], (40, 60)) >= less).all()


# --------------------------------------------------------------------------- groups


def test_the_gap_between_two_members_is_as_dear_as_the_detour():
    groups = GroupCosts(detour=24.0, reach=0.4)
    patch = group_patch(np.array([[2.0, 1.0], [2.0, 3.0]]), floor(), groups)
    extra_cost = np.zeros((40, 60))
    extra_cost[patch.rows, patch.cols] = patch.extra_cost
    # A way along y = 2.05 crosses 8 cells of 0.1 m that weigh 24 / 0.8 = 30: 24 m.
    assert extra_cost[20].sum() * 0.1 == pytest.approx(24.0)
    assert not extra_cost[36].any()  # 0.65 m beyond the farther member


def test_one_alone_has_no_between():
    assert group_patch(np.array([[2.0, 1.0]]), floor(), GroupCosts()) is None
    assert group_patch(np.empty((0, 2)), floor(), GroupCosts()) is None


# --------------------------------------------------------------------------- crowding


def crowd(density, resolution=0.5, X_MG=(0.0, 0.0, 0.0)):
    return Crowding(density=np.asarray(density), resolution=resolution, X_MG=np.array(X_MG))


def test_crowding_costs_in_proportion_and_no_more_than_full():
    density = np.zeros((8, 12))
    density[2:5, 2:5], density[2:5, 8:11] = 0.25, 9.0
    patches = crowding_patches(crowd(density), floor(), CrowdingCosts(cost=200.0, full=0.5))
    assert len(patches) == 2  # two stretches of floor, two windows
    cost = spread_out(patches, (40, 60))
    # In the middle of the stretches, where bilinear interpolation is flat.
    assert cost[17, 17] == 100
    assert cost[17, 47] == 200
    assert cost[17, 32] == 0


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_crowding_of_any_pose_is_bilinear_between_its_cells(seed):
    rng = np.random.default_rng(seed)
    grid = floor(X_MG=[*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)])
    density = np.where(rng.random((8, 12)) < 0.2, rng.random((8, 12)), 0.0)
    X_MC = compose(grid.X_MG, [*rng.uniform(-1, 1, 2), rng.uniform(-3, 3)])
    crowding = crowd(density, 0.5, X_MC)
    costs = CrowdingCosts()
    found = spread_out(crowding_patches(crowding, grid, costs), grid.shape)
    expected = _bilinear(crowding, points_of(grid), costs)
    assert np.abs(found - expected).max() <= 1.0  # cut to whole numbers


def _bilinear(crowding, points, costs):
    share = np.minimum(crowding.density / costs.full, 1.0) * costs.cost
    share[share < 1.0] = 0.0
    padded = np.pad(share, 2)
    local = transform(inverse(crowding.X_MG), points) / crowding.resolution - 0.5 + 2.0
    local = local.clip(0.0, np.array(padded.shape[::-1]) - 1.001)
    low = np.floor(local).astype(int)
    u, v = np.moveaxis(local - low, -1, 0)
    c, r = np.moveaxis(low, -1, 0)
    below = padded[r, c] * (1 - u) + padded[r, c + 1] * u
    above = padded[r + 1, c] * (1 - u) + padded[r + 1, c + 1] * u
    return below * (1 - v) + above * v


def test_a_faded_crowd_says_nothing():
    # 200 / 0.5 a person per m²: below 1/400 of one the cost is less than 1.
    density = np.full((8, 12), 0.0024)
    assert crowding_patches(crowd(density), floor(), CrowdingCosts()) == ()


# --------------------------------------------------------------------------- keepout


def test_keepout_has_nav2s_costs():
    # Nav2: round(2.54 · mask), 100 is lethal, unknown says nothing.
    mask = floor(data=np.array([[FREE, 1, 50, 99, OCCUPIED, UNKNOWN]]))
    cost = keepout_costs((CostmapFilter(type="keepout", mask=mask),), mask)
    assert cost.tolist() == [[0, 3, 127, 251, 254, 0]]


def test_what_is_not_fully_closed_never_blocks():
    mask = floor(data=np.array([[0]]))
    barely = CostmapFilter(type="keepout", mask=mask, base=99.9)
    assert keepout_costs((barely,), mask).tolist() == [[252]]


def test_keepout_masks_combine_by_maximum():
    a = CostmapFilter(type="keepout", mask=floor(data=np.array([[50, 0]])))
    b = CostmapFilter(type="keepout", mask=floor(data=np.array([[20, 20]])))
    fast = CostmapFilter(type="speed_percent", mask=floor(data=np.array([[100, 100]])))
    assert keepout_costs((a, b, fast), a.mask).tolist() == [[127, 51]]


def test_a_closed_cell_is_an_obstacle_and_a_graded_one_a_cost():
    data = np.full((20, 30), FREE)
    closed, graded = data.copy(), data.copy()
    closed[8:12, 10:14] = OCCUPIED
    graded[8:12, 10:14] = 50
    grid = floor(data=data)
    wall = build_costmap(floor(data=closed), RADIUS, Inflation())
    kept_out = build_costmap(
        grid, RADIUS, Inflation(), filters=(CostmapFilter(type="keepout", mask=wall.grid),)
    )
    assert np.array_equal(kept_out.cost, wall.cost)
    assert np.array_equal(kept_out.clearance, wall.clearance)
    assert not np.array_equal(kept_out.walls, wall.walls)
    softer = CostmapFilter(type="keepout", mask=floor(data=graded))
    dear = build_costmap(grid, RADIUS, Inflation(), filters=(softer,))
    assert np.array_equal(dear.cost, np.where(graded == 50, 127, 0))
    assert dear.clearance is dear.walls


def test_a_known_rule_does_not_make_the_unknown_known():
    data = np.full((5, 5), UNKNOWN)
    mask = CostmapFilter(type="keepout", mask=floor(data=np.full((5, 5), 50)))
    assert (build_costmap(floor(data=data), 0.1, Inflation(), filters=(mask,)).cost == 255).all()
