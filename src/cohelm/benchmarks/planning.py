"""Time and memory of global planning, compared with other libraries on the same weights.

The map is a seeded floor of rooms with doors and boxes at 5 cm per cell, or a real map scaled to
each size. The path leads between two far corners of the free space. The others are scikit-image's
MCP_Geometric, which stops at the goal as ours does, and SciPy's Dijkstra, which reaches every cell.
All run in one process, one after the other.
Peak memory is that of a call.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import importlib
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

import cv2
import numpy as np
import typer
from pydantic import Field
from scipy.sparse.csgraph import dijkstra

from cohelm.arrays import Floats32, value
from cohelm.benchmarks.bench import BenchReport, Result, Sheet, Task
from cohelm.benchmarks.claims import (
    Bound,
    Verdict,
    bounded,
    verdict_notes,
    verdict_sheet,
    verdict_summary,
)
from cohelm.benchmarks.options import repeatable
from cohelm.benchmarks.planning_maps import far_apart, floor, scaled, step_graph
from cohelm.config import Model, override, validate
from cohelm.maps import OccupancyGrid, read_map
from cohelm.messages import LiveObstacles, Wish
from cohelm.planning.costmap.costmap import Costmap, build_costmap, combine
from cohelm.planning.costmap.layers.inflation import Inflation
from cohelm.planning.costmap.layers.preference import Preference, preference_costs, sources_of
from cohelm.planning.grid_search.shortest_path import forget_workspace, shortest_path
from cohelm.planning.grid_search.weights import Weights
from cohelm.planning.problem import CostmapParameters, weigh, weight_table
from cohelm.robots import load_robot
from cohelm.stopwatch import timed

_STATUS = Path("/proc/self/status")
_RESET = Path("/proc/self/clear_refs")


def peak_memory(call: Callable[[], Any]) -> float:
    """Measure the rise of the process's resident memory during a call, bytes.

    Memory that the process has freed but still holds is returned to the system first; otherwise a
    call that fits into it would seem to need none. NaN where the system does not report it.
    """
    gc.collect()
    try:
        with contextlib.suppress(AttributeError):  # malloc_trim belongs to glibc
            ctypes.CDLL(None).malloc_trim(0)
        _RESET.write_text("5", encoding="ascii")  # restarts the high-water mark
        before = _kilobytes("VmRSS")
        call()
        return 1024.0 * max(_kilobytes("VmHWM") - before, 0.0)
    except OSError:
        return math.nan


def _kilobytes(name: str) -> float:
    for line in _STATUS.read_text(encoding="ascii").splitlines():
        if line.startswith(f"{name}:"):
            return float(line.split()[1])
    raise OSError(f"{_STATUS} has no {name}")


TITLE = "Global planning: time and memory, compared with scikit-image and SciPy"

SIZES = (384, 1000, 4000)
"""Sides of the maps, cells."""
LARGEST = SIZES[-1]
FASTER = {1000: Bound(low=8.0), 4000: Bound(low=40.0)}
"""Size → required ratio of scikit-image's time to ours; that of 4000 is for real maps."""
MEMORY = Bound(high=300.0)
"""Memory of a plan beyond the map, MB."""
WHOLE, WINDOW = "costmap, whole, with a wish", "costmap and weights, a window of 10 m"
TIME = {WHOLE: Bound(high=1000.0), WINDOW: Bound(high=5.0)}
"""Median time of a new costmap on the largest maps, ms."""
PLAN, SCIKIT, SCIPY = "A* plan", "scikit-image MCP_Geometric", "SciPy dijkstra"

_WINDOW = 10.0  # side of the window of live obstacles, m
_SCIPY_CELLS = 1500**2
_SCIPY_BYTES = 4 * 100.0  # per cell: four steps, their entries, the graph in both directions


