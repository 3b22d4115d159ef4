"""``cohelm plan``: plan a route on a map, with the cost of each wish and alternatives."""

from __future__ import annotations

import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.cli import parsing
from cohelm.cli.missed_wishes import OtherPlanner, suggest_option
from cohelm.cli.progress import waiting
from cohelm.cli.report import OUTPUT, print_line, write_json
from cohelm.cli.requests import RouteRequest
from cohelm.cli.route_report import alternative_table, describe, facts_table, summary
from cohelm.config import override
from cohelm.errors import ConfigError
from cohelm.maps import (
    CostmapFilter,
    FilterInfo,
    FilterType,
    Places,
    places_beside,
    read_filter_info,
    read_map,
)
from cohelm.maps.masks import read_crowding, read_mask
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives.alternatives import (
    Alternative,
    AlternativeCriteria,
    find_alternatives,
)
from cohelm.planning.alternatives.features import FeatureParameters
from cohelm.planning.planners.route import parameters_of
from cohelm.planning.problem import PreparedProblem, prepare
from cohelm.robots import load_robot


def plan(request: RouteRequest) -> int:
    """Plan on a map or in a building, print, and draw if requested; returns 0.

    Raises:
        CohelmError: if there is no such map, place, robot, planner or route.
    """
    if request.plot is not None:
        from cohelm.plotting import check_picture

        check_picture(request.plot)
    planner = planner_of(request)
    if Path(request.map).is_dir():
        from cohelm.cli import building_route

        return building_route.plan_in_building(request, planner)
    measuring = FeatureParameters(speed=request.speed)
    with waiting("planning"):
        problem, places = problem_of(request)
        began = time.thread_time()
        found = find_alternatives(
            problem, planner, request.alternatives, AlternativeCriteria(measuring=measuring)
        )
        seconds = time.thread_time() - began
        prepared = prepare(problem, parameters_of(planner))
        report = summary(prepared, found, measuring)
        report["notes"] += suggest_option(prepared, found[0].path, _other_planner(request, planner))
    if request.plot is not None:
        _draw(prepared, found, places, request.plot)
    if request.json:
        write_json({**report, "timing": {"plan": seconds}})
    else:
        _print(report, request.plot)
    return 0


def planner_of(request: RouteRequest) -> GlobalPlanner:
    """Build the global planner with its settings.

    Raises:
        PluginError, ConfigError: if there is no such planner, or a setting does not fit.
    """
    spec = override({"use": request.method}, request.settings)
    if spec["use"] != request.method:
        raise ConfigError("name the planner with --method", key="use")
    key = "--set" if request.settings else "--method"
    planner: GlobalPlanner = plugins.build("global_planners", spec, key=key)
    return planner


def _other_planner(request: RouteRequest, planner: GlobalPlanner) -> OtherPlanner:
    """A planner that may meet the wishes better: a higher closeness, or ``soft_via``."""
    closeness = getattr(parameters_of(planner), "closeness", None)

    def build(option: str) -> GlobalPlanner:
        if closeness is None:
            return planner_of(replace(request, method="soft_via", settings=()))
        setting = option.removeprefix("--set ")
        return planner_of(replace(request, settings=(*request.settings, setting)))

    return OtherPlanner(build=build, closeness=closeness)


def problem_of(request: RouteRequest) -> tuple[RouteProblem, Places]:
    """Build the planning problem; also returns the named places of the map.

    Raises:
        CohelmError: if a file, a place or an option is not valid.
    """
    robot = load_robot(request.robot)
    grid, places = read_map(request.map), places_beside(request.map)
    wishes = parsing.wishes_of(request, places)
    problem = RouteProblem(
        grid=grid,
        robot=robot,
        start=_point(request.start, "--start", places),
        goal=_point(request.goal, "--goal", places),
        wishes=wishes,
        filters=_masks(request),
        crowding=None if request.crowding is None else read_crowding(request.crowding),
        clearance=request.clearance,
    )
    return problem, places


def _masks(request: RouteRequest) -> tuple[CostmapFilter, ...]:
    """Read the masks, each with Nav2's description of its kind if one is given."""
    closed = _info(request, "keepout") if request.keepout else None
    slow = _info(request, "speed_percent", "speed_absolute") if request.speed_mask else None
    if request.filter_info and closed is None and slow is None:
        problem = "describes no mask that --keepout or --speed-mask names"
        raise ConfigError(problem, file=request.filter_info[0], key="--filter-info")
    keepout = [read_mask(file, type="keepout", info=closed) for file in request.keepout]
    speed = [
        read_mask(
            file,
            type=None if slow else "speed_percent",
            base=request.speed_base,
            multiplier=request.speed_multiplier,
            info=slow,
        )
        for file in request.speed_mask
    ]
    return (*keepout, *speed)


def _info(request: RouteRequest, *types: FilterType) -> FilterInfo | None:
    """The description of a mask of these types among the files of ``--filter-info``."""
    infos = [read_filter_info(file, types=types) for file in request.filter_info]
    found = [info for info in infos if info is not None]
    if len(found) > 1:
        raise ConfigError("several describe the same kind of mask", key="--filter-info")
    return found[0] if found else None


def _draw(
    prepared: PreparedProblem, found: tuple[Alternative, ...], places: Places, file: Path
) -> None:
    from cohelm.plotting import PlanRecord, draw_plan

    record = PlanRecord(
        problem=prepared.problem,
        path=found[0].path,
        costmap=prepared.costmap,
        places=places,
        others=[each.path for each in found[1:]],
    )
    draw_plan(record, file)


def _print(report: dict[str, Any], plot: Path | None) -> None:
    OUTPUT.print(facts_table(report))
    if len(report["alternatives"]) > 1:
        OUTPUT.print(alternative_table(report))
    for line in describe(report):
        print_line(line)
    if plot is not None:
        print_line(f"written: {plot}")


def _point(text: str, key: str, places: Places) -> Floats:
    spot = parsing.place(text, key)
    return places.find(spot).point if isinstance(spot, str) else np.array(spot)
