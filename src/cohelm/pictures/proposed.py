"""Routes to choose from on their map, numbered."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.patheffects import withStroke

from cohelm import messages
from cohelm.geometry import nearest_on_polyline, resample
from cohelm.maps import Places
from cohelm.pictures import canvas
from cohelm.pictures.masks import draw_masks
from cohelm.pictures.plan import draw_points, draw_strokes, draw_zones
from cohelm.planning import RouteProblem

COLOURS = (canvas.ROUTE, "#3d6fb4", "#b5651d", "#8f5cc3", "#2e9e4f", "#c23b3b")
DASHES = ("solid", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)), (0, (8, 3)), (0, (1, 1)))


def draw_routes(
    problem: RouteProblem,
    routes: Sequence[messages.Path],
    file: Path,
    places: Places,
    *,
    title: str = "",
) -> None:
    """Write a picture of routes in their order, each numbered where it is farthest from the others.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    marks = [wish.points for wish in problem.wishes if wish.kind == "attract"]
    shown = np.concatenate([*(route.points for route in routes), *marks])
    figure, axes = canvas.sheet(canvas.around(shown, problem.grid, margin=2.0), title)
    canvas.draw_floor(axes, problem.grid)
    canvas.draw_places(axes, places, np.concatenate([routes[0].points, *marks]))
    draw_masks(axes, problem)
    draw_zones(axes, problem.wishes)
    draw_strokes(axes, problem.wishes)
    for i, route in enumerate(routes):
        colour = COLOURS[i % len(COLOURS)]
        axes.plot(
            *route.points.T, color=colour, linestyle=DASHES[i % len(DASHES)],
            linewidth=2.4 if i == 0 else 1.8, label=f"{i + 1}: {route.length:.1f} m",
            zorder=6 - min(i, 2),
        )  # fmt: skip
        axes.annotate(
            str(i + 1), _apart(route, [each for each in routes if each is not route]),
            ha="center", va="center", fontsize=13, fontweight="bold", color=colour,
            path_effects=[withStroke(linewidth=4.0, foreground="white")], zorder=13,
        )  # fmt: skip
    draw_points(axes, problem.wishes)
    canvas.draw_ends(axes, routes[0].points[0], routes[0].points[-1])
    canvas.draw_scale_bar(axes)
    canvas.draw_legend(figure, axes)
    canvas.save(figure, file)


def _apart(route: messages.Path, others: Sequence[messages.Path]) -> tuple[float, float]:
    """The point of a route that is farthest from all others; its middle where there are none."""
    points = resample(route.points, 0.5)
    if not others:
        return tuple(points[len(points) // 2])
    distance = [min(nearest_on_polyline(o.points, x, y)[1] for o in others) for x, y in points]
    return tuple(points[int(np.argmax(distance))])
