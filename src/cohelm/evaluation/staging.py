"""From a scenario to everything a ride needs: the map, the chair, the people, the parts."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.errors import MapError, PluginError, ScenarioError
from cohelm.evaluation.people import make_crowd
from cohelm.evaluation.scenario import PARTS, Obstacle, Scenario, floor_file, robot_of
from cohelm.maps import OCCUPIED, OccupancyGrid, Places, places_beside, read_floor_plan, read_map
from cohelm.messages import Path, Request, Wish
from cohelm.navigation import NavigatorSetup
from cohelm.planning import RouteProblem
from cohelm.robots import Robot
from cohelm.simulation import WorldSetup, generator


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
        PlanningError: if no way leads from start to goal.
    """
    robot = robot_of(scenario)
    grid, places = _floor(scenario)
    parts = {key: _part(scenario, key) for key in PARTS}
    start = _point(scenario, "start", places)
    goal = _point(scenario, "goal", places)[:2]
    prefer = np.array(scenario.prefer, dtype=float).reshape(-1, 2)
    request = Request(
        goal=goal,
        wishes=tuple(Wish(points=point[None]) for point in prefer),
        mode=scenario.mode,
        profile=scenario.profile,
    )
    problem = RouteProblem(
        grid=grid,
        robot=robot,
        start=start[:2],
        goal=goal,
        wishes=request.wishes,
        clearance=scenario.profile.clearance,
    )
    route: Path = parts["global_planner"].plan(problem)
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
        prefer=prefer,
        route=route,
        world=_world(scenario, seed, grid, robot, (start, route), parts["rider"]),
        navigator=NavigatorSetup(
            grid=grid,
            robot=robot,
            **{key: parts[key] for key in PARTS if key != "rider"},
            obstacle_layer=scenario.obstacle_layer,
            authority=scenario.authority,
            replanning=scenario.replanning,
            progress=scenario.progress,
            gate=scenario.gate,
        ),
    )


def with_obstacles(grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]) -> OccupancyGrid:
    """The grid with things put on it: every cell whose centre one covers."""
    if not obstacles:
        return grid
    rows, cols = np.indices(grid.shape)
    centres = grid.centres(np.stack([rows, cols], axis=-1))
    data = grid.data.copy()
    for each in obstacles:
        delta = centres - np.array(each.at)
        if each.radius is not None:
            covered = np.hypot(delta[..., 0], delta[..., 1]) <= each.radius
        else:
            angle = math.radians(each.angle_deg)
            along = math.cos(angle) * delta[..., 0] + math.sin(angle) * delta[..., 1]
            aside = math.cos(angle) * delta[..., 1] - math.sin(angle) * delta[..., 0]
            half = np.array(each.size, dtype=float) / 2.0
            covered = (np.abs(along) <= half[0]) & (np.abs(aside) <= half[1])
        data[covered] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def _floor(scenario: Scenario) -> tuple[OccupancyGrid, Places]:
    if scenario.floor is not None:
        return read_floor_plan(floor_file(scenario.floor)).draw()
    file = scenario.beside(scenario.map or "")
    return read_map(file), places_beside(file)


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


def _world(
    scenario: Scenario,
    seed: int,
    grid: OccupancyGrid,
    robot: Robot,
    way: tuple[Floats, Path],
    rider: Any,
) -> WorldSetup:
    """The true world, ``way`` being the start pose and the route."""
    start, route = way
    truth = with_obstacles(grid, scenario.obstacles)
    return WorldSetup(
        grid=truth,
        robot=robot,
        start=start,
        crowd=make_crowd(scenario.people, truth, route.points, generator(seed, "crowd")),
        pedestrian_model=_built(
            scenario, "pedestrian_models", scenario.people.model, "people.model"
        ),
        rider=rider,
        rider_goal=route.points[-1],
        rider_route=route.points,
        localisation=scenario.localisation,
        odometry=scenario.odometry,
        give_people=scenario.tracker["use"] == "given",
        faults=scenario.faults,
    )
