"""Via points: the optimum over all via cells and orders, and the limits."""

import itertools

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from cohelm.errors import PlanningTimeout, TooManyWishes
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.via_points import (
    MAX_LAYERS,
    ViaChain,
    cheapest_via_path,
    via_price,
)
from cohelm.planning.grid_search.weights import Weights, path_cost

from .oracles import graph, random_weights

OPEN = Weights.of(np.ones((30, 40), dtype=np.float32))


class Ground:
    """A random grid of which scipy knows every distance."""

    def __init__(self, rng):
        self.plain = None
        while self.plain is None:
            weights = random_weights(rng, *rng.integers(5, 14, 2))
            free = np.argwhere(np.isfinite(weights))
            start, goal = free[rng.integers(len(free), size=2)]
            self.weights = Weights.of(weights)
            self.plain = shortest_path(self.weights, tuple(start), tuple(goal))
        size = weights.size
        self.between = dijkstra(graph(weights), directed=False)
        self.cells = np.stack(np.divmod(np.arange(size), weights.shape[1]), axis=-1)
        self.ends = np.array([start, goal]) @ [weights.shape[1], 1]
        self.price = float(np.exp(rng.uniform(-2.0, 4.0)))
        self.points = rng.uniform(-4.0, 18.0, (3, 2))
        if rng.random() < 0.3:
            self.points = np.rint(self.points)

    def best_in_order(self, points):
        """min over all v_1, v_2, … of cost(start → v_1 → v_2 … → goal) + Σ price · |v_k − p_k|."""
        so_far = self.between[self.ends[0]]
        for point in points:
            paid = so_far + self.price * np.hypot(*(self.cells - point).T)
            so_far = np.min(paid[:, None] + self.between, axis=0)
        return so_far[self.ends[1]]

    def found(self, *chains):
        """What the way found costs and pays."""
        given = tuple(ViaChain(points=np.array(points), price=self.price) for points in chains)
        way = cheapest_via_path(self.weights, self.plain, given)
        assert way.cells[0].tolist() == self.plain.cells[0].tolist()
        assert way.cells[-1].tolist() == self.plain.cells[-1].tolist()
        assert np.abs(np.diff(way.cells, axis=0)).max(initial=0) <= 1
        assert way.cost == path_cost(self.weights.packed, way.cells)
        return way.cost + via_price(way.cells.astype(float), given)


@pytest.mark.parametrize("seed", range(200))
def test_is_the_brute_force_minimum(seed):
    ground = Ground(np.random.default_rng(seed))
    a, b, c = ground.points
    assert ground.found([a]) == pytest.approx(ground.best_in_order([a]), rel=1e-9, abs=1e-6)
    assert ground.found([a, b]) == pytest.approx(ground.best_in_order([a, b]), rel=1e-9, abs=1e-6)
    orders = [ground.best_in_order(order) for order in itertools.permutations([a, b, c])]
    assert ground.found([a], [b], [c]) == pytest.approx(min(orders), rel=1e-9, abs=1e-6)
    orders = [ground.best_in_order(order) for order in ([a, b, c], [a, c, b], [c, a, b])]
    assert ground.found([a, b], [c]) == pytest.approx(min(orders), rel=1e-9, abs=1e-6)


def via(*chains, start=(15, 2), goal=(15, 37), price=3.0, **more):
    """On an open floor."""
    given = tuple(ViaChain(points=np.array(points, dtype=float), price=price) for points in chains)
    return cheapest_via_path(OPEN, shortest_path(OPEN, start, goal), given, **more)


def test_an_open_floor_is_crossed_through_the_points():
    way = via([[3, 10], [25, 30]])
    cells = way.cells.tolist()
    assert cells.index([3, 10]) < cells.index([25, 30])
    assert way.cells[way.waypoints].tolist() == [[3, 10], [25, 30]]
    # octile: (12, 8), (22, 20), (10, 7)
    more = np.sqrt(2.0) - 1.0
    assert way.cost == pytest.approx(12 + 8 * more + 22 + 20 * more + 10 + 7 * more)


def test_order_within_a_wish_is_kept_and_among_wishes_is_not():
    assert via([[15, 30], [15, 10]]).cost == pytest.approx(28 + 20 + 27)  # there, back and on
    assert via([[15, 30]], [[15, 10]]).cost == pytest.approx(35)


def test_five_wishes_in_any_order_are_passed_in_the_best():
    points = [[15, 35], [15, 5], [12, 20], [18, 28], [15, 12]]
    way = via(*([point] for point in points))
    assert all(point in way.cells.tolist() for point in points)
    turned = via(*([point] for point in points[::-1]))
    assert turned.cost == pytest.approx(way.cost)


@pytest.mark.parametrize("price", [0.5, 1.0, 1.9])
def test_a_price_below_what_a_detour_costs_is_not_worth_a_dead_end(price):
    # Going r cells straight back and again forward costs 2 r and saves price · r.
    assert via([[15, 0]], price=price).cost == pytest.approx(35)
    assert via([[15, 0]], price=2.1).cost == pytest.approx(35 + 4)


def test_nothing_to_come_near_to_leaves_the_plain_way():
    plain = shortest_path(OPEN, (15, 2), (15, 37))
    assert cheapest_via_path(OPEN, plain, ()) is plain
    assert cheapest_via_path(OPEN, plain, (ViaChain(points=np.empty((0, 2)), price=2.0),)) is plain
    assert cheapest_via_path(OPEN, plain, (ViaChain(points=np.ones((1, 2)), price=0.0),)) is plain


def test_a_way_from_a_cell_to_itself_goes_there_and_back():
    way = via([[15, 12]], start=(15, 2), goal=(15, 2))
    assert way.cost == pytest.approx(20)
    assert way.cells[way.waypoints].tolist() == [[15, 12]]


def test_a_long_chain_is_followed():
    angle = np.linspace(0.0, np.pi, 60)
    arc = np.stack([15 + 12 * np.sin(angle), 19.5 - 17.5 * np.cos(angle)], axis=-1)
    way = via(arc)
    near = np.hypot(*(way.cells[:, None] - arc[None]).transpose(2, 0, 1)).min(axis=0)
    assert near.max() <= np.sqrt(0.5)
    assert len(way.waypoints) < 20  # only where it turns


def test_a_stretch_between_pins_is_straight_to_a_cell():
    way = via([[15, 10], [15, 20], [15, 30]])
    assert len(way.waypoints) == 0  # all on the straight way already


def test_too_many_orders_are_refused_with_what_to_do():
    points = np.random.default_rng(0).uniform(0, 30, (9, 2))
    with pytest.raises(TooManyWishes, match="one wish") as error:
        via(*([point] for point in points))
    assert (error.value.layers, error.value.most) == (2**9, MAX_LAYERS)
    assert via(points).cost > 35  # in order they are few


def test_the_budget():
    with pytest.raises(PlanningTimeout):
        via([[3, 10]], max_expansions=20)


def test_a_far_point_costs_no_more_search_than_a_near_one():
    near, far = via([[15, 100]]), via([[15, 100_000]])
    assert far.expansions <= 2 * near.expansions
    assert far.cost == pytest.approx(near.cost)
