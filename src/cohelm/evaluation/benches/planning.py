"""How long global planning takes and how much memory, beside others on the same weights.

The map is a seeded floor of rooms with doors and boxes at 5 cm a cell, or a real map stretched to
each size. The way leads between two far corners of what the chair can reach. The others are
scikit-image's MCP_Geometric, which stops at the goal as ours does, and SciPy's Dijkstra, which
knows no goal and reaches every cell. All run in one process, one after the other.
"""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from pydantic import Field
from scipy.sparse.csgraph import dijkstra

from cohelm.arrays import Floats32, value
from cohelm.config import Model, override, validate
from cohelm.evaluation.benches.bench import Report, Result, Sheet, Task
from cohelm.evaluation.benches.step_graph import step_graph
from cohelm.evaluation.benches.stopwatch import peak_memory, timed
from cohelm.maps import FREE, OCCUPIED, MapWarning, OccupancyGrid, read_map
from cohelm.messages import LiveObstacles, Wish
from cohelm.planning.cost_values import INSCRIBED
from cohelm.planning.costmap import Costmap, Inflation, build_costmap, combine
from cohelm.planning.ground import GroundParameters, weigh, weight_table
from cohelm.planning.layers.preference import Preference, preference_costs, sources_of
from cohelm.planning.search import Weights, shortest_path
from cohelm.planning.workspace import forget
from cohelm.robots import load_robot

TITLE = "Global planning: time and memory beside scikit-image and SciPy"
SEEDS = 1
WORKERS = 1

SIZES = (384, 1000, 4000)
"""Sides of the maps, cells."""
GREATEST = SIZES[-1]
LEAST = {1000: 8.0, 4000: 40.0}
"""How many times faster than scikit-image a plan has to be; of the greatest, on real maps."""
MOST_MEMORY = 300e6
"""Beyond the map that a plan may take, bytes."""
WHOLE, WINDOW = "costmap, whole, with a wish", "costmap and weights, a window of 10 m"
MOST_TIME = {WHOLE: 1000.0, WINDOW: 5.0}
"""What making the costmap anew may take on the greatest maps, median, ms."""
PLAN, SCIKIT, SCIPY = "A* plan", "scikit-image MCP_Geometric", "SciPy dijkstra"

_RESOLUTION, _ROOM, _DOOR = 0.05, 100, 24  # m, cells, cells
_WINDOW = 10.0  # side of the window of live obstacles, m
_SCIPY_CELLS = 1500**2
_SCIPY_BYTES = 4 * 100.0  # a cell: four steps, their entries, the graph both ways


class Weighed(Model):
    """What the map is made into, and for whom; all of it may be set."""

    robot: str = "quantum_q6_edge"
    """Whose inscribed radius is inflated."""
    clearance: float = Field(0.05, ge=0.0, le=1.0)
    """Added to the radius, m; that of a rider's profile by default."""
    cost_weight: float = GroundParameters().cost_weight
    """As of the grid planners."""
    inflation: Inflation = Inflation()
    preference: Preference = Preference()


@dataclass(frozen=True)
class PlanningBench:
    """The benchmark on one map or on seeded floors."""

    map_file: Path | None = None
    sizes: tuple[int, ...] = SIZES
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of :class:`Weighed`."""
    TITLE: str = TITLE
    SEEDS: int = SEEDS
    WORKERS: int | None = WORKERS

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One for each size and seed; a real map is the same for every seed."""
        if self.map_file is not None:
            return [(size, str(self.map_file)) for size in self.sizes]
        return [(size, seed) for size in self.sizes for seed in seeds]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """All measurements on one map."""
        size, which = task
        grid = floor(size, which) if isinstance(which, int) else stretched(Path(which), size)
        return [Result(row) for row in _measure(grid, size, which, _weighed(self.settings))]

    def report(self, results: Sequence[Result], folder: Path) -> Report:
        """A table for each size, and whether the figures asked for are met."""
        rows = [result.row for result in results]
        notes = [*_verdicts(rows), *(str(row["remark"]) for row in rows if row["remark"])]
        sheets = tuple(
            _sheet(size, which, [row for row in rows if (row["size"], row["map"]) == (size, which)])
            for size, which in dict.fromkeys((row["size"], row["map"]) for row in rows)
        )
        return Report(sheets=sheets, notes=tuple(dict.fromkeys(notes)), summary={})


def on(
    map_file: Path | None = None, sizes: Sequence[int] = (), settings: Sequence[str] = ()
) -> PlanningBench:
    """The benchmark on a map, a YAML as Nav2 writes it, or on floors; of some sizes or of all.

    Raises:
        MapError: if the map cannot be read.
        ConfigError: if a setting is of nothing that is weighed.
    """
    if map_file is not None:
        read_map(map_file)
    load_robot(_weighed(settings).robot)
    return PlanningBench(map_file, tuple(sorted(set(sizes))) or SIZES, tuple(settings))