class WeightSettings(Model):
    """Parameters of costmap and weights; all may be set."""

    robot: str = "quantum_q6_edge"
    """Robot whose inscribed radius is inflated."""
    clearance: float = Field(0.05, ge=0.0, le=1.0)
    """Added to the radius, m; the default is that of a rider's profile."""
    cost_weight: float = CostmapParameters().cost_weight
    """Default of the grid planners."""
    inflation: Inflation = Inflation()
    preference: Preference = Preference()


@dataclass(frozen=True)
class PlanningBench:
    """The benchmark on one map or on seeded floors."""

    map_file: Path | None = None
    sizes: tuple[int, ...] = SIZES
    settings: tuple[str, ...] = ()
    """``dotted.key=value`` of :class:`WeightSettings`."""
    TITLE: str = TITLE
    SEEDS: int = 1
    WORKERS: int | None = 1

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per size and seed; a real map is equal for every seed."""
        if self.map_file is not None:
            return [(size, str(self.map_file)) for size in self.sizes]
        return [(size, seed) for size in self.sizes for seed in seeds]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """All measurements on one map."""
        size, which = task
        grid = floor(size, which) if isinstance(which, int) else scaled(Path(which), size)
        return [Result(row) for row in _measure(grid, size, which, _settings(self.settings))]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table per size, and the verdicts."""
        rows = [result.row for result in results]
        verdicts = list(_verdicts(rows))
        remarks = dict.fromkeys(str(row["remark"]) for row in rows if row["remark"])
        sheets = tuple(
            _sheet(size, which, [row for row in rows if (row["size"], row["map"]) == (size, which)])
            for size, which in dict.fromkeys((row["size"], row["map"]) for row in rows)
        )
        return BenchReport(
            sheets=(*sheets, verdict_sheet(verdicts)),
            notes=(*remarks, *verdict_notes(verdicts)),
            summary={"verdicts": verdict_summary(verdicts)},
        )


def create(
    map_file: Annotated[
        Path | None,
        typer.Option("--map", metavar="FILE.yaml", help="Map to scale; default: random floors."),
    ] = None,
    sizes: Annotated[
        tuple[int, ...],
        repeatable(
            "--size",
            "CELLS",
            "Cells a side; default: 384, 1000 and 4000",
            least=64,
            most=20_000,
        ),
    ] = (),
    settings: Annotated[
        tuple[str, ...],
        repeatable(
            "--set", "KEY=VALUE", "robot, clearance, cost_weight, inflation.…, preference.…"
        ),
    ] = (),
) -> PlanningBench:
    """Create the benchmark on a map (a Nav2 YAML) or on floors, of some sizes or of all.

    Raises:
        MapError: if the map cannot be read.
        ConfigError: if a setting does not exist.
    """
    if map_file is not None:
        read_map(map_file)
    load_robot(_settings(settings).robot)
    return PlanningBench(map_file, tuple(sorted(set(sizes))) or SIZES, tuple(settings))


def _settings(settings: Sequence[str]) -> WeightSettings:
    return validate(WeightSettings, override({}, settings))


@value
class PlanningTask:
    """Weights of one costmap and two cells far apart, for all libraries."""

    costmap: Costmap
    table: Floats32
    start: tuple[int, int]
    goal: tuple[int, int]

    def ours(self) -> float:
        """Cost of our path, with new weights."""
        return self.plan(Weights.of_costs(self.costmap.cost, self.table))

    def plan(self, weights: Weights) -> float:
        """Cost of our path; inf without one."""
        found = shortest_path(weights, self.start, self.goal)
        return math.inf if found is None else found.cost


