"""Table 2 of Xu et al.: global planners compared by their distance from the rider's own path.

Ten office scenes, one click each, equal for every method. Each method's path is
ridden in simulation on the otherwise empty floor in autonomous mode.

The offices are semi-open, as the paper describes them. A room has a large block in its middle, open
floor on the left and clutter on the right. The rider prefers to pass on the left, although the path
through the clutter is shorter, and states this by an inexact click. Everything is drawn from a seed
by geometry, independent of any planner; docs/global-planning.md gives the reasons, and why these
scenes replace earlier ones.
"""

from __future__ import annotations

import itertools
import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import yaml
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

from cohelm import plugins
from cohelm.arrays import Floats, Shape, value
from cohelm.benchmarks.bench import BenchReport, Result, Task, known_name, split_names, unset
from cohelm.benchmarks.options import Settings, names
from cohelm.benchmarks.paper.global_report import DESIRED, MEASURES, global_report
from cohelm.errors import ConfigError, PlanningError
from cohelm.evaluation.episode.episode import Episode
from cohelm.evaluation.episode.ride import Outcome, Ride
from cohelm.evaluation.metrics.motion import path_error, path_length
from cohelm.evaluation.metrics.motion import time as time_to_goal
from cohelm.geometry import arc_length, distance_to_polygon, nearest_on_polyline, resample
from cohelm.maps import OccupancyGrid, distance_field, write_map
from cohelm.maps.drawing import Canvas, polygon_of_disc, polygon_of_rect, rotate
from cohelm.messages import Path as Route
from cohelm.messages import WishReport
from cohelm.planning import RouteProblem
from cohelm.plotting import RoutePanel
from cohelm.robots import Robot, load_robot
from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.scenario import PARTS, load_scenario
from cohelm.simulation import generator

RESOLUTION, WALL = 0.05, 0.10
"""Resolution of the map, and thickness of the outer walls, m."""
WIDTH, DEPTH = (12.0, 14.0), (12.5, 14.0)
"""Ranges of the room's sides, m."""
ENDS = 1.2
"""Distance of start and goal from the near and the far wall, m."""
BLOCK = ((2.6, 3.8), (2.0, 3.5))
"""Ranges of the central block's width and depth, m."""
OFF_CENTRE = 0.5
"""Largest offset of the block from the room's middle, and of start and goal sideways, m."""
MARGIN = (1.0, 2.5)
"""Range of the length saved on the right, m: both are taut lines from start to goal around the
central block alone."""
LANE = (1.4, 2.2)
"""Range of a scene's lane, m: the minimum distance between any two obstacles."""
BESIDE = (0.8, 1.6)
"""Range of the rider's preferred distance from the block's side, m."""
CLICK_DEVIATION = 0.3
"""Standard deviation of the rider's click in either direction, m."""
_TRIES = 1000


@value
class OfficeScene:
    """Room, start and goal, and the path that the rider wants."""

    seed: int
    grid: OccupancyGrid
    start: Annotated[Floats, Shape("2")]
    goal: Annotated[Floats, Shape("2")]
    block: Annotated[Floats, Shape("4 2")]
    """Corners of the central block, m."""
    desired: Annotated[Floats, Shape("k 2")]
    """Path that the rider wants, from start to goal, m."""
    click: Annotated[Floats, Shape("2")]
    """Input of the planners: the middle of the desired path as the rider clicked it, m."""
    margin: float
    """Length saved on the right, as taut lines around the block, m."""
    lane: float
    """Minimum distance between any two obstacles, m."""


