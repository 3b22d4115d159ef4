"""Build everything that a ride needs from a scenario: map, chair, pedestrians and parts.

Pedestrians have outlines, also with a wheelchair, a walker or a trolley; the true floor has what
its map lacks, and what only rider or chair sees.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from cohelm import plugins
from cohelm.arrays import Annotated, Floats, Floats32, Integers, Shape, value
from cohelm.errors import MapError, PluginError, ScenarioError
from cohelm.maps import (
    FILTER_TYPES,
    OCCUPIED,
    CostmapFilter,
    FilterInfo,
    OccupancyGrid,
    Places,
    places_beside,
    read_crowding,
    read_filter_info,
    read_map,
    read_mask,
)
from cohelm.messages import Path, Request, Wish
from cohelm.navigation import NavigatorSetup
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.robots import Robot
from cohelm.scenarios.crowd import make_crowd
from cohelm.scenarios.floor import (
    covered_by,
    doorways,
    floor_plan,
    grid_changes,
    relief_of,
    with_heights,
    with_obstacles,
)
from cohelm.scenarios.objects import Mask
from cohelm.scenarios.pedestrian_spec import CrowdSpec
from cohelm.scenarios.rider_plan import goal_change, route_past
from cohelm.scenarios.scenario import (
    NAVIGATOR_PARAMETERS,
    NAVIGATOR_PARTS,
    PARTS,
    Scenario,
    robot_of,
)
from cohelm.simulation import (
    Crowd,
    GoalChange,
    ManualDoor,
    MapChange,
    SplitCells,
    WorldSetup,
    generator,
    prepare_crowd,
    with_cells,
)
from cohelm.simulation.sensors.planar_bodies import RADIUS, SPEEDS, STATURES, BodyKind


class TrueWorld(NamedTuple):
    """Obstacles of a world."""

    grid: OccupancyGrid
    """At time 0."""
    changes: tuple[MapChange, ...]
    """Later ones."""
    heights: Floats32 | None
    """Heights of occupied cells, m; None: wall height everywhere."""
    doors: tuple[ManualDoor, ...]
    """Doors that can be closed."""
    split: SplitCells | None
    """Cells that rider and chair see differently; None: none."""

    @property
    def known_to_rider(self) -> OccupancyGrid:
        """Obstacles at time 0, and floor that the rider avoids."""
        return (
            self.grid if self.split is None else with_cells(self.grid, self.split.avoided, OCCUPIED)
        )


def true_world(
    scenario: Scenario,
    grid: OccupancyGrid,
    heights: Floats32 | None,
    doors: tuple[ManualDoor, ...],
) -> TrueWorld:
    """Build the true obstacles of a scenario.

    Args:
        scenario: with obstacles, doors and changes of the drawing.
        grid: map of the chair.
        heights: heights of its cells, m; None: not known.
        doors: doors of the map.
    """
    if scenario.world_plan:
        plan = floor_plan(scenario, of_world=True)
        grid, heights, doors = plan.draw()[0], plan.heights(), doorways(plan)
    solid = tuple(each for each in scenario.obstacles if each.solid)
    first, *later = grid_changes(with_obstacles(grid, solid), scenario.doors)
    return TrueWorld(
        grid=first.grid,
        changes=tuple(later),
        heights=with_heights(heights, grid, solid),
        doors=doors,
        split=_split(scenario, grid),
    )


def _split(scenario: Scenario, grid: OccupancyGrid) -> SplitCells | None:
    if all(each.sensed and each.solid for each in scenario.obstacles):
        return None
    sensed = tuple(each for each in scenario.obstacles if each.solid and each.sensed)
    unsensed = tuple(each for each in scenario.obstacles if each.solid and not each.sensed)
    floor = tuple(each for each in scenario.obstacles if not each.solid)
    return SplitCells(
        unsensed=covered_by(grid, unsensed) & ~with_obstacles(grid, sensed).occupied(),
        avoided=covered_by(grid, floor),
    )


def draw_kinds(spec: CrowdSpec, count: int, rng: np.random.Generator) -> Integers | None:
    """Outlines (count,), a ``BodyKind`` each: those given, the others drawn; None: all discs."""
    names = {kind.name.lower(): kind for kind in BodyKind}
    given = [each.body for each in spec.pedestrians][:count]
    if not spec.bodies and not any(given):
        return None
    share_of: dict[str, float] = dict(spec.bodies.items())
    shares = [share_of.get(name, 0.0) for name in names]
    shares[BodyKind.DISC] += max(1.0 - sum(shares), 0.0)
    kinds = rng.choice(len(names), size=count, p=np.array(shares) / sum(shares))
    for i, body in enumerate(given):
        if body is not None:
            kinds[i] = names[body]
    return np.asarray(kinds, dtype=np.int64)


def with_bodies(crowd: Crowd, kinds: Integers | None) -> Crowd:
    """Crowd with the sizes and highest speeds of its outlines (n,); seated people stay."""
    if kinds is None:
        return crowd
    radius, speed = crowd.radius.copy(), crowd.preferred_speed.copy()
    waypoints, target = crowd.waypoints.copy(), crowd.target.copy()
    for i, kind in enumerate(map(BodyKind, kinds.tolist())):
        if kind is BodyKind.DISC:
            continue
        radius[i] = RADIUS[kind]
        speed[i] = min(speed[i], SPEEDS.get(kind, speed[i])) or speed[i]
        if kind is BodyKind.SEATED:
            waypoints[i, 1:], target[i] = np.nan, 0
            waypoints[i, 0] = crowd.position[i]
    return replace(crowd, radius=radius, preferred_speed=speed, waypoints=waypoints, target=target)


def statures_of(kinds: Integers | None, statures: Floats) -> Floats:
    """Heights (n,), m: those of lower outlines are scaled from the drawn ones into their range."""
    if kinds is None:
        return statures
    out = statures.copy()
    low, high = statures.min(initial=np.inf), statures.max(initial=-np.inf)
    for i, kind in enumerate(map(BodyKind, kinds.tolist())):
        if kind in STATURES:
            share = (statures[i] - low) / max(high - low, 1e-9)
            out[i] = STATURES[kind][0] + share * (STATURES[kind][1] - STATURES[kind][0])
    return out


class Floor(NamedTuple):
    """Floor of a scenario without the objects that are not on the map."""

    grid: OccupancyGrid
    places: Places
    heights: Floats32 | None
    """Heights of occupied cells, m; None: not known."""
    doors: tuple[ManualDoor, ...]


class _Routes(NamedTuple):
    """Start pose, planned route, the rider's own route (k, 2), m, and its change on the way."""

    start: Floats
    route: Path
    rider: Floats
    change: GoalChange | None


