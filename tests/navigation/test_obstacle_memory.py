"""Obstacles that left the live window are kept, planned around, and put back."""

from dataclasses import replace

import numpy as np

from cohelm.messages import LiveObstacles
from cohelm.navigation.obstacle_memory import (
    EMPTY,
    MAX_CELLS,
    ObstacleMemory,
    merge_obstacles,
    update_obstacle_memory,
)
from cohelm.perception import FloorEdges, ObstacleLayerParameters, ObstacleLayerState

RULES = ObstacleLayerParameters()


def layer(corner, cells=(), version=1, side=10):
    """A window of ``side`` cells a side with map cells occupied."""
    occupied = np.zeros((side, side), dtype=np.uint8)
    for row, col in np.asarray(cells, dtype=int).reshape(-1, 2) - np.array(corner):
        occupied[row, col] = 1
    obstacles = LiveObstacles(corner=np.array(corner), occupied=occupied, version=version)
    return ObstacleLayerState(evidence=occupied * 9, obstacles=obstacles)


def test_what_leaves_is_kept_and_what_comes_back_stands_again():
    near, far = layer([0, 0], [(1, 1), (8, 8)]), layer([0, 5], [(8, 8)])
    memory, same = update_obstacle_memory(EMPTY, near, far, RULES)
    assert same is far
    assert memory.cells.tolist() == [[1, 1]]
    gone, back = update_obstacle_memory(memory, far, layer([0, 0], [(8, 8)], version=7), RULES)
    assert len(gone.cells) == 0
    assert np.argwhere(back.obstacles.occupied).tolist() == [[1, 1], [8, 8]]
    assert back.evidence[1, 1] == RULES.max_evidence
    assert back.obstacles.version == 8


def test_a_window_that_stays_changes_nothing():
    still = layer([0, 0], [(1, 1)])
    kept = ObstacleMemory(cells=np.array([[50, 50]]))
    assert update_obstacle_memory(kept, still, still, RULES) == (kept, still)
    assert update_obstacle_memory(EMPTY, None, still, RULES) == (EMPTY, still)


def test_the_oldest_are_forgotten_first():
    full = ObstacleMemory(cells=np.column_stack([np.arange(MAX_CELLS), np.full(MAX_CELLS, 900)]))
    memory, _ = update_obstacle_memory(full, layer([0, 0], [(1, 1)]), layer([0, 5]), RULES)
    assert len(memory.cells) == MAX_CELLS
    assert memory.cells[0].tolist() == [1, 900]
    assert memory.cells[-1].tolist() == [1, 1]


def test_all_of_it_lies_in_one_window():
    live = layer([10, 20], [(12, 23)]).obstacles
    assert merge_obstacles(live, EMPTY) is live
    memory = ObstacleMemory(cells=np.array([[3, 40], [15, 2]]))
    everything = merge_obstacles(live, memory)
    cells = np.argwhere(everything.occupied) + everything.corner
    assert sorted(map(tuple, cells.tolist())) == [(3, 40), (12, 23), (15, 2)]
    assert everything.version == live.version
    assert merge_obstacles(live, memory) is everything
    assert merge_obstacles(replace(live), memory) is not everything
    edges = FloorEdges(cells=np.array([[3, 40], [900, 4]]), version=1)
    barred = merge_obstacles(live, memory, edges)
    cells = np.argwhere(barred.occupied) + barred.corner
    assert sorted(map(tuple, cells.tolist())) == [(3, 40), (12, 23), (15, 2), (900, 4)]
