"""How long global planning takes, beside scikit-image on the same weights.

    python benchmarks/planning.py [--size 1000] [--rounds 7]

Prints medians of thread CPU time in ms, and ratios taken in one run. The map is a seeded floor of
rooms with doors and furniture, 5 cm a cell, the way goes from one corner to the other.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from skimage.graph import MCP_Geometric

from cohelm.maps import FREE, OCCUPIED, OccupancyGrid
from cohelm.messages import LiveObstacles, Wish
from cohelm.planning import AStar, Inflation, RouteProblem, UserPreferenceField, build_costmap
from cohelm.planning.ground import GroundParameters, weight_table
from cohelm.planning.search import Weights, shortest_path
from cohelm.robots import load_robot

RESOLUTION = 0.05
ROOM = 100  # cells
DOOR = 24  # cells


def floor(size: int, seed: int = 0) -> OccupancyGrid:
    """Square rooms in rows, a door in every wall, boxes in the rooms."""
    rng = np.random.default_rng(seed)
    data = np.full((size, size), FREE, dtype=np.int8)
    for line in range(0, size, ROOM):
        data[line : line + 3, :] = data[:, line : line + 3] = OCCUPIED
    for line in range(0, size, ROOM):
        for room in range(0, size, ROOM):
            across, along = room + rng.integers(10, ROOM - DOOR - 10, size=2)
            if line > 0:
                data[line : line + 3, across : across + DOOR] = FREE
                data[along : along + DOOR, line : line + 3] = FREE
            r, c = rng.integers(30, ROOM - 45, size=2)
            data[line + r : line + r + 15, room + c : room + c + 15] = OCCUPIED
    data[[0, -1], :] = data[:, [0, -1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=RESOLUTION, X_MG=np.zeros(3))


def median(call: Callable[[], Any], rounds: int) -> float:
    """Median thread CPU time of a call, ms, after one that warms it up."""
    call()
    times = []
    for _ in range(rounds):
        begin = time.thread_time()
        call()
        times.append(time.thread_time() - begin)
    return 1e3 * float(np.median(times))


def rebuilt(grid: OccupancyGrid) -> OccupancyGrid:
    """The same grid under another identity, so that nothing kept for it is found."""
    return OccupancyGrid(data=grid.data, resolution=grid.resolution, X_MG=grid.X_MG)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--size", type=int, default=1000, help="side of the map, cells")
    arguments.add_argument("--rounds", type=int, default=7)
    given = arguments.parse_args()
    cv2.setNumThreads(1)  # else its other threads' time would not be counted

    grid, robot, inflation = floor(given.size), load_robot("quantum_q6_edge"), Inflation()
    radius = robot.inscribed_radius + 0.05
    end = given.size * RESOLUTION
    start, goal = np.array([1.0, 1.0]), np.full(2, (given.size // ROOM) * ROOM * RESOLUTION - 1.0)
    wish = Wish(points=np.array([[0.7 * end, 0.3 * end]]))
    problem = RouteProblem(grid=grid, robot=robot, start=start, goal=goal, clearance=0.05)
    wished = RouteProblem(
        grid=grid, robot=robot, start=start, goal=goal, clearance=0.05, wishes=(wish,)
    )
    live = LiveObstacles(
        corner=grid.cells(start) - 100,
        occupied=np.random.default_rng(1).random((200, 200)) < 0.002,
        version=1,
    )
    costmap = build_costmap(grid, radius, inflation)
    table = weight_table(GroundParameters().cost_weight)
    ends = tuple(tuple(int(i) for i in grid.cells(p)) for p in (start, goal))
    weights = Weights.of_costs(costmap.cost, table)
    found = shortest_path(weights, *ends)
    if found is None:
        raise SystemExit("the floor has no way from corner to corner")

    def ours() -> Any:
        return shortest_path(Weights.of_costs(costmap.cost, table), *ends)

    def theirs() -> Any:
        costs = np.where(np.isfinite(table), table, -1.0)[costmap.cost].astype(np.float64)
        return MCP_Geometric(costs).find_costs([ends[0]], [ends[1]])[0][ends[1]]

    search, peer = median(ours, given.rounds), median(theirs, max(given.rounds // 3, 1))
    rows = [
        ("costmap, whole", median(lambda: build_costmap(rebuilt(grid), radius, inflation), 3)),
        (
            "costmap, a 10 m window of live obstacles",
            median(lambda: build_costmap(grid, radius, inflation, live), given.rounds),
        ),
        ("A*, packing included", search),
        ("scikit-image MCP_Geometric", peer),
        ("astar plan, smoothed", median(lambda: AStar().plan(problem), given.rounds)),
        ("upf plan, smoothed", median(lambda: UserPreferenceField().plan(wished), given.rounds)),
    ]
    print(f"{given.size}² cells, {found.expansions} expanded, medians of thread CPU time")
    for name, value in rows:
        print(f"  {name:42s} {value:9.2f} ms")
    # scikit-image may cut corners, so its cost may be a little lower.
    print(f"  cost, ours / theirs                        {found.cost / theirs():9.6f}")
    print(f"  scikit-image / A*                          {peer / search:9.1f} ×")


if __name__ == "__main__":
    main()
