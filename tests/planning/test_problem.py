"""The prepared problem: all layers, checked ends, windows equal to the whole costmap."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.errors import GoalBlocked, StartBlocked
from cohelm.geometry import compose, transform
from cohelm.maps import FREE, OCCUPIED, CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, LiveObstacles, Wish
from cohelm.planning.costmap.costmap import build_costmap, combine
from cohelm.planning.costmap.layers.inflation import Inflation
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.planners.route import closed_by_keepout, closed_by_zones
from cohelm.planning.problem import (
    CostmapParameters,
    PreparedProblem,
    costmap_for,
    prepare,
    weigh,
)

from .floors import CHAIR, problem, room

P = CostmapParameters()
CORRIDORS = room(14.0, 8.0, boxes=[(3.0, 2.5, 11.0, 5.5)])
"""Two corridors, 2.4 m wide, above and below a block."""
FROM, TO = (1.52, 4.63), (12.52, 4.63)
"""Nearer to the upper corridor."""


def avoid(*points, radius=0.0, hard=False):
    return Wish(kind="avoid", points=np.array(points, dtype=float), radius=radius, hard=hard)


def keepout(mask):
    return CostmapFilter(type="keepout", mask=mask)


def way(ground):
    """The middles (k, 2) of the cells of the cheapest way, m; None where there is none."""
    found = shortest_path(ground.weights, ground.start, ground.goal)
    return None if found is None else ground.problem.grid.centres(found.cells)


def goes_above(ground):
    points = way(ground)
    middle = points[np.abs(points[:, 0] - 7.0) < 0.1]
    return bool((middle[:, 1] > 4.0).all())


def test_nothing_said_is_the_nearer_corridor():
    assert goes_above(prepare(problem(CORRIDORS, FROM, TO), P))


@pytest.mark.parametrize("hard", [False, True])
def test_a_zone_moves_the_way_to_the_other_corridor(hard):
    wish = avoid([6.0, 6.8], [8.0, 6.8], radius=1.2, hard=hard)
    given_ = dataclasses.replace(problem(CORRIDORS, FROM, TO), wishes=(wish,))
    assert not goes_above(prepare(given_, P))


def test_a_soft_zone_is_crossed_where_no_way_is_left():
    wish = avoid([6.0, 0.0], [7.0, 0.0], [7.0, 8.0], [6.0, 8.0])
    ground = prepare(dataclasses.replace(problem(CORRIDORS, FROM, TO), wishes=(wish,)), P)
    assert way(ground) is not None


def test_hard_zones_that_leave_no_way_are_named():
    wish = avoid([7.0, 0.0], [7.0, 8.0], hard=True)
    ground = prepare(dataclasses.replace(problem(CORRIDORS, FROM, TO), wishes=(wish,)), P)
    assert way(ground) is None
    assert closed_by_zones(ground, P)
    assert not closed_by_keepout(ground, P)


def test_zones_are_not_blamed_for_walls():
    walled = room(14.0, 8.0, boxes=[(7.0, 0.0, 7.2, 8.0)])
    wish = avoid([3.0, 4.0], radius=0.3, hard=True)
    ground = prepare(dataclasses.replace(problem(walled, FROM, TO), wishes=(wish,)), P)
    assert way(ground) is None
    assert not closed_by_zones(ground, P)


def test_keepout_masks_that_leave_no_way_are_named():
    data = np.full((8, 14), FREE)
    data[:, 7] = OCCUPIED
    mask = OccupancyGrid(data=data, resolution=1.0, X_MG=np.zeros(3))
    given_ = dataclasses.replace(problem(CORRIDORS, FROM, TO), filters=(keepout(mask),))
    ground = prepare(given_, P)
    assert way(ground) is None
    assert closed_by_keepout(ground, P)
    assert not closed_by_zones(ground, P)


def test_a_goal_in_a_rule_says_which():
    given_ = problem(CORRIDORS, FROM, TO)
    zone = dataclasses.replace(given_, wishes=(avoid(TO, radius=0.1, hard=True),))
    with pytest.raises(GoalBlocked, match="lies in a zone to avoid"):
        prepare(zone, P)
    everywhere = OccupancyGrid(
        data=np.array([[OCCUPIED]]), resolution=2.0, X_MG=np.array([12, 4, 0])
    )
    masked = dataclasses.replace(given_, filters=(keepout(everywhere),))
    with pytest.raises(GoalBlocked, match="lies in a keepout zone"):
        prepare(masked, P)
    wall = problem(CORRIDORS, FROM, (7.0, 4.0))
    with pytest.raises(GoalBlocked, match="lies in a wall"):
        prepare(wall, P)
    beside_wall = dataclasses.replace(zone, goal=np.array([7.0, 4.0]))
    with pytest.raises(GoalBlocked, match="lies in a wall"):
        prepare(beside_wall, P)


@pytest.mark.parametrize("rule", ["zone", "mask"])
def test_a_start_in_a_rule_may_leave_it_by_the_short_way(rule):
    """From 0.5 m inside a closed strip 2.5 m deep, out and round it, never on through it."""
    given_ = problem(room(14.0, 8.0), (3.0, 2.0), (3.0, 6.0))
    strip = [[2.5, 1.0], [3.5, 1.0], [3.5, 5.0], [2.5, 5.0]]
    if rule == "zone":
        given_ = dataclasses.replace(given_, wishes=(avoid(*strip, hard=True),))
    else:
        mask = OccupancyGrid(
            data=np.full((4, 1), OCCUPIED), resolution=1.0, X_MG=np.array([2.5, 1.0, 0.0])
        )
        given_ = dataclasses.replace(given_, filters=(keepout(mask),))
    points = way(prepare(given_, P))
    inside = (points > [2.5, 1.0]).all(axis=1) & (points < [3.5, 5.0]).all(axis=1)
    length = np.hypot(*np.diff(points[inside], axis=0).T).sum()
    assert inside[0]
    assert not inside[-1]
    assert length < 1.0


def test_a_rule_opens_no_wall():
    given_ = problem(CORRIDORS, (7.0, 4.0), TO)
    wish = avoid([7.0, 4.0], radius=3.0, hard=True)
    with pytest.raises(StartBlocked):
        prepare(dataclasses.replace(given_, wishes=(wish,)), P)


def test_a_start_beside_a_zone_does_not_open_it():
    """Only the zone that the chair stands in is opened."""
    wishes = (avoid([1.5, 4.6], radius=0.6, hard=True), avoid([6.5, 6.8], radius=0.6, hard=True))
    ground = prepare(dataclasses.replace(problem(CORRIDORS, FROM, TO), wishes=wishes), P)
    row, col = ground.problem.grid.cells(np.array([6.5, 6.8]))
    assert np.isinf(ground.weights.packed[row + 1, col + 1])
    row, col = ground.start
    assert np.isfinite(ground.weights.packed[row + 1, col + 1])


# --------------------------------------------------------------------------- crowding and groups


def crowd_above(density):
    there = np.zeros((16, 28), dtype=np.float32)
    there[11:16, 10:18] = density
    return Crowding(density=there, resolution=0.5, X_MG=np.zeros(3))


def test_a_crowded_corridor_moves_the_way_and_decay_brings_it_back():
    given_ = problem(CORRIDORS, FROM, TO)
    crowded = dataclasses.replace(given_, crowding=crowd_above(0.5))
    assert not goes_above(prepare(crowded, P))
    faded = dataclasses.replace(given_, crowding=crowd_above(0.5 * np.exp(-6.0)))
    ground = prepare(faded, P)
    assert goes_above(ground)
    assert ground.weights is prepare(given_, P).weights


def test_a_path_does_not_cut_through_a_group_while_another_way_is_left():
    pair = np.array([[6.0, 5.8], [6.0, 7.6]])
    given_ = dataclasses.replace(problem(CORRIDORS, FROM, TO), groups=(pair,))
    assert not goes_above(prepare(given_, P))


def test_a_group_across_the_only_way_is_crossed():
    line = np.array([[6.0, 0.2], [6.0, 7.8]])
    given_ = dataclasses.replace(problem(room(14.0, 8.0), FROM, TO), groups=(line,))
    ground = prepare(given_, P)
    points = way(ground)
    assert points is not None
    # The highest weight is the extra cost, and the strip of 0.8 m costs as much as the detour.
    assert ground.weights.heaviest == pytest.approx(P.groups.detour / (2.0 * P.groups.reach))


def test_a_toll_outlives_another_layer():
    pair = np.array([[6.0, 5.8], [6.0, 7.6]])
    given_ = dataclasses.replace(problem(CORRIDORS, FROM, TO), groups=(pair,))
    costmap = costmap_for(given_, P)
    ground = prepare(given_, P)
    layer = np.zeros(costmap.cost.shape, dtype=np.uint8)
    again = weigh(combine(costmap, layer), ground.start, P)
    assert np.array_equal(again.packed, ground.weights.packed)
    assert again.heaviest == ground.weights.heaviest


# --------------------------------------------------------------------------- windows


def weights_of(cost):
    return Weights.of_costs(cost, _table()).packed


def _table():
    table = np.full(256, np.inf, dtype=np.float32)
    table[:253] = 1.0 + P.cost_weight * np.arange(253) / 252
    return table


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), large=st.sampled_from([False, False, True]))
def test_a_window_made_anew_is_the_whole_made_anew(seed, large):
    """Bit for bit: costs, weights and, as far as it inflates, clearance; small maps and large."""
    rng = np.random.default_rng(seed)
    shape = (1100, 1200) if large else (60, 70)  # from 4 MB on copies share pages
    data = np.where(rng.random(shape) < 0.002, OCCUPIED, FREE).astype(np.int8)
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.zeros(3))
    occupied = (rng.random((20, 25)) < 0.05).astype(np.uint8)
    corner = rng.integers(0, np.array(shape) - 25)
    live = LiveObstacles(corner=corner, occupied=occupied, version=1)
    drawn = data.copy()
    drawn[corner[0] : corner[0] + 20, corner[1] : corner[1] + 25][occupied > 0] = OCCUPIED
    whole = build_costmap(
        OccupancyGrid(data=drawn, resolution=0.1, X_MG=np.zeros(3)), 0.3, Inflation()
    )
    window = build_costmap(grid, 0.3, Inflation(), live)
    assert np.array_equal(window.cost, whole.cost)
    start = tuple(np.argwhere(whole.cost == whole.cost.min())[0])
    assert np.array_equal(weigh(window, start, P).packed, weights_of(whole.cost))
    near = whole.clearance <= Inflation().inflation_radius
    assert np.array_equal(window.clearance[near], whole.clearance[near])


def test_what_is_kept_never_changes_and_windows_know_nothing_of_each_other():
    data = np.zeros((2200, 2200), dtype=np.int8)
    data[::100, ::100] = OCCUPIED
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))
    base = build_costmap(grid, 0.3, Inflation())
    before = base.cost.copy(), base.clearance.copy()
    wall = np.ones((40, 40), dtype=np.uint8)
    a, b = (
        build_costmap(grid, 0.3, Inflation(), LiveObstacles(corner=at, occupied=wall, version=1))
        for at in ((500, 500), (1500, 700))
    )
    start = (50, 50)
    kept = weigh(base, start, P).packed.copy()
    of_a, of_b = weigh(a, start, P).packed, weigh(b, start, P).packed
    assert a.cost[520, 520] == b.cost[1520, 720] == 254
    assert a.cost[1520, 720] == b.cost[520, 520] == 0
    assert np.isinf(of_a[521, 521])
    assert np.isinf(of_b[1521, 721])
    assert of_a[1521, 721] == of_b[521, 521] == 1.0
    assert np.array_equal(base.cost, before[0])
    assert np.array_equal(base.clearance, before[1])
    assert np.array_equal(weigh(base, start, P).packed, kept)
    for costmap in (base, a, b):
        for array in (costmap.cost, costmap.clearance, costmap.walls):
            assert not array.flags.writeable


def test_the_order_of_layers_does_not_matter():
    """Costs combine by maximum, so any order gives the same."""
    wishes = (avoid([5.0, 6.8], radius=0.5), avoid([5.2, 6.5], radius=0.4, hard=True))
    pair = np.array([[6.0, 5.8], [6.0, 7.6]])
    given_ = problem(CORRIDORS, FROM, TO)
    one = dataclasses.replace(given_, wishes=wishes, groups=(pair,), crowding=crowd_above(0.3))
    other = dataclasses.replace(one, wishes=wishes[::-1])
    a, b = prepare(one, P), prepare(other, P)
    assert np.array_equal(a.costmap.cost, b.costmap.cost)
    assert np.array_equal(a.weights.packed, b.weights.packed)
    alone = [
        costmap_for(dataclasses.replace(given_, **said), P).cost
        for said in (
            {"wishes": wishes[:1]},
            {"wishes": wishes[1:]},
            {"groups": (pair,)},
            {"crowding": one.crowding},
        )
    ]
    assert np.array_equal(a.costmap.cost, np.maximum.reduce(alone))


@pytest.mark.parametrize("yaw", [0.5, -2.0])
def test_turning_the_world_turns_the_way(yaw):
    """Grid, wishes, groups, crowd and masks moved together: the very same costs."""
    X = np.array([3.0, -1.0, yaw])

    def moved(grid):
        return dataclasses.replace(grid, X_MG=compose(X, grid.X_MG))

    mask = OccupancyGrid(
        data=np.array([[50, OCCUPIED]]), resolution=0.5, X_MG=np.array([4, 1, 0.2])
    )
    pair = np.array([[6.0, 1.8], [6.0, 3.1]])
    zone = avoid([5.03, 6.81], radius=0.52, hard=True)
    here = RouteSetup(CORRIDORS, (mask,), (pair,), (zone,), crowd_above(0.3))
    there = RouteSetup(
        moved(CORRIDORS),
        (moved(mask),),
        (transform(X, pair),),
        (dataclasses.replace(zone, points=transform(X, zone.points)),),
        moved(here.crowding),
    )
    a, b = (
        here.ground(FROM, TO),
        there.ground(transform(X, np.array(FROM)), transform(X, np.array(TO))),
    )
    assert (a.start, a.goal) == (b.start, b.goal)
    # Rounding may move a cell's middle over an edge, and a graded cost by one.
    difference = np.abs(a.costmap.cost.astype(int) - b.costmap.cost.astype(int))
    assert (difference > 1).mean() < 1e-3


@dataclasses.dataclass
class RouteSetup:
    """What a problem says of the floor."""

    grid: OccupancyGrid
    masks: tuple[OccupancyGrid, ...]
    groups: tuple[np.ndarray, ...]
    wishes: tuple[Wish, ...]
    crowding: Crowding

    def ground(self, start, goal) -> PreparedProblem:
        given_ = problem(
            self.grid,
            start,
            goal,
            groups=self.groups,
            crowding=self.crowding,
            filters=tuple(keepout(mask) for mask in self.masks),
        )
        return prepare(dataclasses.replace(given_, wishes=self.wishes), P)


def test_speed_masks_do_not_move_the_way():
    mask = CostmapFilter(
        type="speed_percent",
        mask=OccupancyGrid(data=np.array([[10]]), resolution=20.0, X_MG=np.zeros(3)),
    )
    given_ = problem(CORRIDORS, FROM, TO)
    slow = dataclasses.replace(given_, filters=(mask,))
    assert prepare(slow, P).weights is prepare(given_, P).weights
    assert CHAIR.inscribed_radius < prepare(slow, P).costmap.radius
