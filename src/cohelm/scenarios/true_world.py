"""True floor of a scenario: what its map lacks, and what only rider or chair sees."""

from __future__ import annotations

from typing import NamedTuple

from cohelm.arrays import Floats32
from cohelm.maps import OCCUPIED, OccupancyGrid
from cohelm.scenarios.floor import (
    covered_by,
    doorways,
    floor_plan,
    grid_changes,
    with_heights,
    with_obstacles,
)
from cohelm.scenarios.scenario import Scenario
from cohelm.simulation import ManualDoor, MapChange, SplitCells, with_cells


class TrueWorld(NamedTuple):
    """Obstacles of a world."""

    grid: OccupancyGrid
    """At time 0."""
    changes: tuple[MapChange, ...]
    """Later ones."""
    heights: Floats32 | None
    """Heights of occupied cells, m; None: wall height everywhere."""
    doors: tuple[ManualDoor, ...]
    """Doors that can be closed."""
    split: SplitCells | None
    """Cells that rider and chair see differently; None: none."""

    @property
    def known_to_rider(self) -> OccupancyGrid:
        """Obstacles at time 0, and floor that the rider avoids."""
        return (
            self.grid if self.split is None else with_cells(self.grid, self.split.avoided, OCCUPIED)
        )


def true_world(
    scenario: Scenario,
    grid: OccupancyGrid,
    heights: Floats32 | None,
    doors: tuple[ManualDoor, ...],
) -> TrueWorld:
    """Build the true obstacles of a scenario.

    Args:
        scenario: with obstacles, doors and changes of the drawing.
        grid: map of the chair.
        heights: heights of its cells, m; None: not known.
        doors: doors of the map.
    """
    if scenario.world_plan:
        plan = floor_plan(scenario, of_world=True)
        grid, heights, doors = plan.draw()[0], plan.heights(), doorways(plan)
    solid = tuple(each for each in scenario.obstacles if each.solid)
    first, *later = grid_changes(with_obstacles(grid, solid), scenario.doors)
    return TrueWorld(
        grid=first.grid,
        changes=tuple(later),
        heights=with_heights(heights, grid, solid),
        doors=doors,
        split=_split(scenario, grid),
    )


def _split(scenario: Scenario, grid: OccupancyGrid) -> SplitCells | None:
    if all(each.sensed and each.solid for each in scenario.obstacles):
        return None
    sensed = tuple(each for each in scenario.obstacles if each.solid and each.sensed)
    unsensed = tuple(each for each in scenario.obstacles if each.solid and not each.sensed)
    floor = tuple(each for each in scenario.obstacles if not each.solid)
    return SplitCells(
        unsensed=covered_by(grid, unsensed) & ~with_obstacles(grid, sensed).occupied(),
        avoided=covered_by(grid, floor),
    )
