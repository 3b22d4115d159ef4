"""Memory of obstacles that left the window of the live obstacle layer.

The layer is a window that rolls with the chair and drops cells that leave it. A path abandoned
because of a closed door would look free again as soon as the door leaves the window, and the chair
would turn back, see the door, and turn again. Therefore cells that leave are kept, used for
planning, and put back into the window when it returns, where beams clear them if the obstacle is
gone.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Booleans, Integers, Shape, replace, value
from cohelm.messages import LiveObstacles
from cohelm.perception import FloorEdges, ObstacleLayerParameters, ObstacleLayerState

MAX_CELLS = 20_000
"""Maximum number of cells, 50 m² at 5 cm; the oldest are dropped first."""


@value
class ObstacleMemory:
    """Occupied cells outside the live window."""

    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) in the map's grid, in the order in which they left the window."""


EMPTY = ObstacleMemory(cells=np.empty((0, 2), dtype=np.int64))


def update_obstacle_memory(
    memory: ObstacleMemory,
    before: ObstacleLayerState | None,
    now: ObstacleLayerState,
    parameters: ObstacleLayerParameters,
) -> tuple[ObstacleMemory, ObstacleLayerState]:
    """Store the cells that left the window, and put returning ones back into the layer.

    Returning cells get the maximum evidence, as if just observed.

    Args:
        memory: of the last tick.
        before: the layer of the last tick, None at first.
        now: the layer of this tick.
        parameters: of the layer.
    """
    if before is None or before.obstacles.corner.tolist() == now.obstacles.corner.tolist():
        return memory, now
    occupied = np.argwhere(before.obstacles.occupied) + before.obstacles.corner
    leaving = occupied[~_within(occupied, now.obstacles)]
    returning = _within(memory.cells, now.obstacles)
    layer = now
    if returning.any():
        layer = _restored(now, memory.cells[returning], parameters.max_evidence)
    elif not len(leaving):
        return memory, layer
    cells = np.concatenate([memory.cells[~returning], leaving])[-MAX_CELLS:]
    return ObstacleMemory(cells=cells), layer


@lru_cache(maxsize=2)
def merge_obstacles(
    live: LiveObstacles, memory: ObstacleMemory, edges: FloorEdges | None = None
) -> LiveObstacles:
    """Merge window, memory and edges of the floor; ``live`` itself where there is nothing to add.

    Cached, so that the result is the same object while nothing changes.
    """
    cells = memory.cells if edges is None else np.concatenate([memory.cells, edges.cells])
    if not len(cells):
        return live
    end = live.corner + live.occupied.shape
    low = np.minimum(live.corner, cells.min(axis=0))
    high = np.maximum(end, cells.max(axis=0) + 1)
    occupied = np.zeros(high - low, dtype=np.uint8)
    (r0, c0), (r1, c1) = live.corner - low, end - low
    occupied[r0:r1, c0:c1] = live.occupied
    rows, cols = (cells - low).T
    occupied[rows, cols] = 1
    return replace(live, corner=low, occupied=occupied)


def _within(cells: Integers, window: LiveObstacles) -> Booleans:
    end = window.corner + window.occupied.shape
    inside: Booleans = np.all([cells >= window.corner, cells < end], axis=(0, 2))
    return inside


def _restored(layer: ObstacleLayerState, cells: Integers, evidence: int) -> ObstacleLayerState:
    known = layer.obstacles
    rows, cols = (cells - known.corner).T
    counts, occupied = layer.evidence.copy(), known.occupied.copy()
    counts[rows, cols] = evidence
    occupied[rows, cols] = 1
    obstacles = replace(known, occupied=occupied, version=known.version + 1)
    return replace(layer, evidence=counts, obstacles=obstacles)
