"""``cohelm plan``: a route on a map, what the wishes cost, and what else could be taken."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cohelm import plugins
from cohelm.arrays import Floats
from cohelm.cli import wishes, words
from cohelm.cli.closer import Other, closer
from cohelm.cli.plan_report import alternative_table, describe, facts_table, summary
from cohelm.cli.progress import Waiting
from cohelm.cli.report import OUTPUT, write_json
from cohelm.config import override
from cohelm.errors import ConfigError
from cohelm.maps import CostmapFilter, Places, places_beside, read_map
from cohelm.maps.masks import read_crowding, read_mask
from cohelm.planning import GlobalPlanner, RouteProblem
from cohelm.planning.alternatives import Alternative, Differing, alternatives
from cohelm.planning.features import Measuring
from cohelm.planning.ground import Ground, ground_for
from cohelm.planning.route import parameters_of
from cohelm.robots import load_robot


@dataclass(frozen=True)
class Asked:
    """What the options say."""

    map: str
    start: str
    goal: str
    wishes: wishes.Asked
    method: str
    robot: str
    speed: float
    alternatives: int
    settings: tuple[str, ...] = ()
    clearance: float = 0.0
    keepout: tuple[Path, ...] = ()
    speed_mask: tuple[Path, ...] = ()
    crowding: Path | None = None


def plan(asked: Asked, *, json: bool, plot: Path | None) -> int:
    """Plan, print, and draw where asked to.

    Raises:
        CohelmError: if there is no such map, place, robot, planner or route.
    """
    if plot is not None:
        from cohelm.pictures import check_picture  # noqa: PLC0415 # lazy

        check_picture(plot)
    planner = planner_of(asked)
    measuring = Measuring(speed=asked.speed)
    with Waiting("planning"):
        problem, places = problem_of(asked)
        began = time.thread_time()
        found = alternatives(problem, planner, asked.alternatives, Differing(measuring=measuring))
        seconds = time.thread_time() - began
        ground = ground_for(problem, parameters_of(planner))
        report = summary(ground, found, measuring)
        report["notes"] += closer(ground, found[0].path, _other(asked, planner))
    if plot is not None:
        _draw(ground, found, places, plot)
    if json:
        write_json({**report, "timing": {"plan": seconds}})
    else:
        _say(report, plot)
    return 0


def planner_of(asked: Asked) -> GlobalPlanner:
    """The global planner with its settings.

    Raises:
        PluginError, ConfigError: if there is no such planner, or a setting does not fit.
    """
    spec = override({"use": asked.method}, asked.settings)
    if spec["use"] != asked.method:
        raise ConfigError("name the planner with --method", key="use")
    key = "--set" if asked.settings else "--method"
    planner: GlobalPlanner = plugins.build("global_planners", spec, key=key)
    return planner


def _other(asked: Asked, planner: GlobalPlanner) -> Other:
    """What may serve the wishes better: the same with a higher closeness, or ``soft_via``."""
    closeness = getattr(parameters_of(planner), "closeness", None)

    def build(option: str) -> GlobalPlanner:
        if closeness is None:
            return planner_of(replace(asked, method="soft_via", settings=()))
        setting = option.removeprefix("--set ")
        return planner_of(replace(asked, settings=(*asked.settings, setting)))

    return Other(build=build, closeness=closeness)


def problem_of(asked: Asked) -> tuple[RouteProblem, Places]:
    """The problem, and the places that the map names.

    Raises:
        CohelmError: if a file, a place or an option does not say what it must.
    """
    wanted = wishes.wishes_of(asked.wishes)
    robot = load_robot(asked.robot)
    grid, places = read_map(asked.map), places_beside(asked.map)
    masks: list[CostmapFilter] = [read_mask(file, type="keepout") for file in asked.keepout]
    masks += [read_mask(file, type="speed_percent") for file in asked.speed_mask]
    problem = RouteProblem(
        grid=grid,
        robot=robot,
        start=_point(asked.start, "--start", places),
        goal=_point(asked.goal, "--goal", places),
        wishes=wanted,
        filters=tuple(masks),
        crowding=None if asked.crowding is None else read_crowding(asked.crowding),
        clearance=asked.clearance,
    )
    return problem, places


def _draw(ground: Ground, found: tuple[Alternative, ...], places: Places, file: Path) -> None:
    from cohelm.pictures import PlanRecord, draw_plan  # noqa: PLC0415 # lazy

    record = PlanRecord(
        problem=ground.problem,
        path=found[0].path,
        costmap=ground.costmap,
        places=places,
        others=[each.path for each in found[1:]],
    )
    draw_plan(record, file)


def _say(report: dict[str, Any], plot: Path | None) -> None:
    OUTPUT.print(facts_table(report))
    if len(report["alternatives"]) > 1:
        OUTPUT.print(alternative_table(report))
    for line in describe(report):
        OUTPUT.print(line, markup=False, soft_wrap=True)
    if plot is not None:
        OUTPUT.print(f"written: {plot}", markup=False, soft_wrap=True)


def _point(text: str, key: str, places: Places) -> Floats:
    spot = words.place(text, key)
    return places.find(spot).point if isinstance(spot, str) else np.array(spot)
