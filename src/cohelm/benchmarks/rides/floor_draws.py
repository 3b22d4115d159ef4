"""Random rides on a real floor: start and goal that a seed draws."""

from __future__ import annotations

import warnings
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from cohelm.arrays import Floats
from cohelm.errors import PlanningError, ScenarioError
from cohelm.maps import UNKNOWN, MapWarning, OccupancyGrid, read_map
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import load_scenario
from cohelm.scenarios.walkable import CELL, spread, walkable
from cohelm.simulation import generator

SCENARIO = "hospital"
"""Scenario whose settings a ride on another floor takes."""
PASSAGE = 0.4
"""Radius of the disc that passes from start to goal, m; ``walkable`` adds 0.1 m: the chair is
0.61 m wide, and no ride depends on a passage narrower than 1 m."""
CLEARANCE = 0.9
"""Smallest distance of start and goal from a wall, m: the chair can turn there on the spot."""
APART = 8.0
"""Smallest distance of the goal from the start, m."""
LONGEST = 40.0
"""Longest path from start to goal, m."""
PEOPLE = (10, 12)
"""Smallest and largest number of people."""
SECONDS_PER_METRE = 5.0
"""Time limit for a metre of path, s, as in the scenario ``hospital``."""
SHORTEST_LIMIT = 60.0
"""Smallest time limit, s."""
TRIES = 60


class FloorDraw(NamedTuple):
    """Start, goal and people of a random ride."""

    start: tuple[float, float]
    """m."""
    goal: tuple[float, float]
    """m."""
    people: int
    time_limit: float
    """s, in proportion to the length of the shortest path."""


def draw_ride(file: Path, grid: OccupancyGrid, seed: int) -> FloorDraw | None:
    """Draw the ride of a seed on a floor; None where no two points of it are far enough apart.

    A draw without space for its people is drawn again.

    Args:
        file: map of the floor; its name is part of the seed.
        grid: see :func:`known_floor`.
        seed: of the draw, and of the ride.
    """
    x0, y0, x1, y1 = grid.bounds
    anywhere = np.array([[x0, y0], [x1, y1]])  # no route yet: no part of it is narrow
    floor = walkable(grid, PASSAGE, anywhere)
    cells = np.argwhere(floor.clearance >= CLEARANCE)
    points = floor.points(cells)
    rng = generator(seed, f"ride on {file.stem}")
    for k in rng.permutation(len(cells))[:TRIES]:
        row, col = (int(i) for i in cells[k])
        distance, _, _ = spread(floor.free, floor.narrow, row, col, LONGEST / CELL)
        length = distance[cells[:, 0], cells[:, 1]] * CELL
        fits = np.flatnonzero((np.hypot(*(points - points[k]).T) >= APART) & (length <= LONGEST))
        if not len(fits):
            continue
        goal = rng.choice(fits)
        draw = FloorDraw(
            start=_rounded(points[k]),
            goal=_rounded(points[goal]),
            people=int(rng.integers(PEOPLE[0], PEOPLE[1] + 1)),
            time_limit=time_limit(float(length[goal])),
        )
        if _has_space(file, draw, seed):
            return draw
    return None


def known_floor(file: Path) -> OccupancyGrid:
    """Map for the draws, with unknown cells also where its threshold takes them as free.

    Some maps read the usual shade of unknown cells as free; nobody has seen a floor there.
    """
    with warnings.catch_warnings():  # shown again when the map is ridden
        warnings.simplefilter("ignore", MapWarning)
        grid, image = read_map(file), file.with_suffix(".pgm")
        if not image.is_file():
            return grid
        unknown = read_map(image).data == UNKNOWN
    return replace(grid, data=np.where(unknown, UNKNOWN, grid.data).astype(np.int8))


def time_limit(length: float) -> float:
    """Time limit of a ride whose path has a length in m, in full seconds."""
    return float(np.ceil(max(SHORTEST_LIMIT, SECONDS_PER_METRE * length)))


def floor_settings(file: Path, draw: FloorDraw) -> tuple[str, ...]:
    """Settings that move the scenario ``hospital`` to another floor, as ``cohelm run --map``."""
    return (
        "floor=null",
        "prefer=[]",
        f"map={file}",
        f"start={list(draw.start)}",
        f"goal={list(draw.goal)}",
        f"people.count={draw.people}",
        f"time_limit={draw.time_limit:g}",
    )


def _has_space(file: Path, draw: FloorDraw, seed: int) -> bool:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MapWarning)
            build_scenario(load_scenario(SCENARIO, floor_settings(file, draw)), seed)
    except ScenarioError:
        return False
    except PlanningError:
        return True  # a ride that the planner refuses is a failure of the planner
    return True


def _rounded(point: Floats) -> tuple[float, float]:
    return round(float(point[0]), 2), round(float(point[1]), 2)
