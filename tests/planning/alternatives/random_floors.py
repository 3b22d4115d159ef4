"""Random floors with rooms, doors and furniture, and sets of routes on them; all from a seed."""

import itertools

import numpy as np
from tests.planning.floors import CHAIR

from cohelm.errors import PlanningError
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid
from cohelm.messages import Crowding
from cohelm.planning import AStar, RouteProblem
from cohelm.planning.alternatives.alternatives import find_alternatives

RESOLUTION = 0.1


def storey(rng, width=36.0, height=26.0):
    """Rooms by halving, two doors in most walls, furniture; 0.1 m cells."""
    data = np.full((round(height / RESOLUTION), round(width / RESOLUTION)), FREE, dtype=np.int8)
    data[[0, 1, -1, -2]] = OCCUPIED
    data[:, [0, 1, -1, -2]] = OCCUPIED
    _divide(data[2:-2, 2:-2], rng)
    for _ in range(30):
        row, col = rng.integers(0, data.shape)
        deep, wide = rng.integers(4, 22, size=2)
        data[row : row + deep, col : col + wide] = OCCUPIED
    return OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.zeros(3))


def _divide(room, rng):
    """Cut a room (a view) across its longer side, and the halves again, down to about 5 m."""
    if room.shape[0] > room.shape[1]:
        room = room.T
    if room.shape[1] < 100:
        return
    at = int(room.shape[1] * rng.uniform(0.35, 0.65))
    room[:, at : at + 2] = OCCUPIED
    for _ in range(rng.integers(2, 4)):
        gap = int(rng.choice([9, 11, 16, 26]))
        low = rng.integers(0, room.shape[0] - gap)
        room[low : low + gap, at : at + 2] = FREE
    _divide(room[:, :at], rng)
    _divide(room[:, at + 2 :], rng)


def crowd(grid, rng):
    """Some gatherings of people, on cells of half a metre."""
    width, height = grid.size
    y, x = np.mgrid[0.25:height:0.5, 0.25:width:0.5]
    density = np.zeros(x.shape)
    for _ in range(rng.integers(4, 9)):
        cx, cy, reach = rng.uniform(0, width), rng.uniform(0, height), rng.uniform(1.5, 4.0)
        density += rng.uniform(0.05, 0.4) * np.exp(
            -0.5 * ((x - cx) ** 2 + (y - cy) ** 2) / reach**2
        )
    return Crowding(density=density, resolution=0.5, X_MG=np.zeros(3))


def route_sets(grids, rng, count, k=3):
    """``count`` sets of two to ``k`` routes each, on grids in turn, with their crowds."""
    sets = []
    for grid in itertools.cycle(grids):
        if len(sets) == count:
            return sets
        free = np.argwhere(grid.data == FREE)
        ends = grid.centres(free[rng.integers(len(free), size=2)])
        if not 14.0 < np.hypot(*(ends[1] - ends[0])) < 60.0:
            continue
        problem = RouteProblem(
            grid=grid, robot=CHAIR, start=ends[0], goal=ends[1], crowding=crowd(grid, rng)
        )
        try:
            routes = find_alternatives(problem, AStar(), k)
        except PlanningError:
            continue
        if len(routes) > 1:
            sets.append(routes)
    return sets
