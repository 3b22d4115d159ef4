"""Pictures of scenarios at their start."""

from __future__ import annotations

from pathlib import Path

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.maps import OccupancyGrid
from cohelm.messages import Path as Route
from cohelm.messages import Wish
from cohelm.robots import Robot
from cohelm.scenarios.build import RideSetup
from cohelm.scenarios.floor import with_obstacles
from cohelm.simulation import Crowd, FloorRelief


@value
class ScenarioPicture:
    """Content of a scenario's picture; a ``cohelm.plotting`` scene record."""

    grid: OccupancyGrid
    world: OccupancyGrid
    """Grid with all obstacles that are not on the map, and all scheduled doors closed."""
    relief: FloorRelief
    """Heights of the floor."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    route: Route
    rider_routes: tuple[Floats, ...]
    """Routes (k, 2) of a rider's plan, which the chair does not know."""
    wishes: tuple[Wish, ...]
    crowd: Crowd


def picture_of(setup: RideSetup) -> ScenarioPicture:
    """Content of the picture of a ride's start."""
    scenario = setup.scenario
    doors = tuple(door.leaf for door in scenario.doors)
    return ScenarioPicture(
        grid=setup.grid,
        world=with_obstacles(setup.world.grid, (*scenario.obstacles, *doors)),
        relief=setup.world.relief,
        robot=setup.robot,
        start=setup.start,
        route=setup.route,
        rider_routes=_rider_routes(setup),
        wishes=tuple(setup.request.wishes),
        crowd=setup.world.crowd,
    )


def _rider_routes(setup: RideSetup) -> tuple[Floats, ...]:
    if setup.scenario.rider_plan is None:
        return ()
    change = setup.world.goal_change
    return (setup.world.rider_route, *((change.route,) if change is not None else ()))


def draw_scenario(setup: RideSetup, file: Path) -> None:
    """Write the picture of a ride's start.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    from cohelm.plotting import draw_scene  # noqa: PLC0415 # matplotlib loads for a second

    draw_scene(picture_of(setup), file, setup.scenario.name)
