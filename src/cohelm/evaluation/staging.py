"""From a scenario to everything a ride needs: the map, the chair, the people, the parts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Annotated, Floats, Floats32, Shape, value
from cohelm.errors import MapError, PluginError, ScenarioError
from cohelm.evaluation.building import doorways, floor_plan
from cohelm.evaluation.furnishing import changes, with_heights, with_obstacles
from cohelm.evaluation.laying import laid
from cohelm.evaluation.people import make_crowd
from cohelm.evaluation.scenario import (
    NAVIGATOR_PARAMETERS,
    NAVIGATOR_PARTS,
    PARTS,
    Scenario,
    robot_of,
)
from cohelm.maps import (
    CostmapFilter,
    OccupancyGrid,
    Places,
    places_beside,
    read_crowding,
    read_map,
    read_mask,
)
from cohelm.messages import Path, Request, Wish
from cohelm.navigation import NavigatorSetup
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.robots import Robot
from cohelm.simulation import Doorway, WorldSetup, entered, generator


@value
class Stage:
    """A scenario with everything looked up, drawn and built; the same for the same seed."""

    scenario: Scenario
    seed: int
    grid: OccupancyGrid
    """The map as the navigator has it."""
    places: Places
    """Named on it."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    """X_MR."""
    request: Request
    prefer: Annotated[Floats, Shape("w 2")]
    """The points that should attract the route."""
    route: Path
    """Planned from the start on the map alone."""
    world: WorldSetup
    navigator: NavigatorSetup


def set_stage(scenario: Scenario, seed: int) -> Stage:
    """Everything that a ride of this scenario needs.

    Raises:
        ConfigError, MapError, PluginError: if the scenario names what there is not.
        PlanningError: if no way leads from start to goal, or to the rider's own.
    """
    scenario = laid(scenario, set_stage)
    robot = robot_of(scenario)
    grid, places, heights, doors = floor_of(scenario)
    parts = {key: _part(scenario, key) for key in PARTS}
    start = _point(scenario, "start", places)
    request = Request(
        goal=_point(scenario, "goal", places)[:2],
        wishes=_wishes(scenario),
        mode=scenario.mode,
        profile=scenario.profile,
    )
    navigator = _navigator(scenario, grid, robot, parts)
    problem = _problem(navigator, start, request)
    planner = navigator.global_planner
    route = planner.plan(problem)
    if math.isnan(start[2]):
        start = np.array([*start[:2], _heading(route.points)])
    return Stage(
        scenario=scenario,
        seed=seed,
        grid=grid,
        places=places,
        robot=robot,
        start=start,
        request=request,
        prefer=np.array([point for each in scenario.prefer for point in each]).reshape(-1, 2),
        route=route,
        world=_world(
            scenario,
            seed,
            (grid, heights, doors),
            robot,
            (start, route, _wanted_way(scenario, problem, planner, places, route)),
            parts["rider"],
        ),
        navigator=navigator,
    )


def floor_of(
    scenario: Scenario,
) -> tuple[OccupancyGrid, Places, Floats32 | None, tuple[Doorway, ...]]:
    """The map, its places, how high what stands there is (None: nobody knows), and its doors."""
    if scenario.floor is not None:
        plan = floor_plan(scenario)
        return *plan.draw(), plan.heights(), doorways(plan)
    file = scenario.beside(scenario.map or "")
    return read_map(file), places_beside(file), None, ()


def _wishes(scenario: Scenario) -> tuple[Wish, ...]:
    """What the rider wants of the route: points, a line, and where not to go."""
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
        )
        for mask in scenario.filters
    )


def _navigator(
    scenario: Scenario, grid: OccupancyGrid, robot: Robot, parts: Mapping[str, Any]
) -> NavigatorSetup:
    return NavigatorSetup(
        grid=grid,
        robot=robot,
        filters=_filters(scenario),
        heat=read_crowding(scenario.beside(scenario.crowding)) if scenario.crowding else None,
        **{key: parts[key] for key in NAVIGATOR_PARTS},
        **{key: getattr(scenario, key) for key in NAVIGATOR_PARAMETERS},
    )


def _problem(navigator: NavigatorSetup, start: Floats, request: Request) -> RouteProblem:
    """The way from the start to the goal, as it is known before anything is seen."""
    return RouteProblem(
        grid=navigator.grid,
        robot=navigator.robot,
        start=start[:2],
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
    spot = getattr(scenario, key)
    if isinstance(spot, str):
        try:
            return np.array([*places.find(spot).point, np.nan])
        except MapError as cause:
            raise ScenarioError(cause.problem, file=scenario.file, key=key) from None
    if len(spot) == 3:
        return np.array([spot[0], spot[1], math.radians(spot[2])])
    return np.array([*spot, np.nan])


def _heading(points: Floats) -> float:
    """The direction in which a polyline (k, 2) sets out, over its first half metre, rad."""
    away = np.hypot(*(points - points[0]).T)
    ahead = points[int(np.argmax(away > 0.5))] if (away > 0.5).any() else points[-1]
    return math.atan2(ahead[1] - points[0, 1], ahead[0] - points[0, 0])


def _wanted_way(
    scenario: Scenario,
    problem: RouteProblem,
    planner: GlobalPlanner,
    places: Places,
    route: Path,
) -> Floats:
    """The rider's own way (k, 2) from the start to where they want to go, m."""
    if scenario.rider_goal is None and not scenario.rider_route:
        return route.points
    goal = problem.goal
    if scenario.rider_goal is not None:
        goal = _point(scenario, "rider_goal", places)[:2]
    if scenario.rider_route:
        return np.vstack([problem.start, np.array(scenario.rider_route), goal])
    return planner.plan(replace(problem, goal=goal, wishes=())).points


def _walkers(scenario: Scenario) -> dict[str, Any]:
    """The pedestrian model; a film that it names is looked for beside the scenario first."""
    spec = scenario.people.model
    film = scenario.beside(str(spec.get("file", "")))
    return {**spec, "file": str(film)} if film.is_file() else spec


def _world(
    scenario: Scenario,
    seed: int,
    floor: tuple[OccupancyGrid, Floats32 | None, tuple[Doorway, ...]],
    robot: Robot,
    way: tuple[Floats, Path, Floats],
    rider: Any,
) -> WorldSetup:
    """The true world; ``floor``: map, heights, doors; ``way``: start pose, route, the rider's."""
    (grid, heights, doors), (start, route, wanted) = floor, way
    open_ = with_obstacles(grid, scenario.obstacles)
    first, *later = changes(open_, scenario.doors)
    truth = first.grid
    walkers = _built(scenario, "pedestrian_models", _walkers(scenario), "people.model")
    crowd = make_crowd(scenario.people, truth, route.points, generator(seed, "crowd"))
    if scenario.people.count != 0:
        crowd = entered(walkers, crowd)
    storey, stature = scenario.storey, scenario.people.stature
    return WorldSetup(
        grid=truth,
        changes=tuple(later),
        heights=with_heights(heights, grid, scenario.obstacles),
        wall_height=storey.wall_height,
        ceiling=storey.wall_height if storey.ceiling else math.inf,
        robot=robot,
        start=start,
        crowd=crowd,
        statures=generator(seed, "statures").uniform(*stature, size=len(crowd.radius)),
        pedestrian_model=walkers,
        rider=rider,
        rider_goal=wanted[-1],
        rider_route=wanted,
        localisation=scenario.localisation,
        odometry=scenario.odometry,
        give_people=scenario.tracker["use"] == "given",
        faults=scenario.faults,
        doors=doors,
    )
