"""``cohelm plan`` in a building: a route over rooms, doors and lifts, and a path on each storey."""

from __future__ import annotations

import dataclasses
import itertools
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import replace
from cohelm.buildings import (
    BuildingRoute,
    BuildingStorey,
    Direction,
    RouteGraph,
    RouteNode,
    RouteWishes,
    directions,
    polygon_cells,
    read_storeys,
    route_graph,
)
from cohelm.cli.progress import waiting
from cohelm.cli.report import OUTPUT, plain_table, print_line, write_json
from cohelm.cli.requests import RouteRequest
from cohelm.cli.route_report import summary
from cohelm.errors import (
    BuildingError,
    ConfigError,
    GoalBlocked,
    NoPath,
    NoRoute,
    PlanningError,
    StartBlocked,
)
from cohelm.maps import OCCUPIED, Places
from cohelm.messages import Wish
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives.alternatives import (
    Alternative,
    AlternativeCriteria,
    find_alternatives,
)
from cohelm.planning.alternatives.features import FeatureParameters
from cohelm.planning.planners.route import parameters_of
from cohelm.planning.problem import PreparedProblem, prepare
from cohelm.robots import Robot, load_robot

_WORDS = {"wide": {"narrow_price": 1.0}, "level": {"ramp_price": 30.0}}
"""Prices of the words of ``--prefer``: a narrow metre counts double, a ramp as 30 m; assumed."""
_ATTEMPTS = 8
"""Routes over the graph that are tried until the chair fits through all of one."""
_SAME_WALL = 0.6
"""Doors closer than this are one doorway, m."""
_OTHER_OPTIONS = ("stroke", "keepout", "speed_mask", "filter_info", "crowding", "ordered")


@dataclass(frozen=True, kw_only=True)
class _Leg:
    """Part of a route on one storey."""

    storey: BuildingStorey
    nodes: tuple[RouteNode, ...]
    prepared: PreparedProblem
    found: tuple[Alternative, ...]


def plan_in_building(request: RouteRequest, planner: GlobalPlanner) -> int:
    """Plan in a building, print, and draw if requested; returns 0.

    Raises:
        CohelmError: if the folder holds no building, a place, robot or option is not valid, or
            there is no route.
    """
    given = [name for name in _OTHER_OPTIONS if getattr(request, name)]
    for name in [*given, *["alternatives"] * (request.alternatives > 1)]:
        option = f"--{name.replace('_', '-')}"
        raise ConfigError("needs one map: name the .yaml of a storey", key=option)
    robot, measuring = load_robot(request.robot), FeatureParameters(speed=request.speed)
    with waiting("planning"):
        try:
            graph = route_graph(read_storeys(Path(request.map)))
        except ImportError as cause:
            problem = f"routes in buildings need more ({cause}): pip install 'cohelm[building]'"
            raise BuildingError(problem, file=Path(request.map)) from None
        wishes = _wishes(graph, request)
        route, legs, notes = _planned(graph, request, robot, planner, wishes)
        costs = {}
        for name, others in wishes.each_without().items():
            try:
                without = _planned(graph, request, robot, planner, others)[1]
            except PlanningError:
                notes.append(f"the wish {name!r} has no price: no route without it was found")
            else:
                driven = [sum(leg.found[0].path.length for leg in each) for each in (legs, without)]
                costs[name] = driven[0] - driven[1]
        steps = directions(graph, route)
        reports = [summary(leg.prepared, leg.found, measuring) for leg in legs]
        report = _report(request, route, legs, steps, reports) | {"wishes": costs}
        said = (note for each in reports for note in each.pop("notes"))
        report["notes"] = [*graph.notes, *notes, *said]
    pictures = [] if request.plot is None else _draw(legs, request.plot)
    if request.json:
        write_json({**report, "written": [str(file) for file in pictures]})
        return 0
    _print(report)
    for file in pictures:
        print_line(f"written: {file}")
    return 0


def _wishes(graph: RouteGraph, request: RouteRequest) -> RouteWishes:
    prices: dict[str, float] = {}
    for word in request.prefer:
        if word.strip().casefold() not in _WORDS:
            known = " or ".join(_WORDS)
            raise ConfigError(f"in a building write {known}, got {word!r}", key="--prefer")
        prices |= _WORDS[word.strip().casefold()]
    avoid = [graph.rooms(name, "--avoid") for name in request.avoid]
    closed = [graph.rooms(name, "--avoid-hard") for name in request.avoid_hard]
    return RouteWishes(avoid=frozenset().union(*avoid), closed=frozenset().union(*closed), **prices)


