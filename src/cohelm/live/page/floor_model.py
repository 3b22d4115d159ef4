"""Floor as a page shows it: map image, places, doors and chair."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from PIL import Image

from cohelm.arrays import Bytes
from cohelm.live.messages import ChairInfo, DoorInfo, FloorInfo, PlaceInfo, SceneInfo
from cohelm.maps import OccupancyGrid, Places
from cohelm.messages import Mode
from cohelm.platforms import is_simulated
from cohelm.robots import Robot
from cohelm.scenarios import Scenario
from cohelm.scenarios.build import floor_of
from cohelm.scenarios.scenario import robot_of

MODES = (Mode.SHARED, Mode.AUTONOMOUS, Mode.ASSISTED, Mode.STOP_ONLY, Mode.MANUAL)
"""Modes in the order in which a page offers them."""
_OCCUPIED, _UNKNOWN, _FREE = 0, 128, 255


@dataclass(frozen=True, slots=True, kw_only=True)
class FloorModel:
    """Scene of a scenario with its map image, and the values that it was made from."""

    scene: SceneInfo
    png: bytes
    grid: OccupancyGrid
    places: Places
    robot: Robot


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
        places=tuple(
            PlaceInfo(name=place.name, x=float(place.point[0]), y=float(place.point[1]))
            for place in places
        ),
        doors=tuple(
            DoorInfo(id=k, a=tuple(door.a.tolist()), b=tuple(door.b.tolist()))
            for k, door in enumerate(doors if simulation else ())
        ),
        chair=ChairInfo(
            name=robot.name,
            outline=tuple((float(x), float(y)) for x, y in robot.outline),
            max_speed=robot.max_speed,
            max_turn_rate=robot.max_turn_rate,
        ),
        modes=MODES,
    )
    return FloorModel(scene=scene, png=png, grid=grid, places=places, robot=robot)


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
