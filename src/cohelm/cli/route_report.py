"""Report of a planned route: figures for JSON, a table, sentences, and notes on problems."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from rich.console import Group
from rich.table import Table
from rich.text import Text

from cohelm.arrays import Floats
from cohelm.cli.report import fitted_table, versions
from cohelm.maps import DistanceField
from cohelm.maps.masks import closed_cells
from cohelm.messages import Path, Wish
from cohelm.planning.alternatives.alternatives import Alternative, wish_distance
from cohelm.planning.alternatives.features import FeatureParameters
from cohelm.planning.costmap.layers.zones import distance_to_zone
from cohelm.planning.costmap.patch import INSCRIBED, window_around
from cohelm.planning.path_measures import gap_to_zone, min_gap, time_in_speed_zones
from cohelm.planning.planners.wishes import attracting_points, strokes
from cohelm.planning.problem import PreparedProblem

FAR = 1.0
"""A wish farther than this from the route is missed, m."""

_SHORT = 0.005
"""A smaller shortfall of the requested clearance is not reported, m."""


def summary(
    prepared: PreparedProblem, found: tuple[Alternative, ...], measuring: FeatureParameters
) -> dict[str, Any]:
    """Content of ``--json`` except its timing; the first route's figures are at the top."""
    first = found[0].path
    closest = first.wishes.closest
    routes = [_figures(prepared, each, measuring) for each in found]
    return {
        **routes[0],
        "closest_to_preference": float(closest.max()) if len(closest) else None,
        "without_wishes": first.without_wishes.tolist(),
        "alternatives": routes,
        "wishes": [_wish(wish) for wish in prepared.problem.wishes],
        "notes": [
            *notes(prepared, first, routes[0]["minimum_clearance"]),
            *_better_alternatives(found),
        ],
        "method": first.method,
        "robot": prepared.problem.robot.name,
        "speed": measuring.speed,
        "versions": versions(),
    }


def _better_alternatives(found: tuple[Alternative, ...]) -> Iterator[str]:
    """Notes on routes that meet the wishes better than the first, the planner's own."""
    first = found[0].path
    for number, each in enumerate(found[1:], start=2):
        nearer = wish_distance(first) - wish_distance(each.path)
        if each.path.cost <= first.cost and nearer > FAR:
            yield f"route {number} costs no more and comes nearer to the wishes, by {nearer:.1f} m"


def _figures(
    prepared: PreparedProblem, each: Alternative, measuring: FeatureParameters
) -> dict[str, Any]:
    problem, path, features = prepared.problem, each.path, each.features
    speed = min(measuring.speed, problem.robot.max_speed)
    zones = [wish for wish in problem.wishes if wish.kind == "avoid" and len(wish.points)]
    slowed = time_in_speed_zones(path.points, problem.filters, speed, problem.robot.max_speed)
    return {
        "length": path.length,
        "cost": path.cost,
        "points": path.points.tolist(),
        "closest_to_each": path.wishes.closest.tolist(),
        "closest_to_zones": path.wishes.avoided.tolist(),
        "gaps_to_zones": [gap_to_zone(path, problem.robot, zone) for zone in zones],
        "from_strokes": path.wishes.along.tolist(),
        "extra_length": path.wishes.extra_length,
        "extra_cost": path.wishes.extra_cost,
        "minimum_clearance": gap_along(prepared, path),
        "estimated_time": features.time + slowed,
        "crowding": features.crowding,
        "turns": features.turns,
        "doors": features.doors,
        "pivots": path.points[path.pivots].tolist(),
        "cusps": path.points[path.cusps].tolist(),
        "backs_out": path.backs_out,
        "overlap": each.overlap,
    }


def gap_along(prepared: PreparedProblem, path: Path) -> float:
    """Minimum distance between the chair's footprint and obstacles, m."""
    grid = prepared.costmap.grid
    walls = DistanceField(
        distance=prepared.costmap.walls, resolution=grid.resolution, X_MG=grid.X_MG
    )
    return min_gap(path, prepared.problem.robot, walls)


