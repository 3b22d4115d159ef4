"""Routes on their map: costs, wishes, footprints; and several routes to choose from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D

from cohelm import messages
from cohelm.arrays import Floats
from cohelm.maps import Places
from cohelm.messages import Wish
from cohelm.planning import Costmap, RouteProblem
from cohelm.planning.costmap.layers.zones import distances_to_area
from cohelm.planning.costmap.patch import INSCRIBED, MAX_GRADED
from cohelm.planning.path_measures import poses_along
from cohelm.plotting import canvas
from cohelm.plotting.masks import draw_masks

COST = "#d9822b"
ZONE = "#a33a2c"
OTHERS = ("#3d6fb4", "#8f5cc3", "#2e9e4f", "#b5651d", "#5b6675")
FOOTPRINTS = 1.0
"""Distance between the drawn outlines along the path, m."""
ROUTE_COLOURS = (canvas.ROUTE, "#3d6fb4", "#b5651d", "#8f5cc3", "#2e9e4f", "#c23b3b")
ROUTE_DASHES = ("solid", (0, (6, 2)), (0, (2, 1.5)), (0, (6, 2, 1, 2)), (0, (8, 3)), (0, (1, 1)))
_ZONE_CELLS = 240
"""Number of cells along the longer side of the window in which a zone is drawn."""


@dataclass(frozen=True)
class PlanRecord:
    """Content of a picture of a plan."""

    problem: RouteProblem
    path: messages.Path
    costmap: Costmap
    places: Places = field(default_factory=Places)
    others: Sequence[messages.Path] = ()
    """Alternatives to the path."""


def draw_plan(record: PlanRecord, file: Path, *, title: str = "") -> None:
    """Draw a path with its wishes, costs, footprints and alternatives.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    problem, path = record.problem, record.path
    wishes = problem.wishes
    shown = [path.points, path.without_wishes, *(other.points for other in record.others)]
    marks = [wish.points for wish in wishes if wish.kind == "attract"]
    zones = [_extent(wish) for wish in wishes if wish.kind != "attract"]
    window = canvas.around(np.concatenate([*shown, *marks, *zones]), problem.grid, margin=2.0)
    figure, axes = canvas.sheet(window, title or _title(path))
    canvas.draw_floor(axes, problem.grid)
    draw_masks(axes, problem)
    draw_costs(axes, record.costmap)
    canvas.draw_places(axes, record.places, np.concatenate([path.points, *marks]))
    draw_zones(axes, wishes)
    draw_strokes(axes, wishes)
    _draw_others(axes, record.others)
    _draw_footprints(axes, problem, path)
    canvas.draw_route(axes, path.points, path.without_wishes)
    _draw_pivots(axes, path)
    draw_points(axes, wishes)
    canvas.draw_ends(axes, path.points[0], path.points[-1])
    canvas.draw_legend(figure, axes)
    canvas.save(figure, file)


def draw_costs(axes: Axes, costmap: Costmap) -> None:
    """Draw graded costs faintly, and cells closed to the chair's centre more strongly."""
    shades = np.array([(*to_rgba(COST)[:3], 0.0)] * 256)
    shades[1 : MAX_GRADED + 1, 3] = np.linspace(0.03, 0.34, MAX_GRADED)
    shades[INSCRIBED:, :] = to_rgba(COST, 0.42)
    window = (*axes.get_xlim(), *axes.get_ylim())
    width, height = costmap.grid.size
    to_map = Affine2D().rotate(costmap.grid.X_MG[2]).translate(*costmap.grid.X_MG[:2])
    costs = np.where(costmap.grid.blocked(), 0, costmap.cost)
    axes.imshow(
        costs, cmap=ListedColormap(shades), vmin=-0.5, vmax=255.5, origin="lower",
        extent=(0.0, width, 0.0, height), transform=to_map + axes.transData,
        interpolation="nearest", zorder=1,
    )  # fmt: skip
    axes.set(xlim=window[:2], ylim=window[2:])
    axes.plot(
        [], [], marker="s", markersize=9, color=to_rgba(COST, 0.3), markeredgecolor="none",
        linestyle="none", label="higher cost, or too close",
    )  # fmt: skip


