"""Pictures of scenarios before anybody has moved."""

from __future__ import annotations

from pathlib import Path

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.evaluation.furnishing import with_obstacles
from cohelm.evaluation.staging import Stage
from cohelm.maps import OccupancyGrid
from cohelm.messages import Path as Route
from cohelm.messages import Wish
from cohelm.robots import Robot
from cohelm.simulation import Crowd


@value
class Scene:
    """What a picture of a scene shows; a ``pictures.SceneRecord``."""

    grid: OccupancyGrid
    world: OccupancyGrid
    """With everything that is not on the map, and every door that ever closes closed."""
    robot: Robot
    start: Annotated[Floats, Shape("3")]
    route: Route
    wishes: tuple[Wish, ...]
    crowd: Crowd


def scene_of(stage: Stage) -> Scene:
    """The scene as it is staged."""
    scenario = stage.scenario
    doors = tuple(door.leaf for door in scenario.doors)
    return Scene(
        grid=stage.grid,
        world=with_obstacles(stage.grid, (*scenario.obstacles, *doors)),
        robot=stage.robot,
        start=stage.start,
        route=stage.route,
        wishes=tuple(stage.request.wishes),
        crowd=stage.world.crowd,
    )


def draw_stage(stage: Stage, file: Path) -> None:
    """Write the picture of a scene that is staged.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    from cohelm.pictures import draw_scene  # noqa: PLC0415 # lazy

    draw_scene(scene_of(stage), file, stage.scenario.name)