def _wish(wish: Wish) -> dict[str, Any]:
    return {
        "kind": wish.kind,
        "points": wish.points.tolist(),
        "radius": wish.radius,
        "hard": wish.hard,
    }


def facts_table(report: dict[str, Any]) -> Table:
    """The first route as a table."""
    table = Table(title=Text(f"{report['method']}, {report['robot']}"), header_style="dim")
    table.add_column("")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    table.add_row("length", f"{report['length']:.2f}", "m")
    table.add_row("cost (weighted length)", f"{report['cost']:.2f}", "m")
    table.add_row(f"time at up to {report['speed']:g} m/s", f"{report['estimated_time']:.1f}", "s")
    table.add_row("minimum clearance", f"{report['minimum_clearance']:.2f}", "m")
    if report["crowding"] > 0.0:
        table.add_row("people on the route", f"{report['crowding']:.3f}", "1/m²")
    if report["cusps"]:
        table.add_row("changes of gear", str(len(report["cusps"])), "")
    if report["pivots"]:
        table.add_row("turns on the spot", str(len(report["pivots"])), "")
    table.add_row("points", str(len(report["points"])), "")
    return table


def alternative_table(report: dict[str, Any]) -> Table | Group:
    """The routes side by side."""
    points = range(1, len(report["closest_to_each"]) + 1)
    heads = ("length m", "weighted m", "time s", "clearance m", "people 1/m²", "doors", "turns")
    columns = ("route", *heads, *(f"to point {i} m" for i in points), "shared")
    figures = ("length", "cost", "estimated_time", "minimum_clearance")
    rows = [
        (
            str(number),
            *(f"{each[key]:.2f}" for key in figures),
            f"{each['crowding']:.3f}",
            str(each["doors"]),
            str(each["turns"]),
            *(f"{distance:.2f}" for distance in each["closest_to_each"]),
            f"{each['overlap']:.0%}" if number > 1 else "",
        )
        for number, each in enumerate(report["alternatives"], start=1)
    ]
    return fitted_table("routes to choose from", columns, rows)


def describe(report: dict[str, Any]) -> list[str]:
    """Sentences: cost of the wishes, how far each is met, and notes."""
    lines = []
    if report["closest_to_each"] or report["from_strokes"]:
        many = len(report["closest_to_each"]) + len(report["from_strokes"]) > 1
        extra, weighted = report["extra_length"] + 0.0, report["extra_cost"] + 0.0
        lines.append(
            f"the wish{'es cost' if many else ' costs'} {extra:+.1f} m, {weighted:+.1f} weighted"
        )
    points, drawn, zones = (_places(report, kind) for kind in ("attract", "stroke", "avoid"))
    for number, (point, distance) in enumerate(
        zip(points, report["closest_to_each"], strict=True), start=1
    ):
        where = f"point {number} ({point[0]:g}, {point[1]:g})"
        lines.append(f"{where}: the route passes within {distance:.2f} m")
    for number in range(1, len(drawn) + 1):
        distance = report["from_strokes"][number - 1]
        lines.append(f"drawn line {number}: {distance:.2f} m away on average")
    lines += [_says_zone(report, number, zone) for number, zone in enumerate(zones, start=1)]
    return [*lines, *(f"note: {note}" for note in report["notes"])]


def _says_zone(report: dict[str, Any], number: int, zone: dict[str, Any]) -> str:
    """A hard zone excludes the whole footprint; a soft one adds cost for the chair's centre."""
    kind = "never to enter" if zone["hard"] else "to avoid"
    part = "footprint" if zone["hard"] else "centre"
    gap = report["gaps_to_zones" if zone["hard"] else "closest_to_zones"][number - 1]
    where = f"kept {gap:.2f} m from" if gap >= 0.0 else f"entered by {-gap:.2f} m by"
    return f"zone {number}, {kind}: {where} the chair's {part}"


