"""What it would take to serve wishes that a route passes by: planned once more, not guessed."""

from __future__ import annotations

import contextlib
import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Booleans
from cohelm.cli.notes import FAR, missed_points
from cohelm.errors import PlanningError
from cohelm.geometry import arc_length
from cohelm.messages import Path
from cohelm.planning import GlobalPlanner
from cohelm.planning.ground import Ground
from cohelm.planning.wishes import strokes

MOST_CELLS = 2e7
"""Cells, counted once for each layer of the search, above which no other plan is made for the sake
of a sentence: some seconds."""
CLOSEST = 1000.0
"""λ that goes wherever a point can be reached: the greatest that ``soft_via`` takes."""


@dataclass(frozen=True)
class Other:
    """A planner that may serve the wishes better."""

    build: Callable[[str], GlobalPlanner]
    """From the option that says so on the command line."""
    closeness: float | None
    """λ of the planner that was asked for; None where its method has none."""


def closer(ground: Ground, path: Path, other: Other) -> list[str]:
    """How a route would serve the wishes that ``path`` misses, and its price, or nothing.

    Where the planner has a closeness, the least of those tried that serves them is named: that at
    which the route to all of them becomes the better one, else ``CLOSEST``.
    """
    missed = _missed(ground, path)
    if not missed.any() or _size(ground) > MOST_CELLS:
        return []
    problem = dataclasses.replace(ground.problem, kept=None)

    def tried(option: str) -> Path | None:
        with contextlib.suppress(PlanningError):
            return other.build(option).plan(problem)
        return None

    option = "--method soft_via" if other.closeness is None else _option(CLOSEST)
    found = tried(option)
    served = missed & ~_missed(ground, found) if found is not None else missed & False
    if found is None or not served.any():
        return []
    if other.closeness is not None:
        enough = math.ceil(1.01 * _worth(ground, path, found))
        cheaper = tried(_option(enough)) if other.closeness < enough < CLOSEST else None
        if cheaper is not None and not (served & _missed(ground, cheaper)).any():
            option, found = _option(enough), cheaper
    longer = found.length - path.length
    price = f"{abs(longer):.1f} m {'longer' if longer >= 0.0 else 'shorter'}"
    names = _names(ground, found)
    told = " and ".join(names[i] for i in np.flatnonzero(served))
    return [f"with {option} the route comes to {told}, {price}"]


def _option(closeness: float) -> str:
    return f"--set closeness={closeness:g}"


def _size(ground: Ground) -> float:
    """Cells of the map times layers of a search for all wishes, with a piece a metre of a line."""
    counts = [len(wish.points) for wish in ground.problem.wishes if wish.kind == "attract"]
    counts += [math.ceil(arc_length(line)[-1]) for line in strokes(ground.problem)]
    return float(ground.problem.grid.data.size) * math.prod(n + 1 for n in counts)


def _missed(ground: Ground, path: Path) -> Booleans:
    """Which points, then which drawn lines, a route could serve and comes nowhere near to."""
    points = np.zeros(len(path.wishes.closest), dtype=bool)
    points[missed_points(ground, path)] = True
    return np.concatenate([points, path.wishes.along > FAR])


def _worth(ground: Ground, path: Path, other: Path) -> float:
    """λ at which two routes are worth the same."""
    lengths = np.array([arc_length(line)[-1] for line in strokes(ground.problem)])
    nearer = float((path.wishes.closest - other.wishes.closest).sum())
    nearer += float(lengths @ (path.wishes.along - other.wishes.along))
    return (other.cost - path.cost) / nearer if nearer > 0.0 else math.inf


def _names(ground: Ground, path: Path) -> list[str]:
    """What a route comes to, point by point and line by line."""
    points = [f"{d:.2f} m of point {i}" for i, d in enumerate(path.wishes.closest, start=1)]
    lines = [f"{d:.2f} m of drawn line {i}" for i, d in enumerate(path.wishes.along, start=1)]
    return points + lines
