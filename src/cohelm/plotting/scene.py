"""Picture of a scene at its start: floor, chair, route, and paths of the pedestrians.

Routes are drawn on their map with costs, wishes and footprints, filter masks with hatched keepout
zones and tinted speed zones.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, to_rgba
from matplotlib.patches import Circle
from matplotlib.patheffects import withStroke
from matplotlib.transforms import Affine2D, Transform

from cohelm import messages
from cohelm.arrays import Booleans, Floats
from cohelm.maps import CostmapFilter, OccupancyGrid, Places
from cohelm.maps.masks import CLOSED
from cohelm.messages import Wish
from cohelm.planning import Costmap, RouteProblem
from cohelm.planning.costmap.layers.zones import distances_to_area
from cohelm.planning.costmap.patch import INSCRIBED, MAX_GRADED
from cohelm.planning.path_measures import poses_along
from cohelm.plotting import canvas
from cohelm.robots import Robot
from cohelm.simulation import Crowd, FloorRelief

KEEPOUT = "#6a3d9a"
SLOW = "#2f7fc1"
_CELLS = 500
"""Number of cells along the longer side in which a keepout zone is outlined."""


def draw_masks(axes: Axes, problem: RouteProblem) -> None:
    """Draw the keepout zones and the speed zones of a problem."""
    window = (*axes.get_xlim(), *axes.get_ylim())
    closed, shares = False, list[float]()
    for mask in problem.filters:
        if mask.type == "keepout":
            closed = _draw_closed(axes, mask) or closed
        else:
            shares += _draw_slow(axes, mask, problem.robot.max_speed)
    axes.set(xlim=window[:2], ylim=window[2:])
    if closed:
        axes.fill(
            [], [], facecolor=to_rgba(KEEPOUT, 0.12), edgecolor=KEEPOUT, hatch="\\\\\\\\",
            label="keepout zone",
        )  # fmt: skip
    if shares:
        low, high = (f"{100.0 * share:.0f}" for share in (min(shares), max(shares)))
        label = f"slow: {low if low == high else f'{low} to {high}'} % of full speed"
        axes.fill([], [], facecolor=to_rgba(SLOW, 0.22), edgecolor=SLOW, label=label)


def _draw_closed(axes: Axes, mask: CostmapFilter) -> bool:
    """Draw the cells where a mask is closed; return True if there are any."""
    closed = _numbers(mask) >= CLOSED
    if not closed.any():
        return False
    step = math.ceil(max(closed.shape) / _CELLS)
    coarse = np.pad(_pooled(closed, step), 1).astype(float)
    side = step * mask.mask.resolution
    rows, cols = coarse.shape
    x, y = (np.arange(cols) - 0.5) * side, (np.arange(rows) - 0.5) * side
    style: dict[str, Any] = {
        "levels": [0.5, 1.5],
        "transform": _to_map(mask) + axes.transData,
        "zorder": 2,
    }
    areas = axes.contourf(
        x, y, coarse, colors=[to_rgba(KEEPOUT, 0.12)], hatches=["\\\\\\\\"], **style
    )
    areas.set_edgecolor(to_rgba(KEEPOUT, 0.6))
    areas.set_linewidth(0.0)
    axes.contour(x, y, coarse, colors=[KEEPOUT], linewidths=1.2, **style)
    return True


def _draw_slow(axes: Axes, mask: CostmapFilter, full_speed: float) -> list[float]:
    """Draw the cells where a mask limits the speed, darker if slower; return the limits, 0…1."""
    shares = _numbers(mask) / (100.0 if mask.type == "speed_percent" else full_speed)
    limited = (shares > 0.0) & (shares < 1.0)
    if not limited.any():
        return []
    tint = np.zeros((*shares.shape, 4))
    tint[..., :3] = to_rgba(SLOW)[:3]
    tint[..., 3] = np.where(limited, 0.28 - 0.2 * shares, 0.0)
    width, height = mask.mask.size
    axes.imshow(
        tint, origin="lower", extent=(0.0, width, 0.0, height), interpolation="nearest",
        transform=_to_map(mask) + axes.transData, zorder=0.5,
    )  # fmt: skip
    return [float(shares[limited].min()), float(shares[limited].max())]


def _numbers(mask: CostmapFilter) -> Floats:
    """Numbers of the mask (rows, cols); 0 where it has no effect."""
    numbers: Floats = np.where(
        mask.mask.data < 0, 0.0, mask.base + mask.multiplier * mask.mask.data
    )
    return numbers


def _pooled(cells: Booleans, step: int) -> Booleans:
    """Pool cells: True where any cell of a square of ``step`` cells is set."""
    rows, cols = (math.ceil(n / step) * step for n in cells.shape)
    padded = np.zeros((rows, cols), dtype=bool)
    padded[: cells.shape[0], : cells.shape[1]] = cells
    squares = padded.reshape(rows // step, step, cols // step, step)
    return np.asarray(squares.any(axis=(1, 3)))


def _to_map(mask: CostmapFilter) -> Transform:
    x, y, heading = mask.mask.X_MG.tolist()
    return Affine2D().rotate(heading).translate(x, y)


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


SMALL = 0.5
"""Scale of the figure; the picture is one of many."""
STANDING = 0.5
"""A pedestrian whose path is shorter than this stands, m."""


class SceneRecord(Protocol):
    """Content of a picture of a scene; k points of the route, w wished points."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""

    @property
    def world(self) -> OccupancyGrid:
        """True obstacles at any time, on the same cells."""

    @property
    def relief(self) -> FloorRelief:
        """Heights of the floor."""

    @property
    def robot(self) -> Robot:
        """The chair."""

    @property
    def start(self) -> Floats:
        """X_MR (3,)."""

    @property
    def route(self) -> messages.Path:
        """Planned on the map alone."""

    @property
    def rider_routes(self) -> Sequence[Floats]:
        """Routes (k, 2) that the rider has in mind and the chair does not know."""

    @property
    def wishes(self) -> Sequence[Wish]:
        """The rider's, of the route."""

    @property
    def crowd(self) -> Crowd:
        """The people at the beginning."""