def _planned(
    graph: RouteGraph,
    request: RouteRequest,
    robot: Robot,
    planner: GlobalPlanner,
    wishes: RouteWishes,
) -> tuple[BuildingRoute, list[_Leg], list[str]]:
    """Route over the graph with a path on each storey, and notes on what the chair does not pass.

    Where the chair does not fit through a part of a route, that part is closed and the next route
    tried.

    Raises:
        NoRoute: if none is left; names the first part that closes one.
    """
    start, goal = graph.find(request.start, "--start"), graph.find(request.goal, "--goal")
    width = 2.0 * (robot.inscribed_radius + request.clearance)
    thresholds = _thresholds(graph, robot)
    blocked, notes = {*thresholds}, list[str]()
    for _ in range(_ATTEMPTS):
        try:
            route = graph.route(start, goal, width=width, wishes=wishes, blocked=blocked)
        except NoRoute as cause:
            if notes:
                because = notes[0]
            else:
                try:
                    route = graph.route(start, goal, width=width, wishes=wishes)
                except NoRoute:
                    raise cause from None
                pairs = map(frozenset, itertools.pairwise(route.positions))
                because = next(thresholds[pair] for pair in pairs if pair in thresholds)
            raise NoRoute(
                start=cause.start, goal=cause.goal, needed=width, because=because
            ) from None
        legs: list[_Leg] = []
        for part in _on_one_storey(route):
            nodes = tuple(graph.nodes[i] for i in part)
            problem = _problem(graph, nodes, wishes, robot, request.clearance)
            try:
                found = find_alternatives(problem, planner, 1, AlternativeCriteria())
            except PlanningError as cause:
                start_blocked = isinstance(cause, StartBlocked) and nodes[0] is route.nodes[0]
                if start_blocked or (
                    isinstance(cause, GoalBlocked) and nodes[-1] is route.nodes[-1]
                ):
                    raise
                notes.append(_close(graph, part, cause, blocked))
                break
            prepared = prepare(problem, parameters_of(planner))
            storey = graph.storey(nodes[0].storey)
            legs.append(_Leg(storey=storey, nodes=nodes, prepared=prepared, found=found))
        else:
            return route, legs, notes
    raise NoRoute(start=request.start, goal=request.goal, needed=width, because=notes[0])


def _thresholds(graph: RouteGraph, robot: Robot) -> dict[frozenset[int], str]:
    """Doors with a threshold that the robot does not climb, by their pair of nodes, in words."""
    found = {}
    for one, other in graph.graph.edges:
        edge = graph.edge(one, other)
        height = 0.0 if edge.door is None else edge.door.threshold or 0.0
        if height > robot.max_step_up:
            found[frozenset((one, other))] = (
                f"the robot climbs {robot.max_step_up:.3f} m, the threshold of "
                f"{graph.describe(one, other)}, is {height:.3f} m high"
            )
    return found


def _on_one_storey(route: BuildingRoute) -> list[list[int]]:
    """Positions of the nodes of each part between lifts that has a length."""
    parts = [[route.positions[0]]]
    for i, edge in zip(route.positions[1:], route.edges, strict=True):
        parts.append([i]) if edge.kind == "lift" else parts[-1].append(i)
    return [part for part in parts if len(part) > 1]


def _problem(
    graph: RouteGraph, nodes: tuple[RouteNode, ...], wishes: RouteWishes, robot: Robot, room: float
) -> RouteProblem:
    """Planning problem on one storey, whose doors are closed unless the route uses them."""
    storey = graph.storey(nodes[0].storey)
    used = [node.point for node in nodes if node.kind == "door"]
    landings = [landing for lift in graph.lifts for landing in lift.landings]
    of_lifts = {door for each in landings if each.storey == storey.number for door in each.doors}
    data = storey.grid.data.copy()
    for door in storey.doors:
        near = any(np.linalg.norm(door.point - point) < _SAME_WALL for point in used)
        if not near and door.kind != "open border" and door.id not in of_lifts:
            half = max(door.opening, door.width) / 2.0
            closed = door.part(-half, half, storey.grid.resolution)
            data[polygon_cells([closed], storey.grid)] = OCCUPIED
    zones = tuple(
        Wish(kind="avoid", points=polygon, hard=room.id in wishes.closed)
        for room in storey.rooms
        if room.id in wishes.avoid | wishes.closed
        for polygon in room.polygons
    )
    return RouteProblem(
        grid=replace(storey.grid, data=data), robot=robot, start=nodes[0].point,
        goal=nodes[-1].point, wishes=zones, clearance=room,
    )  # fmt: skip