def office(seed: int, robot: Robot) -> OfficeScene:
    """Draw the scene of a seed; the robot only sets the clearance of the desired path.

    A room that cannot have the drawn margin, or whose desired path does not clear the robot in
    every heading, is drawn again.
    """
    rng = generator(seed, "office")
    margin, lane = rng.uniform(*MARGIN), rng.uniform(*LANE)
    while True:
        width, depth = rng.uniform(*WIDTH), rng.uniform(*DEPTH)
        block = _block(rng, width, depth)
        ends = _ends(rng, block, depth, margin)
        if ends is None:
            continue
        start, goal = ends
        desired = _desired(rng, start, goal, block)
        if min(distance_to_polygon(block, x, y) for x, y in desired) < robot.circumscribed_radius:
            continue
        grid = _room(rng, (width, depth), block, ends, lane)
        if _clearance_along(grid, desired) >= robot.circumscribed_radius:
            break
    along = arc_length(desired)
    middle = np.array([np.interp(0.5 * along[-1], along, axis) for axis in desired.T])
    click = middle + generator(seed, "click").normal(scale=CLICK_DEVIATION, size=2)
    return OfficeScene(
        seed=seed,
        grid=grid,
        start=start,
        goal=goal,
        block=block,
        desired=desired,
        click=click,
        margin=margin,
        lane=lane,
    )


def on_the_left(line: Floats, block: Floats) -> bool:
    """Check that a line (k, 2) from start to goal passes the block on its left."""
    x, y = block.mean(axis=0)
    abreast = int(np.argmax(line[:, 1] >= y))
    return bool(line[abreast, 0] < x)


def taut(start: Floats, goal: Floats, block: Floats, side: int) -> float:
    """Length of the taut line from start to goal past two corners of the block, m.

    Args:
        start, goal: (2,), below and above the block, neither beside it nor beyond its sides.
        block: (4, 2), an upright rectangle.
        side: −1: on its left, +1: on its right.
    """
    x = block[:, 0].min() if side < 0 else block[:, 0].max()
    low, high = block[:, 1].min(), block[:, 1].max()
    line = [tuple(start), (x, low), (x, high), tuple(goal)]
    return math.fsum(math.dist(a, b) for a, b in itertools.pairwise(line))


def _block(rng: np.random.Generator, width: float, depth: float) -> Floats:
    """The corners (4, 2) of the block about the middle of the room."""
    centre = np.array([width, depth]) / 2.0 + rng.uniform(-OFF_CENTRE, OFF_CENTRE, size=2)
    return _box(centre, rng.uniform(*BLOCK[0]), rng.uniform(*BLOCK[1]), 0.0)


def _ends(rng: np.random.Generator, block: Floats, depth: float, margin: float) -> Floats | None:
    """Start and goal (2, 2), so far right that the right side is shorter by the margin.

    None where one of them would not lie between the block's middle and its right side.
    """
    middle, right = float(block[:, 0].mean()), float(block[:, 0].max())
    aside = rng.uniform(-OFF_CENTRE, OFF_CENTRE, size=2)

    def ends(x: float) -> Floats:
        return np.column_stack([x + aside, [ENDS, depth - ENDS]])

    def excess(x: float) -> float:
        start, goal = ends(x)
        return taut(start, goal, block, -1) - taut(start, goal, block, 1) - margin

    if excess(middle) > 0.0 or excess(right) < 0.0:
        return None
    found = ends(float(brentq(excess, middle, right)))
    return found if middle <= found[:, 0].min() and found[:, 0].max() <= right else None


def _room(
    rng: np.random.Generator, size: tuple[float, float], block: Floats, keep: Floats, lane: float
) -> OccupancyGrid:
    """The room of a size (width, depth), m, with its block and clutter right of it, off ``keep``.

    Pieces are added as long as the lane is free around them; the distance to the walls may be
    smaller.
    """
    width, depth = size
    canvas = Canvas(size=size, resolution=RESOLUTION, outside="occupied")
    canvas.floor(polygon_of_rect([0.0, 0.0, width, depth]), 0.0)
    canvas.block(block)
    clearance = canvas.clearance()
    for _ in range(_TRIES):
        centre = np.array([rng.uniform(block[:, 0].max(), width), rng.uniform(0.0, depth)])
        item = _item(rng, centre)
        outline = resample(np.vstack([item, item[:1]]), RESOLUTION)
        cells = np.floor(outline / RESOLUTION).astype(int)
        inside = ((cells >= 0) & (cells < np.array(clearance.shape)[::-1])).all()
        off = np.hypot(*(outline[:, None] - keep).T).min() >= ENDS
        if inside and off and clearance[cells[:, 1], cells[:, 0]].min() >= lane:
            canvas.block(item)
            clearance = canvas.clearance()
    canvas.wall(polygon_of_rect([0.0, 0.0, width, depth]), 2.0 * WALL)
    return canvas.grid()