@value
class RideSetup:
    """A scenario with all its parts built; equal for equal seeds."""

    scenario: Scenario
    seed: int
    grid: OccupancyGrid
    """Map of the navigator."""
    places: Places
    """Named places of the map."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    """X_MR."""
    request: Request
    prefer: Annotated[Floats, Shape("w 2")]
    """Via points that attract the route, m."""
    route: Path
    """First route, planned on the map alone."""
    world: WorldSetup
    navigator: NavigatorSetup

    @property
    def arrival(self) -> Floats:
        """Point (2,) at which the ride is over, m: the rider's, where the rider has a plan."""
        has_plan = self.scenario.rider_plan is not None
        return self.world.last_goal if has_plan else self.request.goal


def build_scenario(scenario: Scenario, seed: int) -> RideSetup:
    """Build everything that a ride of this scenario needs.

    Raises:
        ConfigError, MapError, PluginError: if the scenario names something that does not exist.
        PlanningError: if no route leads from the start to the goal, or to the rider's goal.
    """
    robot = robot_of(scenario)
    floor = floor_of(scenario)
    parts = {key: _part(scenario, key) for key in PARTS}
    start = _point(scenario, "start", floor.places)
    request = Request(
        goal=_point(scenario, "goal", floor.places)[:2],
        wishes=_wishes(scenario),
        mode=scenario.mode,
        profile=scenario.profile,
    )
    navigator = _navigator(scenario, floor, robot, parts)
    problem = _problem(navigator, start, request)
    planner = navigator.global_planner
    route = planner.plan(problem)
    if math.isnan(start[2]):
        backwards = math.pi if route.backs_out else 0.0
        start = np.array([*start[:2], _heading(route.points) + backwards])
    world = true_world(scenario, floor.grid, floor.heights, floor.doors)
    routes = _Routes(
        start, route, *_rider_routes(scenario, problem, planner, floor.places, world, route)
    )
    if scenario.rider_plan is not None and not scenario.rider_plan.goal_told:
        request = replace(request, goal=np.full(2, np.nan))
    return RideSetup(
        scenario=scenario,
        seed=seed,
        grid=floor.grid,
        places=floor.places,
        robot=robot,
        start=start,
        request=request,
        prefer=np.array([point for each in scenario.prefer for point in each]).reshape(-1, 2),
        route=route,
        world=_world(scenario, seed, world, robot, routes, parts["rider"]),
        navigator=navigator,
    )


