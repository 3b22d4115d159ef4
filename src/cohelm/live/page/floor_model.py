"""Floor as a page shows it: map image, places, doors and chair."""

from __future__ import annotations

from dataclasses import dataclass

from cohelm.live.messages import ChairInfo, DoorInfo, PlaceInfo, SceneInfo
from cohelm.live.page.floor_solids import FloorSolids, floor_solids
from cohelm.live.sessions.map_image import map_image
from cohelm.maps import NamedPlace, OccupancyGrid, Places
from cohelm.messages import Mode
from cohelm.platforms import is_simulated
from cohelm.robots import Robot
from cohelm.scenarios import Scenario
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.scenario import robot_of

MODES = (Mode.SHARED, Mode.AUTONOMOUS, Mode.ASSISTED, Mode.STOP_ONLY, Mode.MANUAL)
"""Modes in the order in which a page offers them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorModel:
    """Scene of a scenario with its map image, and the values that it was made from."""

    scene: SceneInfo
    png: bytes
    grid: OccupancyGrid
    places: Places
    robot: Robot
    solids: FloorSolids


def floor_model(scenario: Scenario, seed: int) -> FloorModel:
    """Return the floor of a scenario, without planning anything.

    Raises:
        CohelmError: The scenario refers to something that does not exist.
    """
    grid, places, _, doors = floor_of(scenario)
    robot, simulation = robot_of(scenario), is_simulated(scenario)
    floor, png = map_image(grid)
    scene = SceneInfo(
        name=scenario.name,
        description=scenario.description,
        simulation=simulation,
        seed=seed,
        floor=floor,
        places=tuple(_place(each) for each in places),
        doors=tuple(
            DoorInfo(id=k, a=tuple(door.a.tolist()), b=tuple(door.b.tolist()))
            for k, door in enumerate(doors if simulation else ())
        ),
        chair=ChairInfo(
            name=robot.name,
            outline=tuple((float(x), float(y)) for x, y in robot.outline),
            max_speed=robot.max_speed,
            max_acceleration=robot.max_acceleration,
            max_turn_rate=robot.max_turn_rate,
        ),
        modes=MODES,
    )
    return FloorModel(
        scene=scene,
        png=png,
        grid=grid,
        places=places,
        robot=robot,
        solids=floor_solids(scenario),
    )


def _place(place: NamedPlace) -> PlaceInfo:
    corners = () if place.polygon is None else place.polygon.round(3).tolist()
    return PlaceInfo(
        name=place.name,
        x=float(place.point[0]),
        y=float(place.point[1]),
        area=tuple((x, y) for x, y in corners),
        names=dict(place.names),
    )