def _item(rng: np.random.Generator, centre: Floats) -> Floats:
    """Corners (k, 2) of a desk, roughly along the walls, or of a round obstacle."""
    if rng.random() < 0.6:
        angle = 0.5 * math.pi * rng.integers(2) + math.radians(rng.uniform(-15.0, 15.0))
        return _box(centre, rng.uniform(1.0, 1.6), rng.uniform(0.6, 0.8), angle)
    return polygon_of_disc([*centre, rng.uniform(0.2, 0.4)])


def _box(centre: Floats, width: float, depth: float, angle: float) -> Floats:
    half = np.array([width, depth]) / 2.0
    return rotate(polygon_of_rect([*(centre - half), *(centre + half)]), angle)


def _desired(rng: np.random.Generator, start: Floats, goal: Floats, block: Floats) -> Floats:
    """Curve (k, 2) of least bending from start to goal on the left of the block.

    It passes beside the block's middle at the rider's preferred distance. The curve of least
    bending through three points is the natural cubic spline.
    """
    abreast = np.array([block[:, 0].min() - rng.uniform(*BESIDE), block[:, 1].mean()])
    knots = np.stack([start, abreast, goal])
    spline = CubicSpline(arc_length(knots), knots, bc_type="natural")
    dense: Floats = spline(np.linspace(0.0, spline.x[-1], 400))
    return resample(dense, RESOLUTION)


def _clearance_along(grid: OccupancyGrid, line: Floats) -> float:
    """Minimum distance of a line (k, 2) from obstacles, m; −∞ where it leaves the map."""
    if not grid.contains(line).all():
        return -math.inf
    return float(distance_field(grid).at(line).min())


TITLE = "Global planners in semi-open offices (Xu et al., Table 2)"

METHODS: Mapping[str, Mapping[str, Any]] = {
    "astar": {"use": "astar"},
    "astar_shortest": {"use": "astar", "cost_weight": 0.0},
    "iterative_astar": {"use": "iterative_astar"},
    "iterative_shortest": {"use": "iterative_astar", "cost_weight": 0.0},
    "upf": {"use": "upf"},
    "upf_rayleigh": {"use": "upf", "preference": {"density": "rayleigh"}},
    "upf_soft": {"use": "upf_soft"},
    "soft_via": {"use": "soft_via"},
}
"""Name in the table → global planner. Those called shortest count the length only, not the distance
to obstacles; the paper does not define the cost of its baselines."""
ROBOT = "quantum_q6_edge"
PREFERRED_SPEED = 1.2
"""The paper's, m/s."""
STEP = 0.05
"""Interval at which two rides are compared, s."""


@dataclass(frozen=True)
class PaperGlobalBench:
    """The benchmark with some methods."""

    methods: tuple[str, ...]
    """Keys of ``METHODS``, or names of global planners."""
    settings: tuple[str, ...] = ()
    """Settings of every ride's scenario, ``dotted.key=value``."""
    TITLE: str = TITLE
    SEEDS: int = 10
    WORKERS: int | None = None

    def tasks(self, seeds: range) -> Sequence[Task]:
        """One per scene."""
        return [(seed,) for seed in seeds]

    def work(self, task: Task, folder: Path) -> Sequence[Result]:
        """Ride the rider's own path through a scene, then each method's."""
        (seed,) = task
        scene = office(seed, load_robot(ROBOT))
        file = _write_scene(scene, folder / "scenes")
        methods = {name: METHODS.get(name, {"use": name}) for name in self.methods}
        own = RiddenMethod(DESIRED, METHODS["astar"], self.settings)
        desired = _ride(file, scene, own, None)
        against = desired.arrays["track"]
        return [
            desired,
            *(
                _ride(file, scene, RiddenMethod(name, spec, self.settings), against)
                for name, spec in methods.items()
            ),
        ]

    def report(self, results: Sequence[Result], folder: Path) -> BenchReport:
        """Table 2 beside the paper's, paired differences, and the pictures of Fig. 12."""
        missing = [name for name in METHODS if name not in known_methods()]
        by_seed: dict[int, list[Result]] = {}
        for each in results:
            by_seed.setdefault(each.row["seed"], []).append(each)
        panels = [_panel(seed, group) for seed, group in sorted(by_seed.items())]
        return global_report(results, panels, folder, missing)


