"""What was seen standing and has gone out of the live window since: a closed door stays closed.

The live obstacle layer is a window that rolls with the chair and forgets what leaves it. A route
that was given up for a closed door would look free again as soon as the door is out of the window,
and the chair would turn back, see the door, and turn again. So what leaves is kept here cell by
cell, is planned around, and goes back into the window with it, where beams clear it if it is gone.
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Booleans, Integers, Shape, value
from cohelm.messages import LiveObstacles
from cohelm.perception import ObstacleLayerParameters, ObstacleLayerState

MOST = 20_000
"""Cells that are kept: 50 m² at 5 cm; of more, those that left last."""


@value
class Beyond:
    """Cells outside the live window."""

    cells: Annotated[Integers, Shape("k 2")]
    """(row, column) in the map's grid, in the order in which they left the window."""


NOTHING = Beyond(cells=np.empty((0, 2), dtype=np.int64))


def remember(
    beyond: Beyond,
    before: ObstacleLayerState | None,
    now: ObstacleLayerState,
    parameters: ObstacleLayerParameters,
) -> tuple[Beyond, ObstacleLayerState]:
    """What has left the window since ``before``, and the layer with what has come back into it.

    What comes back is occupied with the full evidence: as much as if it had just been seen.

    Args:
        beyond: what was outside before.
        before: the layer of the last tick, None at first.
        now: the layer of this one.
        parameters: of the layer.
    """
    if before is None or np.array_equal(before.obstacles.corner, now.obstacles.corner):
        return beyond, now
    stood = np.argwhere(before.obstacles.occupied) + before.obstacles.corner
    leaving = stood[~_within(stood, now.obstacles)]
    back = _within(beyond.cells, now.obstacles)
    layer = _put_back(now, beyond.cells[back], parameters.most) if back.any() else now
    if not (len(leaving) or back.any()):
        return beyond, layer
    return Beyond(cells=np.concatenate([beyond.cells[~back], leaving])[-MOST:]), layer


@lru_cache(maxsize=2)
def all_obstacles(live: LiveObstacles, beyond: Beyond) -> LiveObstacles:
    """Those of the window and those beyond it, in one window; ``live`` itself if there are none.

    Cached, so that as long as nothing changes the answer is the same object.
    """
    if not len(beyond.cells):
        return live
    end = live.corner + live.occupied.shape
    low = np.minimum(live.corner, beyond.cells.min(axis=0))
    high = np.maximum(end, beyond.cells.max(axis=0) + 1)
    occupied = np.zeros(high - low, dtype=np.uint8)
    (r0, c0), (r1, c1) = live.corner - low, end - low
    occupied[r0:r1, c0:c1] = live.occupied
    rows, cols = (beyond.cells - low).T
    occupied[rows, cols] = 1
    return replace(live, corner=low, occupied=occupied)


def _within(cells: Integers, window: LiveObstacles) -> Booleans:
    end = window.corner + window.occupied.shape
    inside: Booleans = np.all([cells >= window.corner, cells < end], axis=(0, 2))
    return inside


def _put_back(layer: ObstacleLayerState, cells: Integers, most: int) -> ObstacleLayerState:
    known = layer.obstacles
    rows, cols = (cells - known.corner).T
    evidence, occupied = layer.evidence.copy(), known.occupied.copy()
    evidence[rows, cols] = most
    occupied[rows, cols] = 1
    obstacles = replace(known, occupied=occupied, version=known.version + 1)
    return replace(layer, evidence=evidence, obstacles=obstacles)
