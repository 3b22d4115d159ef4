"""What ``cohelm plan`` says: numbers for programs, a table and sentences for people."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich.table import Table
from rich.text import Text

from cohelm.cli.notes import FAR, notes
from cohelm.cli.report import versions
from cohelm.maps import DistanceField
from cohelm.messages import Path, Wish
from cohelm.planning.along import gap_to_zone, least_gap, time_in_speed_zones
from cohelm.planning.alternatives import Alternative, wish_distance
from cohelm.planning.features import Measuring
from cohelm.planning.ground import Ground


def summary(ground: Ground, found: tuple[Alternative, ...], measuring: Measuring) -> dict[str, Any]:
    """What ``--json`` says but for its timing; the first route's figures are at the top."""
    first = found[0].path
    closest = first.wishes.closest
    routes = [_figures(ground, each, measuring) for each in found]
    return {
        **routes[0],
        "closest_to_preference": float(closest.max()) if len(closest) else None,
        "without_wishes": first.without_wishes.tolist(),
        "alternatives": routes,
        "wishes": [_wish(wish) for wish in ground.problem.wishes],
        "notes": [
            *notes(ground, first, routes[0]["minimum_clearance"]),
            *_better_alternatives(found),
        ],
        "method": first.method,
        "robot": ground.problem.robot.name,
        "speed": measuring.speed,
        "versions": versions(),
    }


def _better_alternatives(found: tuple[Alternative, ...]) -> Iterator[str]:
    """The first is what the planner's method says, which need not serve wishes best."""
    first = found[0].path
    for number, each in enumerate(found[1:], start=2):
        nearer = wish_distance(first) - wish_distance(each.path)
        if each.path.cost <= first.cost and nearer > FAR:
            yield f"route {number} costs no more and comes nearer to the wishes, by {nearer:.1f} m"


def _figures(ground: Ground, each: Alternative, measuring: Measuring) -> dict[str, Any]:
    problem, path, features = ground.problem, each.path, each.features
    speed = min(measuring.speed, problem.robot.max_speed)
    zones = [wish for wish in problem.wishes if wish.kind == "avoid" and len(wish.points)]
    slowed = time_in_speed_zones(path.points, problem.filters, speed, problem.robot.max_speed)
    return {
        "length": path.length,
        "cost": path.cost,
        "points": path.points.tolist(),
        "closest_to_each": path.wishes.closest.tolist(),
        "closest_to_zones": path.wishes.avoided.tolist(),
        "gaps_to_zones": [gap_to_zone(path.points, problem.robot, zone) for zone in zones],
        "from_strokes": path.wishes.along.tolist(),
        "extra_length": path.wishes.extra_length,
        "extra_cost": path.wishes.extra_cost,
        "minimum_clearance": gap_along(ground, path),
        "estimated_time": features.time + slowed,
        "crowding": features.crowding,
        "turns": features.turns,
        "doors": features.doors,
        "pivots": path.points[path.pivots].tolist(),
        "overlap": each.overlap,
    }


def gap_along(ground: Ground, path: Path) -> float:
    """Least distance between the chair's outline and what bodily stands there, m."""
    grid = ground.costmap.grid
    walls = DistanceField(distance=ground.costmap.walls, resolution=grid.resolution, X_MG=grid.X_MG)
    return least_gap(path.points, ground.problem.robot, walls)


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
    table.add_column("what")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    table.add_row("length", f"{report['length']:.2f}", "m")
    table.add_row("cost: length, weighted", f"{report['cost']:.2f}", "m")
    table.add_row(f"time at {report['speed']:g} m/s", f"{report['estimated_time']:.1f}", "s")
    table.add_row("least gap to obstacles", f"{report['minimum_clearance']:.2f}", "m")
    if report["crowding"] > 0.0:
        table.add_row("people on the way", f"{report['crowding']:.3f}", "1/m²")
    if report["pivots"]:
        table.add_row("turns on the spot", str(len(report["pivots"])), "")
    table.add_row("points", str(len(report["points"])), "")
    return table


def alternative_table(report: dict[str, Any]) -> Table:
    """The routes side by side."""
    table = Table(title=Text("routes to choose from"), header_style="dim", title_justify="left")
    points = range(1, len(report["closest_to_each"]) + 1)
    heads = ("length m", "weighted m", "time s", "least gap m", "people 1/m²", "doors", "turns")
    for head in ("", *heads, *(f"to point {i} m" for i in points), "shared"):
        table.add_column(head, justify="right")
    for number, each in enumerate(report["alternatives"], start=1):
        figures = ("length", "cost", "estimated_time", "minimum_clearance")
        table.add_row(
            str(number),
            *(f"{each[key]:.2f}" for key in figures),
            f"{each['crowding']:.3f}",
            str(each["doors"]),
            str(each["turns"]),
            *(f"{distance:.2f}" for distance in each["closest_to_each"]),
            f"{each['overlap']:.0%}" if number > 1 else "",
        )
    return table


def describe(report: dict[str, Any]) -> list[str]:
    """Sentences: what the wishes cost, how far they are met, and what else is to be known."""
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
        lines.append(f"{where}: the route comes to {distance:.2f} m")
    for number in range(1, len(drawn) + 1):
        distance = report["from_strokes"][number - 1]
        lines.append(f"drawn line {number}: {distance:.2f} m away on average")
    lines += [_says_zone(report, number, zone) for number, zone in enumerate(zones, start=1)]
    return [*lines, *(f"note: {note}" for note in report["notes"])]


def _says_zone(report: dict[str, Any], number: int, zone: dict[str, Any]) -> str:
    """Into a hard zone no part of the chair may come; a soft one is dear to the chair's middle."""
    what = "never to enter" if zone["hard"] else "rather avoided"
    who = "outline" if zone["hard"] else "middle"
    gap = report["gaps_to_zones" if zone["hard"] else "closest_to_zones"][number - 1]
    where = f"kept {gap:.2f} m from" if gap >= 0.0 else f"entered by {-gap:.2f} m by"
    return f"zone {number}, {what}: {where} the chair's {who}"


def _places(report: dict[str, Any], kind: str) -> list[Any]:
    """The points that attract, the drawn lines, or the zones."""
    wished = [wish for wish in report["wishes"] if wish["kind"] == kind and wish["points"]]
    return [p for wish in wished for p in wish["points"]] if kind == "attract" else wished
