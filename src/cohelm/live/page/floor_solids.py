"""Heights of what stands on the floor, for 3-D views; the walls are in the map image."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.live.messages.message import WireMessage
from cohelm.maps.drawing import polygon_of_disc, polygon_of_rect, rotate
from cohelm.platforms import is_simulated
from cohelm.scenarios import Scenario
from cohelm.scenarios.floor import floor_plan
from cohelm.scenarios.objects import Obstacle


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


def _points(corners: Floats) -> tuple[tuple[float, float], ...]:
    """Corners (k, 2) to the millimetre, m."""
    return tuple((round(float(x), 3), round(float(y), 3)) for x, y in corners)