def draw_scene(scene: SceneRecord, file: Path, title: str = "") -> None:
    """Write a small picture of a scene.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    points = [
        scene.route.points,
        *scene.rider_routes,
        scene.start[None, :2],
        *paths_of(scene.crowd),
    ]
    window = canvas.around(np.concatenate(points), scene.grid, margin=1.5)
    figure, axes = canvas.sheet(window, title)
    canvas.draw_floor(axes, scene.grid, scene.world, scene.relief)
    draw_zones(axes, scene.wishes)
    draw_strokes(axes, scene.wishes)
    for line in scene.rider_routes:
        axes.plot(*line.T, color=canvas.PLAIN_ROUTE, linewidth=1.4, zorder=4)
    canvas.draw_route(axes, scene.route.points, scene.route.without_wishes)
    _draw_paths(axes, scene.crowd)
    attract = [wish.points for wish in scene.wishes if wish.kind == "attract"]
    canvas.draw_wishes(axes, np.concatenate([np.empty((0, 2)), *attract]))
    axes.add_patch(
        canvas.footprint(
            scene.robot, scene.start, facecolor="white", edgecolor=canvas.CHAIR, linewidth=1.6,
            zorder=11,
        )
    )  # fmt: skip
    canvas.draw_ends(axes, scene.start, scene.route.points[-1])
    figure.set_size_inches(*(SMALL * figure.get_size_inches()))
    canvas.save(figure, file)


def paths_of(crowd: Crowd) -> list[Floats]:
    """Path (k, 2) of each present pedestrian; closed where it is a loop."""
    paths = []
    for i in np.flatnonzero(crowd.there):
        at = crowd.position[i]
        ahead = crowd.waypoints[i, crowd.target[i] :]
        line = np.vstack([at, ahead[np.isfinite(ahead).all(axis=1)]])
        if np.hypot(*(line - at).T).max() < STANDING:
            line = line[:1]
        paths.append(np.vstack([line, at]) if crowd.loop[i] and len(line) > 1 else line)
    return paths


def _draw_paths(axes: Axes, crowd: Crowd) -> None:
    """Draw each person's path, dotted with an arrow head, and the body."""
    for line, radius in zip(paths_of(crowd), crowd.radius[crowd.there], strict=True):
        axes.plot(
            *line.T, color=canvas.PERSON, linewidth=1.1, linestyle=(0, (1, 2)), alpha=0.8, zorder=6
        )
        if len(line) > 1:
            axes.annotate(
                "", xy=tuple(line[-1]), xytext=tuple(_before(line)),
                arrowprops={"arrowstyle": "-|>", "color": canvas.PERSON, "linewidth": 1.1},
                zorder=7,
            )  # fmt: skip
        axes.add_patch(
            Circle(
                (line[0, 0], line[0, 1]), radius, facecolor=canvas.PERSON, edgecolor="white",
                linewidth=0.6, zorder=8,
            )
        )  # fmt: skip


def _before(line: Floats) -> Floats:
    """A point (2,) shortly before the end of a line (k, 2)."""
    away = line[-2] - line[-1]
    return np.asarray(line[-1] + away / max(float(np.hypot(*away)), 1e-9) * 0.5)
