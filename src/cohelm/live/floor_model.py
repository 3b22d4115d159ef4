"""Floor as a page shows it: map image, places, doors and chair; heights of what stands on it."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from io import BytesIO
from typing import Any

import numpy as np
from PIL import Image

from cohelm.arrays import Bytes, Floats
from cohelm.config import validate
from cohelm.errors import CohelmError, ScenarioError
from cohelm.live.messages import ChairInfo, DoorInfo, FloorInfo, PlaceInfo, SceneInfo, StoreyInfo
from cohelm.live.messages.message import WireMessage
from cohelm.maps import NamedPlace, OccupancyGrid, Places
from cohelm.maps.drawing import polygon_of_disc, polygon_of_rect, rotate
from cohelm.messages import Mode
from cohelm.platforms import is_simulated
from cohelm.robots import Robot
from cohelm.scenarios import Scenario
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.floor import floor_plan
from cohelm.scenarios.objects import Obstacle
from cohelm.scenarios.scenario import robot_of
from cohelm.simulation.dynamic_objects import ManualDoor

MODES = (Mode.SHARED, Mode.AUTONOMOUS, Mode.ASSISTED, Mode.STOP_ONLY, Mode.MANUAL)
"""Modes in the order in which a page offers them."""
_OCCUPIED, _UNKNOWN, _FREE = 0, 128, 255


class SolidShape(WireMessage):
    """Upright prism on the floor."""

    outline: tuple[tuple[float, float], ...]
    """Corners in the map frame, m."""
    height: float
    """m."""
    on_map: bool = True
    """False: an obstacle of the simulated world that the map does not have."""
    glass: bool = False
    """True if no sensor sees it."""


class FloorSolids(WireMessage):
    """Storey of a floor and the objects that are not as high as its walls, or not on its map."""

    wall_height: float
    """m."""
    ceiling: bool
    solids: tuple[SolidShape, ...]
    wet: tuple[tuple[tuple[float, float], ...], ...]
    """Outlines of floor that the rider avoids, m."""


class RecordedFloor(FloorInfo):
    """Floor of a ride to look back at; its image is a data URL."""

    places: tuple[PlaceInfo, ...] = ()
    doors: tuple[DoorInfo, ...] = ()
    solids: FloorSolids | None = None
    """None: walls are all that is known."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveStorey:
    """Storey of a building in which a chair drives."""

    name: str
    grid: OccupancyGrid
    places: tuple[str, ...]
    """Names of its places."""
    lifts: Mapping[str, tuple[str, ...]]
    """Storeys to which the lift at a place leads, by the place's name."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorModel:
    """Scene of a scenario with its map image, and the values that it was made from."""

    scene: SceneInfo
    png: bytes
    grid: OccupancyGrid
    places: Places
    robot: Robot
    solids: FloorSolids
    storeys: tuple[DriveStorey, ...] = ()
    """All storeys of the building; none: the map is no storey of one."""


def floor_model(
    scenario: Scenario, seed: int, storey: str = "", storeys: tuple[DriveStorey, ...] = ()
) -> FloorModel:
    """Return the floor of a scenario, without planning anything.

    Args:
        scenario: Floor and chair.
        seed: Random seed of the world.
        storey: Name of the storey on whose map the chair drives; empty: it is no storey.
        storeys: All storeys of the building.

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
        doors=_doors(doors) if simulation else (),
        chair=ChairInfo(
            name=robot.name,
            outline=tuple((float(x), float(y)) for x, y in robot.outline),
            max_speed=robot.max_speed,
            max_acceleration=robot.max_acceleration,
            max_turn_rate=robot.max_turn_rate,
            sees_floor=robot.sees_floor,
        ),
        modes=MODES,
        storey=storey,
        storeys=_storeys(storey, storeys),
    )
    return FloorModel(
        scene=scene,
        png=png,
        grid=grid,
        places=places,
        robot=robot,
        solids=floor_solids(scenario),
        storeys=storeys,
    )


def _storeys(here: str, storeys: Sequence[DriveStorey]) -> tuple[StoreyInfo, ...]:
    """Storeys with the places of the storey ``here`` at which one takes a lift to them."""
    lifts = {place: to for each in storeys if each.name == here for place, to in each.lifts.items()}
    return tuple(
        StoreyInfo(
            name=each.name,
            places=each.places,
            lifts=tuple(place for place, to in lifts.items() if each.name in to),
        )
        for each in storeys
    )


