"""What a plan must not pass over in silence: ends in closed zones, wishes that cannot be served."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from cohelm.arrays import Floats
from cohelm.maps.masks import closed_cells
from cohelm.messages import Path, Wish
from cohelm.planning.cost_values import INSCRIBED
from cohelm.planning.ground import Ground
from cohelm.planning.layers.patch import window_about
from cohelm.planning.layers.zones import distance_to_zone
from cohelm.planning.wishes import attracting_points, strokes

FAR = 1.0
"""From a route that serves a wish badly, m."""

_SHORT = 0.005  # that a gap may fall short of what was asked for before it is told, m


def notes(ground: Ground, path: Path, gap: float) -> list[str]:
    """Sentences on one route, in the order in which they are met.

    Args:
        ground: of the problem.
        path: the route.
        gap: the least between the chair's outline and obstacles along it, m.
    """
    return [
        *_on_start(ground),
        *_on_points(ground, path),
        *_on_zones(ground),
        *_on_clearance(ground.problem.clearance, gap),
    ]


def missed_points(ground: Ground, path: Path) -> list[int]:
    """Indices of the points that a route could serve, but comes nowhere near to."""
    points = attracting_points(ground.problem)
    far = [i for i, distance in enumerate(path.wishes.closest) if distance > FAR]
    return [i for i in far if _fits(ground, points[i])]


def _on_start(ground: Ground) -> Iterator[str]:
    costmap, start, problem = ground.costmap, ground.start, ground.problem
    if costmap.cost[start] < INSCRIBED:
        return
    inside = [
        f"zone {number}, never to enter"
        for number, zone in enumerate(_zones(ground), start=1)
        if zone.hard and distance_to_zone(zone, problem.start) <= 0.0
    ]
    if closed_cells(problem.filters, problem.grid)[start]:
        inside.append("a keepout zone")
    if inside:
        yield f"the start lies inside {' and '.join(inside)}: the route leads out of it first"
    elif costmap.walls[start] > costmap.radius:
        yield "the start is too near to a zone never to enter: the route leads away from it first"
    else:
        yield (
            f"the start has {max(float(costmap.walls[start]), 0.0):.2f} m of clearance, the robot "
            f"needs {costmap.radius:.2f} m: the route leads away from the obstacle first"
        )


def _on_points(ground: Ground, path: Path) -> Iterator[str]:
    grid = ground.problem.grid
    points = attracting_points(ground.problem)
    for number, point in enumerate(points, start=1):
        name = f"point {number} ({point[0]:g}, {point[1]:g})"
        if not grid.contains(point):
            yield f"{name} lies off the map"
        elif path.wishes.closest[number - 1] > FAR and not _fits(ground, point):
            yield f"{name}: the chair does not fit there"
    for number, line in enumerate(strokes(ground.problem), start=1):
        if not grid.contains(line).all():
            yield f"drawn line {number} leads off the map"


def _on_zones(ground: Ground) -> Iterator[str]:
    for number, zone in enumerate(_zones(ground), start=1):
        if window_about(zone.points, zone.radius, ground.problem.grid) is None:
            yield f"zone {number} lies off the map"


def _on_clearance(wanted: float, gap: float) -> Iterator[str]:
    if wanted > 0.0 and gap < wanted - _SHORT:
        yield f"the clearance of {wanted:.2f} m is not kept all along: the least gap is {gap:.2f} m"


def _zones(ground: Ground) -> list[Wish]:
    return [wish for wish in ground.problem.wishes if wish.kind == "avoid" and len(wish.points)]


def _fits(ground: Ground, point: Floats) -> bool:
    """Whether the chair's middle may be at a point (2,) of the map frame."""
    grid = ground.problem.grid
    if not (np.isfinite(point).all() and bool(grid.contains(point))):
        return False
    row, col = (int(each) for each in grid.cells(point))
    return bool(ground.costmap.cost[row, col] < INSCRIBED)