def draw_points(axes: Axes, wishes: Sequence[Wish]) -> None:
    """Draw the points that attract, numbered in the order given."""
    points = [point for wish in wishes if wish.kind == "attract" for point in wish.points]
    canvas.draw_wishes(axes, np.array(points).reshape(-1, 2))
    if len(points) < 2:
        return
    for number, point in enumerate(points, start=1):
        axes.annotate(
            str(number), tuple(point), xytext=(9, 7), textcoords="offset points", fontsize=10,
            fontweight="bold", color=canvas.WISH, zorder=13,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip


def draw_zones(axes: Axes, wishes: Sequence[Wish]) -> None:
    """Draw the zones to avoid: hatched, with a dashed edge if soft and a solid one if hard."""
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    cell = max(x1 - x0, y1 - y0) / _ZONE_CELLS
    rows, cols = int((y1 - y0) / cell) + 1, int((x1 - x0) / cell) + 1
    x, y = x0 + (np.arange(cols) + 0.5) * cell, y0 + (np.arange(rows) + 0.5) * cell
    labels = set()
    for wish in (wish for wish in wishes if wish.kind == "avoid"):
        corner = np.array([x0, y0])
        distance = distances_to_area(wish.points - corner, cell, slice(0, rows), slice(0, cols))
        if not (distance <= wish.radius).any():
            continue
        low = float(distance.min()) - 1.0
        axes.contourf(
            x, y, distance, levels=[low, wish.radius], colors=[to_rgba(ZONE, 0.12)],
            hatches=["xx" if wish.hard else "//"], zorder=2,
        )  # fmt: skip
        style = "solid" if wish.hard else (0, (4, 2))
        axes.contour(
            x, y, distance, levels=[wish.radius], colors=[ZONE], linewidths=1.3,
            linestyles=[style], zorder=2,
        )  # fmt: skip
        label = "never enter" if wish.hard else "avoid if possible"
        if label not in labels:
            labels.add(label)
            axes.plot([], [], color=ZONE, linestyle=style, linewidth=1.3, label=label)


def draw_strokes(axes: Axes, wishes: Sequence[Wish]) -> None:
    """Draw the strokes of the rider."""
    label = "drawn by the rider"
    for wish in (wish for wish in wishes if wish.kind == "stroke"):
        axes.plot(
            *wish.points.T, color=canvas.WISH, linewidth=7.0, alpha=0.28, label=label,
            solid_capstyle="round", zorder=3,
        )  # fmt: skip
        label = "_"


def _draw_others(axes: Axes, others: Sequence[messages.Path]) -> None:
    for i, other in enumerate(others):
        colour = OTHERS[i % len(OTHERS)]
        axes.plot(
            *other.points.T, color=colour, linewidth=1.5, linestyle=(0, (7, 2, 1, 2)),
            label=f"alternative {i + 2}: {other.length:.1f} m", zorder=4,
        )  # fmt: skip


def _draw_footprints(axes: Axes, problem: RouteProblem, path: messages.Path) -> None:
    """Draw the chair's outline along the path."""
    style = {"facecolor": to_rgba(canvas.CHAIR, 0.05), "linewidth": 0.7, "zorder": 3.8}
    label = "footprint along the route"
    for pose in poses_along(path, FOOTPRINTS):
        outline = canvas.footprint(
            problem.robot, pose, edgecolor=to_rgba(canvas.CHAIR, 0.45), label=label, **style
        )
        axes.add_patch(outline)
        label = "_"


def _draw_pivots(axes: Axes, path: messages.Path) -> None:
    if len(path.pivots):
        axes.plot(
            *path.points[path.pivots].T, marker="D", markersize=6, color=canvas.UNMAPPED,
            markeredgecolor=canvas.INK, linestyle="none", label="turns on the spot", zorder=11,
        )  # fmt: skip


def _extent(wish: Wish) -> Floats:
    """Corners (2, 2) of a box about a zone or a stroke, m."""
    return np.stack([wish.points.min(axis=0) - wish.radius, wish.points.max(axis=0) + wish.radius])


def _title(path: messages.Path) -> str:
    report = path.wishes
    title = f"{path.method}: {path.length:.1f} m"
    if len(report.closest) or len(report.along):
        title += f", {report.extra_length + 0.0:+.1f} m for the wish"
    if len(report.closest):
        title += f", {report.closest.max():.2f} m from it at worst"
    return title