def floor_of(scenario: Scenario) -> Floor:
    """Map, places, heights and doors of a scenario."""
    if scenario.floor is not None:
        plan = floor_plan(scenario)
        return Floor(*plan.draw(), plan.heights(), doorways(plan))
    file = scenario.beside(scenario.map or "")
    return Floor(read_map(file), places_beside(file), None, ())


def _wishes(scenario: Scenario) -> tuple[Wish, ...]:
    """Wishes of the rider: via points, a line to follow, and zones to avoid."""
    attract = [Wish(points=np.array(points)) for points in scenario.prefer]
    stroke = [Wish(kind="stroke", points=np.array(scenario.stroke))] if scenario.stroke else []
    avoid = [
        Wish(kind="avoid", points=np.array(zone.points), radius=zone.radius, hard=zone.hard)
        for zone in scenario.avoid
    ]
    return (*attract, *stroke, *avoid)


def _filters(scenario: Scenario) -> tuple[CostmapFilter, ...]:
    return tuple(
        read_mask(
            scenario.beside(mask.file),
            type=mask.type,
            base=mask.base,
            multiplier=mask.multiplier,
            info=_filter_info(scenario, mask),
        )
        for mask in scenario.filters
    )


def _filter_info(scenario: Scenario, mask: Mask) -> FilterInfo | None:
    if mask.info is None:
        return None
    file = scenario.beside(mask.info)
    types = FILTER_TYPES if mask.type is None else (mask.type,)
    info = read_filter_info(file, types=types)
    if info is None:
        raise MapError(f"describes no mask of type {' or '.join(types)}", file=file)
    return info


def _navigator(
    scenario: Scenario, floor: Floor, robot: Robot, parts: Mapping[str, Any]
) -> NavigatorSetup:
    return NavigatorSetup(
        grid=floor.grid,
        places=floor.places,
        robot=robot,
        filters=_filters(scenario),
        heat=read_crowding(scenario.beside(scenario.crowding)) if scenario.crowding else None,
        **{key: parts[key] for key in NAVIGATOR_PARTS},
        **{key: getattr(scenario, key) for key in NAVIGATOR_PARAMETERS},
    )


def _problem(navigator: NavigatorSetup, start: Floats, request: Request) -> RouteProblem:
    """Route problem from the start to the goal, before any observation."""
    return RouteProblem(
        grid=navigator.grid,
        robot=navigator.robot,
        start=start[:2],
        start_heading=float(start[2]),
        goal=request.goal,
        wishes=request.wishes,
        filters=navigator.filters,
        crowding=navigator.heat,
        clearance=request.profile.clearance,
    )


def _part(scenario: Scenario, key: str) -> Any:
    group, _ = PARTS[key]
    return _built(scenario, group, getattr(scenario, key), key)