def _places(report: dict[str, Any], kind: str) -> list[Any]:
    """Points that attract, drawn lines, or zones in the report."""
    wished = [wish for wish in report["wishes"] if wish["kind"] == kind and wish["points"]]
    return [p for wish in wished for p in wish["points"]] if kind == "attract" else wished


def notes(prepared: PreparedProblem, path: Path, gap: float) -> list[str]:
    """Sentences on problems of one route: start, points, zones, clearance.

    Args:
        prepared: of the problem.
        path: the route.
        gap: minimum distance between footprint and obstacles along it, m.
    """
    return [
        *_on_start(prepared),
        *_on_points(prepared, path),
        *_on_zones(prepared),
        *_on_clearance(prepared.problem.clearance, gap),
    ]


def missed_points(prepared: PreparedProblem, path: Path) -> list[int]:
    """Indices of points that the route could reach but misses."""
    points = attracting_points(prepared.problem)
    far = [i for i, distance in enumerate(path.wishes.closest) if distance > FAR]
    return [i for i in far if _fits(prepared, points[i])]


def _on_start(prepared: PreparedProblem) -> Iterator[str]:
    costmap, start, problem = prepared.costmap, prepared.start, prepared.problem
    if costmap.cost[start] < INSCRIBED:
        return
    inside = [
        f"zone {number}, never to enter"
        for number, zone in enumerate(_zones(prepared), start=1)
        if zone.hard and distance_to_zone(zone, problem.start) <= 0.0
    ]
    if closed_cells(problem.filters, problem.grid)[start]:
        inside.append("a keepout zone")
    if inside:
        yield f"the start lies inside {' and '.join(inside)}: the route leads out of it first"
    elif costmap.walls[start] > costmap.radius:
        yield "the start is too close to a zone never to enter: the route leads away from it first"
    else:
        yield (
            f"the start has {max(float(costmap.walls[start]), 0.0):.2f} m of clearance, the robot "
            f"needs {costmap.radius:.2f} m: the route leads away from the obstacle first"
        )


def _on_points(prepared: PreparedProblem, path: Path) -> Iterator[str]:
    grid = prepared.problem.grid
    points = attracting_points(prepared.problem)
    for number, point in enumerate(points, start=1):
        name = f"point {number} ({point[0]:g}, {point[1]:g})"
        if not grid.contains(point):
            yield f"{name} lies off the map"
        elif path.wishes.closest[number - 1] > FAR and not _fits(prepared, point):
            yield f"{name}: the chair does not fit there"
    for number, line in enumerate(strokes(prepared.problem), start=1):
        if not grid.contains(line).all():
            yield f"drawn line {number} leads off the map"


def _on_zones(prepared: PreparedProblem) -> Iterator[str]:
    for number, zone in enumerate(_zones(prepared), start=1):
        if window_around(zone.points, zone.radius, prepared.problem.grid) is None:
            yield f"zone {number} lies off the map"


def _on_clearance(wanted: float, gap: float) -> Iterator[str]:
    if wanted > 0.0 and gap < wanted - _SHORT:
        yield f"the clearance of {wanted:.2f} m is not kept everywhere: the minimum is {gap:.2f} m"


def _zones(prepared: PreparedProblem) -> list[Wish]:
    return [wish for wish in prepared.problem.wishes if wish.kind == "avoid" and len(wish.points)]


def _fits(prepared: PreparedProblem, point: Floats) -> bool:
    """Check that the chair's centre may be at a point (2,) of the map frame."""
    grid = prepared.problem.grid
    if not (np.isfinite(point).all() and bool(grid.contains(point))):
        return False
    row, col = (int(each) for each in grid.cells(point))
    return bool(prepared.costmap.cost[row, col] < INSCRIBED)
