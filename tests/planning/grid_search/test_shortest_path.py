"""The search is exact: it agrees with other libraries and never cuts a corner."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from skimage.graph import MCP_Geometric

from cohelm.errors import PlanningTimeout
from cohelm.planning.costmap.patch import INSCRIBED
from cohelm.planning.grid_search.shortest_path import shortest_path
from cohelm.planning.grid_search.weights import Weights

from .oracles import least_cost, random_weights


def check_steps(weights, cells):
    """Every step goes to one of the eight neighbours, over free cells, past no blocked corner."""
    steps = np.abs(np.diff(cells, axis=0))
    assert (steps.max(axis=1) == 1).all()
    assert np.isfinite(weights[tuple(cells.T)]).all()
    a, b = cells[:-1], cells[1:]
    assert np.isfinite(weights[a[:, 0], b[:, 1]]).all()
    assert np.isfinite(weights[b[:, 0], a[:, 1]]).all()


@settings(max_examples=500, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), rows=st.integers(1, 24), cols=st.integers(2, 24))
def test_costs_what_dijkstra_says(seed, rows, cols):
    rng = np.random.default_rng(seed)
    weights = random_weights(rng, rows, cols, share_blocked=rng.uniform(0.0, 0.4))
    start, goal = (0, 0), (rows - 1, cols - 1)
    weights[start] = weights[goal] = 1.0
    expected = least_cost(weights, start, goal)
    found = shortest_path(Weights.of(weights), start, goal)
    if found is None:
        assert np.isinf(expected)
        return
    assert found.cost == pytest.approx(expected, rel=1e-9)
    assert tuple(found.cells[0]) == start
    assert tuple(found.cells[-1]) == goal
    check_steps(weights, found.cells)


@pytest.mark.parametrize("seed", range(20))
def test_costs_what_scikit_image_says(seed):
    # MCP_Geometric cuts corners, so the grids have none to cut.
    rng = np.random.default_rng(seed)
    weights = random_weights(rng, 60, 80, share_blocked=0.0)
    start, goal = (3, 5), (55, 71)
    costs, _ = MCP_Geometric(weights.astype(np.float64)).find_costs([start], [goal])
    assert shortest_path(Weights.of(weights), start, goal).cost == pytest.approx(
        costs[goal], rel=1e-9
    )


@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e9])
def test_is_exact_however_far_the_weights_are_apart(ratio):
    rng = np.random.default_rng(7)
    weights = np.where(rng.random((40, 40)) < 0.5, 1.0, ratio).astype(np.float32)
    start, goal = (0, 0), (39, 39)
    found = shortest_path(Weights.of(weights), start, goal)
    assert found.cost == pytest.approx(least_cost(weights, start, goal), rel=1e-9)


@pytest.mark.parametrize("mirror", [np.fliplr, np.flipud, np.transpose])
def test_a_mirrored_map_costs_the_same(mirror):
    weights = random_weights(np.random.default_rng(3), 50, 50)
    ends = np.zeros((2, 50, 50), dtype=bool)
    ends[0, 2, 3] = ends[1, 45, 40] = True
    weights[2, 3] = weights[45, 40] = 1.0
    direct = shortest_path(Weights.of(weights), (2, 3), (45, 40))
    start, goal = (tuple(np.argwhere(mirror(end))[0]) for end in ends)
    mirrored = shortest_path(Weights.of(np.ascontiguousarray(mirror(weights))), start, goal)
    assert mirrored.cost == pytest.approx(direct.cost, rel=1e-12)


def test_does_not_squeeze_between_two_blocked_cells():
    # . #    the diagonal from one free cell to the other touches two blocked ones
    # # .
    weights = np.array([[1.0, np.inf], [np.inf, 1.0]], dtype=np.float32)
    assert shortest_path(Weights.of(weights), (0, 0), (1, 1)) is None


def test_walks_round_a_corner():
    # Two columns about a blocked one with a gap below: two down, two across, two up.
    weights = np.ones((3, 3), dtype=np.float32)
    weights[0, 1] = weights[1, 1] = np.inf
    assert shortest_path(Weights.of(weights), (0, 0), (0, 2)).cost == 6.0


@pytest.mark.parametrize("side", [9, 64, 65, 130])
def test_an_empty_floor_is_crossed_in_octile_steps(side):
    # Ten rows more than columns: side − 11 diagonal steps and ten straight ones.
    weights = Weights.of(np.full((side, side - 10 if side > 10 else side), 2.0, dtype=np.float32))
    rows, cols = (n - 2 for n in weights.packed.shape)
    found = shortest_path(weights, (0, 0), (rows - 1, cols - 1))
    expected = 2.0 * (rows - cols + (cols - 1) * np.sqrt(2.0))
    assert found.cost == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(12))
def test_rooms_of_even_ground_cost_what_dijkstra_says(seed):
    # Plateaus, where most steps are left out, beside rough ground, walls and doors.
    rng = np.random.default_rng(seed)
    weights = np.kron(rng.choice([1.0, 1.0, 2.0, 7.0, np.inf], (9, 12)), np.ones((11, 13)))
    rough = rng.random(weights.shape) < rng.choice([0.0, 0.01, 0.1])
    weights = np.where(rough, rng.uniform(1.0, 3.0, weights.shape), weights).astype(np.float32)
    free = np.argwhere(np.isfinite(weights))
    for start, goal in rng.choice(free, (6, 2)):
        expected = least_cost(weights, start, goal)
        found = shortest_path(Weights.of(weights), tuple(start), tuple(goal))
        if found is None:
            assert np.isinf(expected)
        else:
            assert found.cost == pytest.approx(expected, rel=1e-9)
            if len(found.cells) > 1:
                check_steps(weights, found.cells)


def test_the_start_is_a_path_to_itself():
    found = shortest_path(Weights.of(np.ones((2, 2), dtype=np.float32)), (1, 1), (1, 1))
    assert found.cost == 0.0
    assert found.cells.tolist() == [[1, 1]]


def test_the_budget_is_counted_in_cells():
    weights = Weights.of(np.ones((30, 30), dtype=np.float32))
    needed = shortest_path(weights, (0, 0), (29, 29)).expansions
    shortest_path(weights, (0, 0), (29, 29), max_expansions=needed)
    with pytest.raises(PlanningTimeout):
        shortest_path(weights, (0, 0), (29, 29), max_expansions=needed - 1)


def test_weights_must_be_positive():
    with pytest.raises(ValueError, match="positive"):
        Weights.of(np.zeros((2, 2), dtype=np.float32))


def test_weights_of_costs_block_from_inscribed_on():
    table = np.full(256, np.inf, dtype=np.float32)
    table[:INSCRIBED] = 1.0 + np.arange(INSCRIBED)
    weights = Weights.of_costs(np.array([[7, 252, 253, 254, 255]], dtype=np.uint8), table)
    assert weights.packed[1].tolist() == [np.inf, 8.0, 253.0, np.inf, np.inf, np.inf, np.inf]
    assert weights.lightest == 8.0
    assert weights.heaviest == 253.0


def read_moving_ai(file: Path):
    """Free cells of a map, and (start, goal, printed length) of its scenarios."""
    rows = Path(str(file).removesuffix(".scen")).read_text().splitlines()[4:]
    free = np.array([[c in ".GS" for c in row.strip("\r")] for row in rows if row.strip()])
    cases = [line.split() for line in file.read_text().splitlines()[1:] if line.strip()]
    return free, [((int(c[5]), int(c[4])), (int(c[7]), int(c[6])), c[8]) for c in cases]


def check_lengths(free, cases):
    """Every way is as long as printed, to a unit of the last digit, by one value of √2 for a file.

    Files that print eight digits were made with √2 = 1.414213562. That does not change which way is
    the shortest: straight + diagonal · √2 of different pairs up to ten thousand steps differ by
    more than 1 / (3 · 10⁴), and the two values of √2 make a difference of at most 10⁴ · 4e-10.
    """
    weights = np.where(free, 1.0, np.inf).astype(np.float32)
    packed = Weights.of(weights)
    errors = []
    for start, goal, printed in cases:
        cells = shortest_path(packed, start, goal).cells
        diagonal = int((np.abs(np.diff(cells, axis=0)).sum(axis=1) == 2).sum())
        straight = len(cells) - 1 - diagonal
        unit = 10.0 ** -len(printed.partition(".")[2])
        lengths = straight + diagonal * np.array([np.sqrt(2.0), 1.414213562])
        errors.append(np.abs(lengths - float(printed)) / unit)
        if diagonal + straight:
            check_steps(weights, cells)
    assert np.max(errors, axis=0).min() <= 1.0


def scenario_files(data):
    files = sorted((data / "movingai").glob("*.scen"))
    if not files:
        pytest.skip("COHELM_DATA has no folder movingai")
    return files


@pytest.mark.data
def test_moving_ai_lengths(data):
    for file in scenario_files(data):
        free, cases = read_moving_ai(file)
        check_lengths(free, [cases[0], cases[len(cases) // 2], cases[-1]])


@pytest.mark.data
@pytest.mark.slow
def test_every_moving_ai_length(data):
    for file in scenario_files(data):
        check_lengths(*read_moving_ai(file))