def _built(scenario: Scenario, group: str, spec: dict[str, Any], key: str) -> Any:
    try:
        return plugins.build(group, spec, file=scenario.file, key=key, error=ScenarioError)
    except PluginError as cause:
        raise ScenarioError(str(cause), file=scenario.file, key=key) from cause


def _point(scenario: Scenario, key: str, places: Places) -> Floats:
    """(x, y, heading) of ``start`` or ``goal``; the heading is NaN where none is given."""
    pose = getattr(scenario, key)
    if isinstance(pose, str):
        try:
            return np.array([*places.find(pose).point, np.nan])
        except MapError as cause:
            raise ScenarioError(cause.problem, file=scenario.file, key=key) from None
    if len(pose) == 3:
        return np.array([pose[0], pose[1], math.radians(pose[2])])
    return np.array([*pose, np.nan])


def _heading(points: Floats) -> float:
    """Direction of the first half metre of a polyline (k, 2), rad."""
    away = np.hypot(*(points - points[0]).T)
    ahead = points[int(np.argmax(away > 0.5))] if (away > 0.5).any() else points[-1]
    return math.atan2(ahead[1] - points[0, 1], ahead[0] - points[0, 0])


def _rider_routes(
    scenario: Scenario,
    problem: RouteProblem,
    planner: GlobalPlanner,
    places: Places,
    world: TrueWorld,
    route: Path,
) -> tuple[Floats, GoalChange | None]:
    """Route (k, 2) from the start to the rider's goal, m, and its change on the way."""
    plan, known = scenario.rider_plan, world.known_to_rider
    change = None
    if plan is not None:
        change = goal_change(plan, problem, known, lambda given: planner.plan(given).points)
    if scenario.rider_goal is None and not scenario.rider_route and plan is None:
        return route.points, None
    goal = problem.goal
    if scenario.rider_goal is not None:
        goal = _point(scenario, "rider_goal", places)[:2]
    if scenario.rider_route:
        return np.vstack([problem.start, np.array(scenario.rider_route), goal]), change
    wanted = replace(problem, goal=goal, wishes=())
    if plan is None:
        return planner.plan(wanted).points, None
    return route_past(plan, wanted, known, lambda given: planner.plan(given).points), change


def _pedestrian_model(scenario: Scenario) -> Any:
    """Pedestrian model; a recording that it names is looked for beside the scenario first."""
    spec = scenario.people.model
    file = scenario.beside(str(spec.get("file", "")))
    spec = {**spec, "file": str(file)} if file.is_file() else spec
    return _built(scenario, "pedestrian_models", spec, "people.model")


def _world(
    scenario: Scenario,
    seed: int,
    world: TrueWorld,
    robot: Robot,
    routes: _Routes,
    rider: Any,
) -> WorldSetup:
    """True world of the ride."""
    model = _pedestrian_model(scenario)
    crowd = make_crowd(scenario.people, world.grid, routes.route.points, generator(seed, "crowd"))
    if scenario.people.count != 0:
        crowd = prepare_crowd(model, crowd)
    kinds = draw_kinds(scenario.people, len(crowd.radius), generator(seed, "bodies"))
    crowd, storey = with_bodies(crowd, kinds), scenario.storey
    statures = generator(seed, "statures").uniform(*scenario.people.stature, len(crowd.radius))
    return WorldSetup(
        grid=world.grid,
        changes=world.changes,
        heights=world.heights,
        wall_height=storey.wall_height,
        ceiling=storey.wall_height if storey.ceiling else math.inf,
        relief=relief_of(storey),
        robot=robot,
        start=routes.start,
        crowd=crowd,
        statures=statures_of(kinds, statures),
        kinds=kinds,
        pedestrian_model=model,
        rider=rider,
        rider_goal=routes.rider[-1],
        rider_route=routes.rider,
        goal_change=routes.change,
        split=world.split,
        localisation=scenario.localisation,
        odometry=scenario.odometry,
        give_people=scenario.tracker["use"] == "given",
        faults=scenario.faults,
        doors=world.doors,
    )