class RiddenMethod(NamedTuple):
    """Method whose path is ridden."""

    method: str
    """Name in the table."""
    spec: Mapping[str, Any]
    """The global planner."""
    settings: Sequence[str] = ()


CHECKED_ON = "hospital"
"""Scenario on which settings are checked before anything is ridden."""
SCENE = dict.fromkeys(("map", "start", "goal", "prefer"), "the scenes")
"""Keys of a scenario that no setting may change."""


def create(
    planners: Annotated[
        str | None,
        names("Global planners, or methods of the table; default: all."),
    ] = None,
    settings: Settings = (),
) -> PaperGlobalBench:
    """Create the benchmark with some methods, comma-separated, or with all.

    Raises:
        ConfigError: if there is no such method or global planner, or if a setting fixes what is
            compared.
    """
    unset(settings, {"global_planner": "--planners", **SCENE})
    known = known_methods()
    chosen = split_names(planners, "--planners") or known
    for name in chosen:
        known_name(name, known, "method or global planner", "--planners")
    for name in chosen if settings else ():
        _check_settings(name, settings)
    return PaperGlobalBench(methods=chosen, settings=tuple(settings))


def _check_settings(method: str, settings: Sequence[str]) -> None:
    """Check that settings exist and do not contradict the name of a method."""
    spec = METHODS.get(method, {"use": method})
    own = {f"global_planner.{key}" for key, _ in _flat(spec)}
    for key in (setting.partition("=")[0].strip() for setting in settings):
        if key in own:
            raise ConfigError(f"is fixed by the method {method}; choose others", key=key)
    try:
        tried = load_scenario(CHECKED_ON, settings, changes={"global_planner": dict(spec)})
    except ConfigError as cause:  # without the file, which the user did not name
        raise ConfigError(cause.problem, key=cause.key) from None
    plugins.build(PARTS["global_planner"][0], tried.global_planner, key="global_planner")


def known_methods() -> tuple[str, ...]:
    """Installed entries of ``METHODS``, and other installed global planners."""
    there = plugins.names("global_planners")
    ours = tuple(name for name, spec in METHODS.items() if spec["use"] in there)
    used = {spec["use"] for spec in METHODS.values()}
    return (*ours, *(name for name in there if name not in used))


def synchronised_error(track: Floats, desired: Floats) -> Floats:
    """Distance between two tracks (k, 3) of (t, x, y) at equal times: (j, 2) of (time s, m).

    Until the longer of both ends; a track that has ended stays at its end.
    """
    times = np.arange(0.0, max(track[-1, 0], desired[-1, 0]) + STEP / 2.0, STEP)
    x, y = (
        np.interp(times, track[:, 0], track[:, i]) - np.interp(times, desired[:, 0], desired[:, i])
        for i in (1, 2)
    )
    return np.column_stack([times, np.hypot(x, y)])


def _panel(seed: int, results: Sequence[Result]) -> RoutePanel:
    scene = office(seed, load_robot(ROBOT))
    return RoutePanel(
        title=f"scene {seed}: {scene.margin:.1f} m shorter on the right",
        grid=scene.grid,
        point=scene.click,
        lines={each.row["method"]: each.arrays["path"] for each in results if each.arrays},
    )


def _ride(
    file: Path,
    scene: OfficeScene,
    ridden: RiddenMethod,
    against: Floats | None,
) -> Result:
    """Ride one method in one scene; ``against`` (k, 3) is the track of the rider's own path."""
    method, spec, settings = ridden
    row: dict[str, Any] = {"seed": scene.seed, "method": method, "outcome": "", "left": False}
    row |= dict.fromkeys(MEASURES, float("nan"))
    row["replay"] = _replay(f"{file.parent.name}/{file.name}", ridden)
    scenario = load_scenario(file, settings, changes={"global_planner": dict(spec)})
    try:
        stage = build_scenario(scenario, scene.seed)
    except PlanningError as failure:
        return Result(row={**row, "outcome": failure.code})
    if method == DESIRED:
        stage = _along(scene.desired, stage)
    ride = Episode(stage).run()
    track = np.column_stack([ride.time, ride.pose[:, :2]])
    error = synchronised_error(track, track if against is None else against)
    row |= _measures(ride, stage.route, scene)
    row["synchronised_error"] = float(error[:, 1].mean())
    arrays = {
        "path": stage.route.points,
        "track": track,
        "error": error,
    }
    return Result(row=row, arrays=arrays)