def _close(
    graph: RouteGraph, part: list[int], cause: PlanningError, blocked: set[frozenset[int]]
) -> str:
    """Close the part of a route where a path failed, and say why.

    It is the part nearest to the passage that the planner names, else the narrowest one; a door
    rather than the way up to it.
    """
    passage = cause.passage if isinstance(cause, NoPath) else None

    def order(pair: tuple[int, int]) -> tuple[float, float]:
        edge = graph.edge(*pair)
        if passage is None:
            return edge.clear_width, edge.kind != "door"
        away = float(np.linalg.norm(edge.points - passage.point, axis=1).min())
        return away + (0.0 if edge.kind == "door" else 0.6), edge.clear_width

    one, other = min(itertools.pairwise(part), key=order)
    blocked.add(frozenset((one, other)))
    return f"the robot does not get through {graph.describe(one, other)}: {passage or cause}"


def _report(
    request: RouteRequest,
    route: BuildingRoute,
    legs: list[_Leg],
    steps: tuple[Direction, ...],
    reports: list[dict[str, Any]],
) -> dict[str, Any]:
    """Content of ``--json``."""
    wait = float(sum(edge.wait for edge in route.edges))
    return {
        "start": request.start, "goal": request.goal,
        "length": float(sum(each["length"] for each in reports)),
        "estimated_time": float(sum(each["estimated_time"] for each in reports)) + wait,
        "lift_time": wait,
        "clear_width": route.clear_width if math.isfinite(route.clear_width) else None,
        "directions": [{**dataclasses.asdict(step), "text": step.text} for step in steps],
        "legs": [
            {
                "storey": leg.storey.name, "map": f"{leg.storey.stem}.yaml",
                "from": leg.nodes[0].name, "to": leg.nodes[-1].name,
                **{key: each for key, each in report.items() if key != "alternatives"},
            }
            for leg, report in zip(legs, reports, strict=True)
        ],
    }  # fmt: skip


def _print(report: dict[str, Any]) -> None:
    if report["legs"]:
        table = plain_table("storey", "from", "to", "length, m", "time, s", "clearance, m")
        for leg in report["legs"]:
            figures = (f"{leg[key]:.2f}" for key in ("length", "estimated_time"))
            gap = f"{leg['minimum_clearance']:.2f}"
            table.add_row(leg["storey"], leg["from"], leg["to"], *figures, gap)
        OUTPUT.print(table)
    lifts = f", {report['lift_time']:.0f} s of it in lifts" if report["lift_time"] else ""
    print_line(f"{report['length']:.1f} m, {report['estimated_time']:.0f} s{lifts}")
    for number, step in enumerate(report["directions"], 1):
        print_line(f"{number}. {step['text']}")
    for wish, extra in report["wishes"].items():
        words = {"avoid": "the rooms to avoid cost", "closed": "the rooms never to enter cost"}
        print_line(f"{words.get(wish, f'the wish {wish!r} costs')} {round(extra, 1) + 0.0:+.1f} m")
    for note in report["notes"]:
        print_line(f"note: {note}")


def _draw(legs: list[_Leg], file: Path) -> list[Path]:
    """One picture for each storey, by its name where there are several."""
    from cohelm.plotting import PlanRecord, draw_plan

    files = []
    for number, leg in enumerate(legs, 1):
        name = f"{file.stem}-{number}-{leg.storey.stem}{file.suffix}"
        files.append(file.with_name(name) if len(legs) > 1 else file)
        record = PlanRecord(
            problem=leg.prepared.problem, path=leg.found[0].path, costmap=leg.prepared.costmap,
            places=Places(places=leg.storey.places),
        )  # fmt: skip
        draw_plan(record, files[-1], title=leg.storey.name)
    return files
