"""``cohelm plan``: a route on a map, and what the wishes cost."""

from __future__ import annotations

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table
from rich.text import Text

from cohelm import messages, plugins
from cohelm.cli import words
from cohelm.cli.report import OUTPUT, versions, write_json
from cohelm.maps import Places, places_beside, read_map
from cohelm.messages import Wish
from cohelm.planning import RouteProblem
from cohelm.robots import load_robot


@dataclass(frozen=True)
class Asked:
    """What the options say."""

    map: str
    start: str
    goal: str
    prefer: tuple[str, ...]
    method: str
    robot: str


def plan(asked: Asked, *, json: bool, plot: Path | None) -> int:
    """Plan, print, and draw where asked to.

    Raises:
        CohelmError: if there is no such map, place, robot, planner or route.
    """
    if plot is not None:
        from cohelm.pictures import check_picture  # noqa: PLC0415 # lazy

        check_picture(plot)
    planner = plugins.build("global_planners", asked.method, key="--method")
    robot = load_robot(asked.robot)
    grid, places = read_map(asked.map), places_beside(asked.map)
    prefer = np.array([words.point(text, "--prefer") for text in asked.prefer]).reshape(-1, 2)
    problem = RouteProblem(
        grid=grid,
        robot=robot,
        start=_point(asked.start, "--start", places),
        goal=_point(asked.goal, "--goal", places),
        wishes=tuple(Wish(points=point[None]) for point in prefer),
    )
    began = time.thread_time()
    route = planner.plan(problem)
    seconds = time.thread_time() - began
    if plot is not None:
        from cohelm.pictures import draw_plan  # noqa: PLC0415 # lazy

        draw_plan(grid, route, prefer, plot, places)
    report = summary(route, robot.name, seconds)
    if json:
        write_json(report)
    else:
        OUTPUT.print(_table(report))
    return 0


def summary(route: messages.Path, robot: str, seconds: float) -> dict[str, Any]:
    """What ``--json`` says."""
    closest = route.wishes.closest
    return {
        "length": route.length,
        "cost": route.cost,
        "points": route.points.tolist(),
        "closest_to_preference": float(closest.max()) if len(closest) else None,
        "closest_to_each": closest.tolist(),
        "extra_length": route.wishes.extra_length,
        "extra_cost": route.wishes.extra_cost,
        "method": route.method,
        "robot": robot,
        "versions": versions(),
        "timing": {"plan": seconds},
    }


def _point(text: str, key: str, places: Places) -> Any:
    spot = words.place(text, key)
    return places.find(spot).point if isinstance(spot, str) else np.array(spot)


def _table(report: dict[str, Any]) -> Table:
    table = Table(title=Text(f"{report['method']}, {report['robot']}"), header_style="dim")
    table.add_column("what")
    table.add_column("value", justify="right")
    table.add_column("unit", style="dim")
    keys = ["length", "cost"]
    if report["closest_to_preference"] is not None:
        keys += ["closest_to_preference", "extra_length"]
    for key in keys:
        table.add_row(key, f"{report[key]:.2f}", "m")
    table.add_row("points", str(len(report["points"])), "")
    return table