def recorded_floor(scenario: Scenario | Mapping[str, Any], grid: OccupancyGrid) -> RecordedFloor:
    """Return the floor of a ride on the map that it was driven with.

    Where the scenario's own floor is not on this machine, there are walls without names.

    Args:
        scenario: Scenario of the ride, or its content as in a YAML file.
        grid: Map of its navigator.
    """
    floor, png = map_image(grid)
    image = f"data:image/png;base64,{base64.b64encode(png).decode()}"
    told = RecordedFloor(**floor.model_dump(exclude={"image"}), image=image)
    try:
        if not isinstance(scenario, Scenario):
            scenario = validate(Scenario, scenario, error=ScenarioError)
        _, places, _, doors = floor_of(scenario)
        solids = floor_solids(scenario)
    except CohelmError:
        return told
    shown = tuple(_place(each) for each in places)
    return told.model_copy(update={"places": shown, "doors": _doors(doors), "solids": solids})


def _doors(doors: Sequence[ManualDoor]) -> tuple[DoorInfo, ...]:
    return tuple(
        DoorInfo(id=k, a=tuple(door.a.tolist()), b=tuple(door.b.tolist()))
        for k, door in enumerate(doors)
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


def floor_solids(scenario: Scenario) -> FloorSolids:
    """Return the solids of a scenario; obstacles off the map in simulation only.

    Furniture without a height is as high as the walls: the map image has it.

    Raises:
        ScenarioError: The floor does not exist.
    """
    wall = scenario.storey.wall_height
    off_map = scenario.obstacles if is_simulated(scenario) else ()
    obstacles = [
        SolidShape(
            outline=_points(_outline(each)),
            height=wall if each.height is None else each.height,
            on_map=False,
            glass=not each.sensed,
        )
        for each in off_map
        if each.solid
    ]
    return FloorSolids(
        wall_height=wall,
        ceiling=scenario.storey.ceiling,
        solids=(*_furniture(scenario), *obstacles),
        wet=tuple(_points(_outline(each)) for each in off_map if not each.solid),
    )


def _furniture(scenario: Scenario) -> tuple[SolidShape, ...]:
    if scenario.floor is None:
        return ()
    return tuple(
        SolidShape(outline=_points(corners), height=piece.height)
        for piece in floor_plan(scenario).furniture
        if piece.height is not None
        for corners in piece.outlines
    )


def _outline(obstacle: Obstacle) -> Floats:
    """Corners (k, 2) in the map frame, m."""
    x, y = obstacle.at
    if obstacle.radius is not None:
        return polygon_of_disc((x, y, obstacle.radius))
    width, depth = np.array(obstacle.size, dtype=float) / 2.0
    corners = polygon_of_rect((x - width, y - depth, x + width, y + depth))
    return rotate(corners, np.deg2rad(obstacle.angle_deg))


def map_image(grid: OccupancyGrid) -> tuple[FloorInfo, bytes]:
    """Return a grid as a grey PNG along the map's axes, first row at the top, and its position."""
    corner = grid.bounds[:2]
    grey = _grey(grid)
    if grid.X_MG[2] != 0.0:
        grey = _aligned(grid, grey)
    rows, cols = grey.shape
    out = BytesIO()
    Image.fromarray(grey[::-1]).save(out, format="PNG", optimize=True)
    png = out.getvalue()
    digest = hashlib.sha256(png).hexdigest()[:16]
    floor = FloorInfo(
        image=f"/api/floor/{digest}.png",
        width=cols,
        height=rows,
        resolution=grid.resolution,
        x=corner[0],
        y=corner[1],
    )
    return floor, png


def _grey(grid: OccupancyGrid) -> Bytes:
    grey = np.full(grid.shape, _FREE, dtype=np.uint8)
    grey[grid.data < 0] = _UNKNOWN
    grey[grid.occupied()] = _OCCUPIED
    return grey


def _aligned(grid: OccupancyGrid, grey: Bytes) -> Bytes:
    """Resample the image of a rotated grid along the map's axes."""
    x0, y0, x1, y1 = grid.bounds
    size = grid.resolution
    xs = np.arange(x0 + size / 2.0, x1, size)
    ys = np.arange(y0 + size / 2.0, y1, size)
    points = np.stack(np.meshgrid(xs, ys), axis=-1)
    cells, inside = grid.cells(points), grid.contains(points)
    out = np.full(inside.shape, _UNKNOWN, dtype=np.uint8)
    out[inside] = grey[cells[inside][:, 0], cells[inside][:, 1]]
    return out


def _points(corners: Floats) -> tuple[tuple[float, float], ...]:
    """Corners (k, 2) to the millimetre, m."""
    return tuple((round(float(x), 3), round(float(y), 3)) for x, y in corners)
