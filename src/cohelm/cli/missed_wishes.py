"""Suggest the option that meets wishes which a route misses; a second plan checks it."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Booleans
from cohelm.cli.route_report import FAR, missed_points
from cohelm.errors import PlanningError
from cohelm.geometry import arc_length
from cohelm.messages import Path
from cohelm.planning import GlobalPlanner
from cohelm.planning.planners.wishes import strokes
from cohelm.planning.problem import PreparedProblem

MAX_CELLS = 2e7
"""Search size, cells × layers, above which no second plan is made: it would take seconds."""
CLOSEST = 1000.0
"""λ that passes every point that can be reached: the maximum of ``soft_via``."""


@dataclass(frozen=True)
class OtherPlanner:
    """Planner that may meet the wishes better."""

    build: Callable[[str], GlobalPlanner]
    """Builds it from an option of the command line."""
    closeness: float | None
    """λ of the requested planner; None where its method has none."""


def suggest_option(prepared: PreparedProblem, path: Path, other: OtherPlanner) -> list[str]:
    """Name an option that meets the wishes ``path`` misses, with the change in length, or nothing.

    Where the planner has a closeness, the smallest of two is named: that at which the route past
    all of them becomes the better one, else ``CLOSEST``.
    """
    missed = _missed(prepared, path)
    if not missed.any() or _size(prepared) > MAX_CELLS:
        return []
    problem = prepared.problem

    def planned(option: str) -> Path | None:
        with contextlib.suppress(PlanningError):
            return other.build(option).plan(problem)
        return None

    option = "--method soft_via" if other.closeness is None else _option(CLOSEST)
    found = planned(option)
    served = missed & ~_missed(prepared, found) if found is not None else missed & False
    if found is None or not served.any():
        return []
    if other.closeness is not None:
        enough = math.ceil(1.01 * _break_even(prepared, path, found))
        cheaper = planned(_option(enough)) if other.closeness < enough < CLOSEST else None
        if cheaper is not None and not (served & _missed(prepared, cheaper)).any():
            option, found = _option(enough), cheaper
    longer = found.length - path.length
    price = f"{abs(longer):.1f} m {'longer' if longer >= 0.0 else 'shorter'}"
    names = _names(prepared, found)
    told = " and ".join(names[i] for i in np.flatnonzero(served))
    return [f"with {option} the route comes to {told}, {price}"]


def _option(closeness: float) -> str:
    return f"--set closeness={closeness:g}"


def _size(prepared: PreparedProblem) -> float:
    """Cells of the map × layers of a search for all wishes, one layer per metre of a line."""
    counts = [len(wish.points) for wish in prepared.problem.wishes if wish.kind == "attract"]
    counts += [math.ceil(arc_length(line)[-1]) for line in strokes(prepared.problem)]
    return float(prepared.problem.grid.data.size) * math.prod(n + 1 for n in counts)


def _missed(prepared: PreparedProblem, path: Path) -> Booleans:
    """Mask of points, then of drawn lines, that a route could reach but misses."""
    points = np.zeros(len(path.wishes.closest), dtype=bool)
    points[missed_points(prepared, path)] = True
    return np.concatenate([points, path.wishes.along > FAR])


def _break_even(prepared: PreparedProblem, path: Path, other: Path) -> float:
    """λ at which two routes have the same cost."""
    lengths = np.array([arc_length(line)[-1] for line in strokes(prepared.problem)])
    nearer = float((path.wishes.closest - other.wishes.closest).sum())
    nearer += float(lengths @ (path.wishes.along - other.wishes.along))
    return (other.cost - path.cost) / nearer if nearer > 0.0 else math.inf


def _names(prepared: PreparedProblem, path: Path) -> list[str]:
    """Distances of a route from each point and line, in words."""
    points = [f"{d:.2f} m of point {i}" for i, d in enumerate(path.wishes.closest, start=1)]
    lines = [f"{d:.2f} m of drawn line {i}" for i, d in enumerate(path.wishes.along, start=1)]
    return points + lines