def _measure(
    grid: OccupancyGrid, size: int, which: int | str, weighed: WeightSettings
) -> Iterator[dict[str, Any]]:
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)  # the time of other threads would not be counted
    try:
        inflation, preference = weighed.inflation, weighed.preference
        radius = load_robot(weighed.robot).inscribed_radius + weighed.clearance
        costmap = build_costmap(grid, radius, inflation)
        table = weight_table(weighed.cost_weight)
        ground = CostmapParameters(cost_weight=weighed.cost_weight, inflation=inflation)
        start, goal = far_apart(costmap)
        task = PlanningTask(costmap=costmap, table=table, start=start, goal=goal)
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
            PLAN: lambda: task.plan(weights),
            f"{PLAN}, new weights": task.ours,
            WHOLE: whole,
            WINDOW: window,
        }
        ours = {name: _row(size, which, name, call, 9) for name, call in calls.items()}
        for row in (*ours.values(), _scikit(task, size, which), _scipy(task, size, which)):
            ratio = row["median_ms"] / ours[PLAN]["median_ms"]
            yield {**row, "ratio": ratio if row["what"] in {SCIKIT, SCIPY} else math.nan}
    finally:
        cv2.setNumThreads(threads)


def _row(
    size: int, which: int | str, name: str, call: Callable[[], Any], rounds: int
) -> dict[str, Any]:
    time = timed(call, rounds)
    forget_workspace()  # the workspace kept between plans counts, too
    memory = peak_memory(call)
    return {
        **_empty(size, which, name, ""),
        "median_ms": time.median,
        "p99_ms": time.p99,
        "rounds": time.rounds,
        "memory_mb": 1e-6 * memory,
    }


def _empty(size: int, which: int | str, name: str, remark: str) -> dict[str, Any]:
    nan = dict.fromkeys(("median_ms", "p99_ms", "rounds", "memory_mb"), math.nan)
    where = f"floor {which}" if isinstance(which, int) else Path(which).stem
    return {"size": size, "map": where, "what": name, **nan, "ratio": math.nan, "remark": remark}


def _scikit(task: PlanningTask, size: int, which: int | str) -> dict[str, Any]:
    try:
        mcp = importlib.import_module("skimage.graph").MCP_Geometric
    except ImportError:
        return _empty(
            size, which, SCIKIT, "scikit-image is not installed: pip install cohelm[bench]"
        )
    costs = np.where(np.isfinite(task.table), task.table, -1.0)[task.costmap.cost]
    costs = costs.astype(np.float64)

    def call() -> float:
        found, _ = mcp(costs).find_costs([task.start], [task.goal])
        return float(found[task.goal])

    # It may cut the corners of blocked cells, so its path may be slightly cheaper.
    return _row(size, which, SCIKIT, call, 2)


def _scipy(task: PlanningTask, size: int, which: int | str) -> dict[str, Any]:
    if size * size > _SCIPY_CELLS:
        gigabytes = 1e-9 * _SCIPY_BYTES * size * size
        remark = f"SciPy was not run at {size}²: its graph takes about {gigabytes:.0f} GB"
        return _empty(size, which, SCIPY, remark)
    graph = step_graph(task.table[task.costmap.cost])
    index = task.start[0] * size + task.start[1]
    return _row(size, which, SCIPY, lambda: dijkstra(graph, directed=False, indices=index), 1)


def _wish(grid: OccupancyGrid) -> Wish:
    """Wish to pass through the middle of the map."""
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
        columns=("", "median, ms", "p99, ms", "memory, MB", "time ratio to A* plan"),
        rows=tuple((str(row["what"]), *(cell(row, *key) for key in keys)) for row in rows),
    )


def _verdicts(rows: Sequence[Any]) -> Iterator[Verdict]:
    for row in rows:
        size, what = row["size"], row["what"]
        subject = f"{size}², {row['map']}"
        if what == SCIKIT and size in FASTER and math.isfinite(row["ratio"]):
            remark = "required of real maps" if size == LARGEST else ""
            claim = "time ratio of scikit-image to ours"
            yield bounded(subject, claim, row["ratio"], FASTER[size], f"{row['ratio']:.1f}", remark)
        if what == PLAN and math.isfinite(row["memory_mb"]):
            claim = "memory of a plan, MB"
            yield bounded(subject, claim, row["memory_mb"], MEMORY, f"{row['memory_mb']:.1f}")
        if size == LARGEST and what in TIME:
            median = row["median_ms"]
            yield bounded(subject, f"{what}, median ms", median, TIME[what], f"{median:.1f}")
