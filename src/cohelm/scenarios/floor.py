"""Floor of a scenario: the drawn plan with its changes, and objects that are not on the map."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats, Floats32, Integers
from cohelm.config import read_yaml, validate
from cohelm.errors import ScenarioError
from cohelm.maps import OCCUPIED, FloorPlan, OccupancyGrid
from cohelm.scenarios.objects import FloorLevel, Obstacle, ScheduledDoor, Storey
from cohelm.scenarios.scenario import Scenario, floor_file
from cohelm.simulation import FloorPiece, FloorRelief, ManualDoor, MapChange
from cohelm.simulation.sensors.floor_relief import LEVEL, FloorSurface

WIDEST = 2.5
"""Greatest width of an opening that has a door, m."""


def floor_plan(scenario: Scenario, *, of_world: bool = False) -> FloorPlan:
    """Floor plan of a scenario, with the scenario's ``floor_plan`` merged into it.

    Args:
        scenario: names the floor.
        of_world: merge ``world_plan`` too: the floor as it is, not as the map has it.

    Raises:
        ScenarioError: if the floor does not exist, or a change does not fit it.
    """
    if scenario.floor is None:
        raise ScenarioError(
            "needs floor: NAME; this scenario has a map:", file=scenario.file, key="floor_plan"
        )
    file = floor_file(scenario.floor)
    data = _merged(read_yaml(file, error=ScenarioError), scenario.floor_plan, scenario)
    if of_world:
        data = _merged(data, scenario.world_plan, scenario, "world_plan")
    named = scenario.file if scenario.floor_plan or of_world else file
    plan = validate(FloorPlan, data, file=named, prefix="floor_plan", error=ScenarioError)
    return plan.model_copy(update={"source": str(named)})


def doorways(plan: FloorPlan) -> tuple[ManualDoor, ...]:
    """Doors of a floor that can be closed; a leaf is as thick as the wall."""
    has_door = [door.width <= WIDEST for door in plan.doors]
    ends = plan.openings[np.array(has_door, dtype=bool)]
    return tuple(ManualDoor(a=a, b=b, depth=plan.wall) for a, b in ends)


def relief_of(storey: Storey) -> FloorRelief:
    """Heights of a storey's floor."""
    ramp = storey.ramp
    floor = LEVEL
    if ramp is not None:
        floor = FloorSurface(
            at=np.array(ramp.at),
            direction=math.radians(ramp.direction_deg),
            gradient=ramp.gradient,
            length=ramp.length,
        )
    bars = [FloorLevel(**each.model_dump()) for each in storey.thresholds]
    pieces = tuple(
        FloorPiece(
            at=np.array(each.at),
            size=np.array(each.size),
            angle=math.radians(each.angle_deg),
            height=each.height,
            rise=each.rise,
            steps=each.steps,
            dark=each.dark,
        )
        for each in (*storey.levels, *bars)
    )
    return FloorRelief(floor=floor, pieces=pieces)


def covered_by(grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]) -> Booleans:
    """Cells (rows, cols) that some obstacle covers."""
    out = np.zeros(grid.shape, dtype=bool)
    for _, covered in _covered(grid, obstacles):
        out[covered] = True
    return out


def with_obstacles(grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]) -> OccupancyGrid:
    """Grid with every cell occupied whose centre an obstacle covers."""
    if not obstacles:
        return grid
    data = grid.data.copy()
    for _, covered in _covered(grid, obstacles):
        data[covered] = OCCUPIED
    return OccupancyGrid(data=data, resolution=grid.resolution, X_MG=grid.X_MG)


def with_heights(
    heights: Floats32 | None, grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]
) -> Floats32 | None:
    """Heights (rows, cols) of occupied cells, m; NaN: as high as the walls.

    Args:
        heights: without the obstacles; None: wall height everywhere, which is also returned where
            no obstacle is lower.
        grid: grid of the cells.
        obstacles: additional obstacles.
    """
    if heights is None and all(each.height is None for each in obstacles):
        return None
    out = np.full(grid.shape, np.nan, dtype=np.float32) if heights is None else heights.copy()
    for each, covered in _covered(grid, obstacles):
        out[covered] = np.nan if each.height is None else each.height
    return out


def grid_changes(grid: OccupancyGrid, doors: tuple[ScheduledDoor, ...]) -> tuple[MapChange, ...]:
    """Grid from time 0, and the grid after each scheduled move of a door.

    Equal sets of closed doors share one grid.

    Args:
        grid: grid with every door open.
        doors: doors with their schedules.
    """
    times = sorted({0.0, *(t for door in doors for interval in door.closed for t in interval)})
    grids: dict[tuple[bool, ...], OccupancyGrid] = {}
    out = []
    for time in times:
        shut = tuple(door.is_closed(time) for door in doors)
        if shut not in grids:
            leaves = tuple(d.leaf for d, closed in zip(doors, shut, strict=True) if closed)
            grids[shut] = with_obstacles(grid, leaves)
        out.append(MapChange(time=time, grid=grids[shut]))
    return tuple(out)


def _covered(
    grid: OccupancyGrid, obstacles: tuple[Obstacle, ...]
) -> Iterator[tuple[Obstacle, tuple[Integers, Integers]]]:
    """Each obstacle with the cells (rows (n,), columns (n,)) whose centres it covers."""
    for each in obstacles:
        reach = each.radius or math.hypot(*(each.size or (0.0, 0.0))) / 2.0
        around = np.ceil(reach / grid.resolution).astype(np.int64) + 1
        middle = grid.cells(np.array(each.at, dtype=float))
        first = np.maximum(middle - around, 0)
        last = np.maximum(np.minimum(middle + around + 1, grid.shape), first)
        rows, cols = (np.arange(*span) for span in zip(first, last, strict=True))
        rows, cols = (part.ravel() for part in np.meshgrid(rows, cols, indexing="ij"))
        delta = grid.centres(np.stack([rows, cols], axis=-1)) - np.array(each.at)
        inside = _inside(each, delta)
        yield each, (rows[inside], cols[inside])


def _inside(obstacle: Obstacle, delta: Floats) -> Booleans:
    """Mask (n,) of the points within an obstacle, relative to its middle (n, 2), m."""
    if obstacle.radius is not None:
        return np.asarray(np.hypot(delta[:, 0], delta[:, 1]) <= obstacle.radius)
    angle = math.radians(obstacle.angle_deg)
    along = math.cos(angle) * delta[:, 0] + math.sin(angle) * delta[:, 1]
    aside = math.cos(angle) * delta[:, 1] - math.sin(angle) * delta[:, 0]
    half = np.array(obstacle.size, dtype=float) / 2.0
    return np.asarray((np.abs(along) <= half[0]) & (np.abs(aside) <= half[1]))


def _merged(base: Any, changes: Any, scenario: Scenario, key: str = "floor_plan") -> Any:
    """``base`` with ``changes`` merged: mappings by key, list entries by index."""
    if isinstance(base, Mapping) and isinstance(changes, Mapping):
        out = dict(base)
        for name, each in changes.items():
            inner = f"{key}.{name}"
            out[name] = _merged(base[name], each, scenario, inner) if name in base else each
        return out
    if isinstance(base, list) and isinstance(changes, Mapping):
        entries = list(base)
        for name, each in changes.items():
            if not str(name).isdecimal() or int(name) >= len(entries):
                raise ScenarioError(
                    f"the list has {len(entries)} entries: give an index below that",
                    file=scenario.file,
                    key=f"{key}.{name}",
                )
            entries[int(name)] = _merged(entries[int(name)], each, scenario, f"{key}.{name}")
        return entries
    return changes