def _weighed(settings: Sequence[str]) -> Weighed:
    return validate(Weighed, override({}, settings))


def floor(size: int, seed: int) -> OccupancyGrid:
    """Square rooms in rows, a door in every wall, boxes in the rooms."""
    rng = np.random.default_rng(seed)
    data = np.full((size, size), FREE, dtype=np.int8)
    for line in range(0, size, _ROOM):
        data[line : line + 3, :] = data[:, line : line + 3] = OCCUPIED
    for line in range(0, size, _ROOM):
        for room in range(0, size, _ROOM):
            across, along = room + rng.integers(10, _ROOM - _DOOR - 10, size=2)
            if line > 0:
                data[line : line + 3, across : across + _DOOR] = FREE
                data[along : along + _DOOR, line : line + 3] = FREE
            r, c = rng.integers(30, _ROOM - 45, size=2)
            data[line + r : line + r + 15, room + c : room + c + 15] = OCCUPIED
    data[[0, -1], :] = data[:, [0, -1]] = OCCUPIED
    return OccupancyGrid(data=data, resolution=_RESOLUTION, X_MG=np.zeros(3))


def stretched(file: Path, size: int) -> OccupancyGrid:
    """A map stretched to a square of ``size`` cells by nearest neighbours, its resolution kept."""
    with warnings.catch_warnings():  # ``on`` has said them
        warnings.simplefilter("ignore", MapWarning)
        grid = read_map(file)
    data = cv2.resize(grid.data.view(np.uint8), (size, size), interpolation=cv2.INTER_NEAREST_EXACT)
    return replace(grid, data=data.view(np.int8))


@value
class Ways:
    """One costmap's weights and two cells far apart, as ours and as others take them."""

    costmap: Costmap
    table: Floats32
    start: tuple[int, int]
    goal: tuple[int, int]

    def ours(self) -> float:
        """The cost of our plan, weights made anew."""
        return self.plan(Weights.of_costs(self.costmap.cost, self.table))

    def plan(self, weights: Weights) -> float:
        """The cost of our plan; inf where no way leads."""
        found = shortest_path(weights, self.start, self.goal)
        return math.inf if found is None else found.cost


def far_apart(costmap: Costmap) -> tuple[tuple[int, int], tuple[int, int]]:
    """Two far corners of the largest part of a costmap that is connected."""
    free = (costmap.cost < INSCRIBED).astype(np.uint8)
    _, labels, stats, _ = cv2.connectedComponentsWithStats(free, connectivity=4)
    if len(stats) < 2:
        raise ValueError("nothing on this map is free for the chair")
    cells = np.argwhere(labels == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA])))
    sums = cells.sum(axis=1)
    (r0, c0), (r1, c1) = cells[[int(sums.argmin()), int(sums.argmax())]].tolist()
    return (r0, c0), (r1, c1)


def _measure(
    grid: OccupancyGrid, size: int, which: int | str, weighed: Weighed
) -> Iterator[dict[str, Any]]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # else the time of its other threads would not be counted
    try:
        inflation, preference = weighed.inflation, weighed.preference
        radius = load_robot(weighed.robot).inscribed_radius + weighed.clearance
        costmap = build_costmap(grid, radius, inflation)
        table = weight_table(weighed.cost_weight)
        ground = GroundParameters(cost_weight=weighed.cost_weight, inflation=inflation)
        start, goal = far_apart(costmap)
        ways = Ways(costmap=costmap, table=table, start=start, goal=goal)
        live = _live(grid, start)
        weights = Weights.of_costs(costmap.cost, table)
        wish = _wish(grid)

        def whole() -> Costmap:
            fresh = build_costmap(replace(grid), radius, inflation)
            sources = sources_of((wish,), grid.centres(start), preference)
            return combine(fresh, preference_costs(grid, sources, preference))

        def window() -> Weights:
            changed = build_costmap(grid, radius, inflation, live)
            return weigh(changed, goal, ground)

        calls: dict[str, Callable[[], Any]] = {
            PLAN: lambda: ways.plan(weights),
            f"{PLAN}, weights made anew": ways.ours,
            WHOLE: whole,
            WINDOW: window,
        }
        ours = {name: _row(size, which, name, call, 9) for name, call in calls.items()}
        for row in (*ours.values(), _scikit(ways, size, which), _scipy(ways, size, which)):
            ratio = row["median_ms"] / ours[PLAN]["median_ms"]
            yield {**row, "ratio": ratio if row["what"] in {SCIKIT, SCIPY} else math.nan}
    finally:
        cv2.setNumThreads(threads)