def _measures(ride: Ride, route: Route, scene: OfficeScene) -> dict[str, Any]:
    nearest, hausdorff = path_error(route.points, scene.desired)
    reached = ride.outcome is Outcome.REACHED
    return {
        "outcome": ride.outcome.value,
        "left": on_the_left(route.points, scene.block),
        "time": time_to_goal(ride) if reached else float("nan"),
        "length": route.length,
        "nearest_error": nearest,
        "hausdorff_error": hausdorff,
        "ridden_error": path_error(ride.pose[:, :2], scene.desired)[0],
        "ridden_length": path_length(ride) if reached else float("nan"),
        "click_distance": nearest_on_polyline(route.points, *scene.click)[1],
        "extra_length": route.wishes.extra_length,
        "wall_distance": float(ride.gap_wall.min()),
    }


def _along(line: Floats, stage: RideSetup) -> RideSetup:
    """Replace the global planner by one that follows a drawn line."""
    drawn = DrawnPath(line)
    problem = RouteProblem(
        grid=stage.grid, robot=stage.robot, start=line[0], goal=stage.request.goal
    )
    navigator = replace(stage.navigator, global_planner=drawn)
    return replace(stage, navigator=navigator, route=drawn.plan(problem))


class DrawnPath:
    """Global planner that follows a given line.

    Args:
        line: (k, 2), m.
    """

    def __init__(self, line: Floats) -> None:
        self.line = line

    def plan(self, problem: RouteProblem) -> Route:
        """Line from its point nearest to the start."""
        along, _ = nearest_on_polyline(self.line, *problem.start)
        rest = self.line[arc_length(self.line) > along + 1e-6]
        points = np.concatenate([problem.start[None], rest if len(rest) else self.line[-1:]])
        length = float(arc_length(points)[-1])
        return Route(
            points=points,
            length=length,
            cost=length,
            method=DESIRED,
            wishes=WishReport(closest=np.empty(0)),
            without_wishes=points,
        )


def _write_scene(scene: OfficeScene, folder: Path) -> Path:
    """Write the scene as a map and a scenario for ``cohelm run``."""
    folder.mkdir(parents=True, exist_ok=True)
    write_map(scene.grid, folder / f"{scene.seed}-map.yaml")
    given = {
        "description": "a semi-open office, and a click that asks to pass on the left",
        "map": f"{scene.seed}-map.yaml",
        "start": [*scene.start.tolist(), 90.0],
        "goal": scene.goal.tolist(),
        "prefer": [scene.click.tolist()],
        "robot": ROBOT,
        "mode": "autonomous",
        "profile": {"preferred_speed": PREFERRED_SPEED},
        "seed": scene.seed,
    }
    file = folder / f"{scene.seed}.yaml"
    file.write_text(yaml.safe_dump(given, sort_keys=False), encoding="utf-8")
    return file


def _replay(file: str, ridden: RiddenMethod) -> str:
    """Command that repeats a ride in the folder of the results; none for a drawn line."""
    method, spec, more = ridden
    if method == DESIRED:
        return ""
    own = [f"global_planner.{key}={each}" for key, each in _flat(spec)]
    settings = "".join(f" --set {shlex.quote(each)}" for each in (*own, *more))
    return f"cohelm run {file} --method {spec['use']}{settings}"


def _flat(spec: Mapping[str, Any], before: str = "") -> Iterator[tuple[str, Any]]:
    """(dotted key, value) of every parameter of a part."""
    for key, each in spec.items():
        if isinstance(each, Mapping):
            yield from _flat(each, f"{before}{key}.")
        elif key != "use":
            yield before + key, each
