"""What a page is told of the scene before anything moves: map, places, doors, chair."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from io import BytesIO

import numpy as np
from PIL import Image

from cohelm.arrays import Bytes
from cohelm.driving.messages import Chair, Doorway, Floor, Place, Scene
from cohelm.evaluation import Scenario
from cohelm.evaluation.scenario import robot_of
from cohelm.evaluation.staging import floor_of
from cohelm.maps import OccupancyGrid, Places
from cohelm.messages import Mode
from cohelm.robots import Robot

OFFERED = (Mode.SHARED, Mode.AUTONOMOUS, Mode.ASSISTED, Mode.MANUAL)
"""Modes, the best one first."""
_OCCUPIED, _UNKNOWN, _FREE = 0, 128, 255


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenery:
    """A scene, and what it was made of."""

    scene: Scene
    png: bytes
    places: Places
    robot: Robot


def scenery_of(scenario: Scenario, seed: int) -> Scenery:
    """The scene of a scenario, quickly: nothing is planned or compiled for it.

    Raises:
        CohelmError: if the scenario names what there is not.
    """
    grid, places, _, doors = floor_of(scenario)
    robot = robot_of(scenario)
    floor, png = drawn(grid)
    scene = Scene(
        name=scenario.name,
        description=scenario.description,
        simulation=True,
        seed=seed,
        floor=floor,
        places=tuple(
            Place(name=each.name, x=float(each.point[0]), y=float(each.point[1])) for each in places
        ),
        doors=tuple(
            Doorway(id=k, a=tuple(door.a.tolist()), b=tuple(door.b.tolist()))
            for k, door in enumerate(doors)
        ),
        chair=Chair(
            name=robot.name,
            outline=tuple((float(x), float(y)) for x, y in robot.outline),
            max_speed=robot.max_speed,
            max_turn_rate=robot.max_turn_rate,
        ),
        modes=OFFERED,
    )
    return Scenery(scene=scene, png=png, places=places, robot=robot)


def drawn(grid: OccupancyGrid) -> tuple[Floor, bytes]:
    """A grid as a grey PNG, its first row at the top, and where that lies; never turned."""
    corner = grid.bounds[:2]
    shade = _shades(grid)
    if grid.X_MG[2] != 0.0:
        shade = _upright(grid, shade)
    rows, cols = shade.shape
    out = BytesIO()
    Image.fromarray(shade[::-1]).save(out, format="PNG", optimize=True)
    png = out.getvalue()
    digest = hashlib.sha256(png).hexdigest()[:16]
    floor = Floor(
        image=f"/api/floor/{digest}.png",
        width=cols,
        height=rows,
        resolution=grid.resolution,
        x=corner[0],
        y=corner[1],
    )
    return floor, png


def _shades(grid: OccupancyGrid) -> Bytes:
    shade = np.full(grid.shape, _FREE, dtype=np.uint8)
    shade[grid.data < 0] = _UNKNOWN
    shade[grid.occupied()] = _OCCUPIED
    return shade


def _upright(grid: OccupancyGrid, shade: Bytes) -> Bytes:
    """The picture of a grid that is turned in the map, along the map's axes."""
    x0, y0, x1, y1 = grid.bounds
    size = grid.resolution
    xs = np.arange(x0 + size / 2.0, x1, size)
    ys = np.arange(y0 + size / 2.0, y1, size)
    points = np.stack(np.meshgrid(xs, ys), axis=-1)
    cells, inside = grid.cells(points), grid.contains(points)
    out = np.full(inside.shape, _UNKNOWN, dtype=np.uint8)
    out[inside] = shade[cells[inside][:, 0], cells[inside][:, 1]]
    return out