def _row(
    size: int, which: int | str, name: str, call: Callable[[], Any], rounds: int
) -> dict[str, Any]:
    time = timed(call, rounds)
    forget()  # else what is kept between plans would not be counted
    memory = peak_memory(call)
    return {
        **_empty(size, which, name, ""),
        "median_ms": 1e3 * time.median,
        "p99_ms": 1e3 * time.p99,
        "rounds": time.rounds,
        "memory_mb": 1e-6 * memory,
    }


def _empty(size: int, which: int | str, name: str, remark: str) -> dict[str, Any]:
    nan = dict.fromkeys(("median_ms", "p99_ms", "rounds", "memory_mb"), math.nan)
    where = f"floor {which}" if isinstance(which, int) else Path(which).stem
    return {"size": size, "map": where, "what": name, **nan, "ratio": math.nan, "remark": remark}


def _scikit(ways: Ways, size: int, which: int | str) -> dict[str, Any]:
    try:
        mcp = importlib.import_module("skimage.graph").MCP_Geometric
    except ImportError:
        return _empty(
            size, which, SCIKIT, "scikit-image is not installed: pip install cohelm[bench]"
        )
    costs = np.where(np.isfinite(ways.table), ways.table, -1.0)[ways.costmap.cost]
    costs = costs.astype(np.float64)

    def call() -> float:
        found, _ = mcp(costs).find_costs([ways.start], [ways.goal])
        return float(found[ways.goal])

    # It may cut the corners of blocked cells, so what it finds may be cheaper by a little.
    return _row(size, which, SCIKIT, call, 2)


def _scipy(ways: Ways, size: int, which: int | str) -> dict[str, Any]:
    if size * size > _SCIPY_CELLS:
        gigabytes = 1e-9 * _SCIPY_BYTES * size * size
        remark = f"SciPy was not run at {size}²: its graph takes about {gigabytes:.0f} GB"
        return _empty(size, which, SCIPY, remark)
    graph = step_graph(ways.table[ways.costmap.cost])
    index = ways.start[0] * size + ways.start[1]
    return _row(size, which, SCIPY, lambda: dijkstra(graph, directed=False, indices=index), 1)


def _wish(grid: OccupancyGrid) -> Wish:
    """To pass by the middle of the map."""
    return Wish(points=grid.centres(np.array([grid.shape]) // 2))


def _live(grid: OccupancyGrid, start: tuple[int, int]) -> LiveObstacles:
    side = round(_WINDOW / grid.resolution)
    return LiveObstacles(
        corner=np.array(start) - side // 2,
        occupied=(np.random.default_rng(1).random((side, side)) < 0.002).astype(np.uint8),
        version=1,
    )


def _sheet(size: int, which: str, rows: Sequence[Any]) -> Sheet:
    def cell(row: Any, key: str, digits: int) -> str:
        return f"{row[key]:.{digits}f}" if math.isfinite(row[key]) else ""

    keys = (("median_ms", 2), ("p99_ms", 2), ("memory_mb", 1), ("ratio", 1))
    return Sheet(
        title=f"{size}² cells, {which}",
        columns=("", "median, ms", "p99, ms", "memory, MB", "× A* plan"),
        rows=tuple((str(row["what"]), *(cell(row, *key) for key in keys)) for row in rows),
    )


def _verdicts(rows: Sequence[Any]) -> Iterator[str]:
    for row in rows:
        size, what, where = row["size"], row["what"], row["map"]
        least = LEAST.get(size)
        if what == SCIKIT and least is not None and math.isfinite(row["ratio"]):
            asked = f"{least:g} asked" if size < GREATEST else f"{least:g} asked of real maps"
            word = _word(row["ratio"] >= least)
            yield f"{size}², {where}: {row['ratio']:.1f} times scikit-image, {asked}: {word}"
        if what == PLAN and math.isfinite(row["memory_mb"]):
            word, most = _word(1e6 * row["memory_mb"] <= MOST_MEMORY), 1e-6 * MOST_MEMORY
            yield f"{size}², {where}: {row['memory_mb']:.1f} MB, at most {most:g} asked: {word}"
        if size == GREATEST and what in MOST_TIME:
            word, most = _word(row["median_ms"] <= MOST_TIME[what]), MOST_TIME[what]
            yield f"{what}: {row['median_ms']:.1f} ms, at most {most:g} asked: {word}"


def _word(met: bool) -> str:
    return "met" if met else "MISSED"
