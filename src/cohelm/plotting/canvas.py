"""Parts of every picture: figure with metre axes, floor, legend, colours; writing files."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap, ListedColormap, to_rgba
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MultipleLocator
from matplotlib.transforms import Affine2D

from cohelm.arrays import Floats
from cohelm.errors import ConfigError
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid, Places
from cohelm.robots import Robot
from cohelm.simulation.sensors.floor_relief import FLAT, FloorCells, FloorRelief, floor_cells

INK = "#1d2530"
FREE = "#ffffff"
WALL = "#5b6675"
UNKNOWN = "#e6e9ed"
ROUTE = "#0b7a75"
PLAIN_ROUTE = "#7b8794"
PERSON = "#3d5a98"
SPACE = "#8f7cc3"
GROUP = "#5a3e9e"
HULL = (0, (5, 2))
"""Dashes of a group's outline."""
CHAIR = "#1d2530"
WISH = "#c2185b"
UNMAPPED = "#b5651d"
LOWER_FLOOR, HIGHER_FLOOR, DARK_FLOOR = "#3b6fb6", "#c79a3a", "#3a3a3a"
STRONGLY_TINTED = 0.3
"""Height from which floor has its full tint, m."""
ETA = LinearSegmentedColormap.from_list("eta", ["#ffb238", "#e0523f", "#8e2464", "#2b1450"])
"""Authority from the chair (light) to the rider (dark); luminance falls monotonically."""

LARGEST, SMALLEST = np.array([11.0, 8.0]), np.array([6.4, 3.0])
"""Width and height of the shown floor, inches."""
LEFT, RIGHT, BOTTOM, TOP = 0.62, 0.25, 0.5, 0.5
"""Margins of the figure: tick labels left and below, title above; inches."""
GRID_STEPS = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""Spacings of the metre grid, m."""
GRID_SPACING = 0.5
"""Minimum spacing of grid lines in the picture, inches."""

NAME_SIZE = 7.5
"""Font size of the names of places, points."""

FORMATS = (".png", ".svg", ".pdf", ".jpg", ".jpeg")


def check_picture(file: Path, key: str = "--plot") -> None:
    """Refuse a file that cannot be written as a picture, before the work.

    Raises:
        ConfigError: naming the option and what to do.
    """
    if file.suffix.lower() not in FORMATS:
        raise ConfigError(f"{file}: write a picture as {', '.join(FORMATS)}", key=key)
    check_folder(file, key)


def check_folder(file: Path, key: str) -> None:
    """Refuse a file that cannot be written, is a folder, or lies in a folder that does not exist.

    Raises:
        ConfigError: naming the option and what to do.
    """
    try:
        if file.is_dir():
            raise ConfigError(f"{file} is a folder; name a file in it", key=key)
        if not file.absolute().parent.is_dir():
            raise ConfigError(f"no folder {file.absolute().parent}", key=key)
    except OSError as cause:
        raise not_written(file, key, cause) from None
    new = not os.path.lexists(file)
    try:
        with file.open("ab"):
            pass
    except OSError as cause:
        raise not_written(file, key, cause) from None
    if new:
        file.unlink()


def not_written(file: Path, key: str, cause: OSError) -> ConfigError:
    """Error for a file that cannot be written."""
    return ConfigError(f"{file} cannot be written ({cause.strerror or cause})", key=key)


def sheet(
    window: tuple[float, float, float, float], title: str, width: float = LARGEST[0]
) -> tuple[Figure, Axes]:
    """Make a figure whose axes show ``window`` (x_min, y_min, x_max, y_max), m, to scale.

    The axes are labelled in metres of the map frame, with a faint grid. A long and narrow window
    is widened about its middle. ``width`` is the maximum width of the axes, inches.
    """
    low, high = np.array(window[:2]), np.array(window[2:])
    extent = np.maximum(high - low, 1e-3)
    scale = ((width, LARGEST[1]) / extent).min()  # inches per metre
    size = np.maximum(extent * scale, SMALLEST)
    middle, half = (low + high) / 2.0, size / scale / 2.0
    whole = size + np.array([LEFT + RIGHT, BOTTOM + TOP])
    figure = Figure(figsize=tuple(whole), dpi=110, facecolor="white")
    FigureCanvasAgg(figure)
    corner = np.array([LEFT, BOTTOM])
    axes = figure.add_axes((*(corner / whole), *(size / whole)), facecolor=UNKNOWN)
    axes.set(
        xlim=(middle[0] - half[0], middle[0] + half[0]),
        ylim=(middle[1] - half[1], middle[1] + half[1]),
        aspect="equal", xlabel="x, m", ylabel="y, m",
    )  # fmt: skip
    step = next((each for each in GRID_STEPS if each * scale >= GRID_SPACING), GRID_STEPS[-1])
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(MultipleLocator(step))
    axes.tick_params(labelsize=8, colors=INK, length=3)
    axes.grid(color=PLAIN_ROUTE, linewidth=0.5, alpha=0.35)
    axes.set_axisbelow(True)
    for spine in axes.spines.values():
        spine.set(color=PLAIN_ROUTE, linewidth=0.8)
    axes.set_title(title, parse_math=False, loc="left", fontsize=11, color=INK, pad=8)
    return figure, axes


def around(points: Floats, grid: OccupancyGrid, margin: float) -> tuple[float, float, float, float]:
    """Window about points (k, 2) with a margin, clipped to the grid, m."""
    bounds = grid.bounds
    low, high = points.min(axis=0) - margin, points.max(axis=0) + margin
    return (
        max(float(low[0]), bounds[0]),
        max(float(low[1]), bounds[1]),
        min(float(high[0]), bounds[2]),
        min(float(high[1]), bounds[3]),
    )


def draw_floor(
    axes: Axes,
    grid: OccupancyGrid,
    world: OccupancyGrid | None = None,
    relief: FloorRelief = FLAT,
) -> None:
    """Draw the map, unknown cells grey, obstacles that only ``world`` has in their own colour.

    Floor that is not level is tinted, the more the farther it is from height 0.
    """
    kind = np.where(grid.data < 0, 2, np.where(grid.occupied(), 1, 0))
    if world is not None:
        kind = np.where(world.occupied() & ~grid.occupied(), 3, kind)
    width, height = grid.size
    to_map = Affine2D().rotate(grid.X_MG[2]).translate(grid.X_MG[0], grid.X_MG[1])
    window = (*axes.get_xlim(), *axes.get_ylim())
    axes.imshow(
        kind,
        cmap=ListedColormap([FREE, WALL, UNKNOWN, UNMAPPED]),
        vmin=-0.5,
        vmax=3.5,
        origin="lower",
        extent=(0.0, width, 0.0, height),
        transform=to_map + axes.transData,
        interpolation="nearest",
        zorder=0,
    )
    _tint_heights(axes, floor_cells(relief, grid), to_map)
    axes.set(xlim=window[:2], ylim=window[2:])


def _tint_heights(axes: Axes, floor: FloorCells | None, to_map: Affine2D) -> None:
    """Tint floor that lies lower or higher, or that no sensor sees, and name the tints."""
    if floor is None:
        return
    tint = np.zeros((*floor.heights.shape, 4))
    kinds = {
        LOWER_FLOOR: (floor.heights < 0.0, "lower floor"),
        HIGHER_FLOOR: (floor.heights > 0.0, "higher floor"),
        DARK_FLOOR: (floor.dark, "floor that returns nothing"),
    }
    strength = np.clip(np.abs(floor.heights) / STRONGLY_TINTED, 0.25, 1.0)
    for colour, (where, label) in kinds.items():
        if where.any():
            tint[where] = to_rgba(colour)
            tint[where, 3] = 0.5 * np.where(floor.dark, 1.0, strength)[where]
            axes.plot([], [], "s", color=to_rgba(colour, 0.5), markersize=9, label=label)
    width, height = floor.grid.size
    axes.imshow(
        tint, origin="lower", extent=(0.0, width, 0.0, height), interpolation="nearest",
        transform=to_map + axes.transData, zorder=0.3,
    )  # fmt: skip


def draw_places(axes: Axes, places: Places, avoid: Floats) -> None:
    """Write the names of places in view, moved away from the points ``avoid`` (k, 2), m."""
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    per_metre = (
        axes.get_position().width * axes.figure.get_figure(True).get_figwidth() * 72.0 / (x1 - x0)
    )
    for place in places:
        x, y = place.point
        if x0 + 1.0 < x < x1 - 1.0 and y0 + 0.4 < y < y1 - 0.4:
            offset = _free_offset((avoid - place.point) * per_metre, len(place.name))
            axes.annotate(
                place.name, (x, y), xytext=tuple(offset), textcoords="offset points",
                parse_math=False, ha="center", va="center", fontsize=NAME_SIZE,
                style="italic", color="#6b7686",
                path_effects=[withStroke(linewidth=2.0, foreground="white")], zorder=3.5,
            )  # fmt: skip


def _free_offset(marks: Floats, letters: int) -> Floats:
    """First of several offsets at which a name covers the fewest ``marks`` (k, 2), points."""
    box = np.array([0.3 * NAME_SIZE * letters + 8.0, 0.6 * NAME_SIZE + 6.0])
    up, aside = np.array([0.0, 1.0]), np.array([1.0, 0.0])
    tries = [0.0 * up]
    tries += [side * length for length in (16.0, 30.0) for side in (-up, up)]
    tries += [side * length * box[0] for length in (1.0, 1.5) for side in (-aside, aside)]
    covered = [(np.abs(marks - offset) < box).all(axis=1).sum() for offset in tries]
    return tries[int(np.argmin(covered))]


def draw_scale_bar(axes: Axes) -> None:
    """Draw a bar of 1, 2, 5, 10, 20 or 50 m in the lower left corner."""
    x0, x1 = axes.get_xlim()
    y0, y1 = axes.get_ylim()
    length = max([m for m in (1, 2, 5, 10, 20, 50) if m <= 0.25 * (x1 - x0)], default=1)
    x, y = x0 + 0.02 * (x1 - x0), y0 + 0.035 * (y1 - y0)
    style: dict[str, Any] = {"solid_capstyle": "butt", "zorder": 20}
    axes.plot([x, x + length], [y, y], color="white", linewidth=7.0, **style)
    axes.plot([x, x + length], [y, y], color=INK, linewidth=3.0, **style)
    axes.plot([x + length / 2, x + length], [y, y], color="white", linewidth=1.4, **style)
    axes.annotate(
        f"{length} m",
        (x + length / 2, y),
        xytext=(0, 5),
        textcoords="offset points",
        ha="center",
        fontsize=9,
        color=INK,
        bbox={
            "boxstyle": "round,pad=0.12",
            "facecolor": "white",
            "edgecolor": "none",
            "alpha": 0.8,
        },
        zorder=20,
    )


def footprint(robot: Robot, pose: Floats, **style: Any) -> Polygon:
    """The robot's footprint at a pose, to be added to axes."""
    return Polygon(transform(pose, robot.outline), closed=True, **style)


def draw_ends(axes: Axes, start: Floats, goal: Floats) -> None:
    """Mark start and goal."""
    axes.plot(
        *start[:2], marker="o", color=INK, markerfacecolor="white", markersize=8,
        markeredgewidth=1.8, linestyle="none", label="start", zorder=12,
    )  # fmt: skip
    axes.plot(
        *goal[:2], marker="X", color=INK, markerfacecolor=ROUTE, markersize=11,
        markeredgewidth=1.2, linestyle="none", label="goal", zorder=12,
    )  # fmt: skip


def draw_wishes(axes: Axes, points: Floats) -> None:
    """Mark the points (w, 2) that attract the route."""
    if len(points):
        axes.plot(
            *points.T, marker="*", color=WISH, markeredgecolor=INK, markersize=15,
            linestyle="none", label="wish of the rider", zorder=12,
        )  # fmt: skip


def draw_route(axes: Axes, points: Floats, plain: Floats) -> None:
    """Draw a route (k, 2), and the one without wishes (j, 2) if it differs."""
    if points.shape != plain.shape or not np.allclose(points, plain, atol=1e-6):
        axes.plot(
            *plain.T, color=PLAIN_ROUTE, linewidth=1.6, linestyle=(0, (1, 1.6)),
            label="route without the wish", zorder=4,
        )  # fmt: skip
    axes.plot(*points.T, color=ROUTE, linewidth=1.8, linestyle=(0, (5, 2)), label="route", zorder=5)


def draw_legend(figure: Figure, axes: Axes, drop: float = 0.0) -> None:
    """Add a legend below the axes, with ``drop`` inches between; the figure grows."""
    handles, labels = axes.get_legend_handles_labels()
    box, (width, height) = axes.get_position(), figure.get_size_inches()
    style: dict[str, Any] = {
        "loc": "lower left", "bbox_to_anchor": (box.x0, 0.0), "frameon": False, "fontsize": 9,
        "handlelength": 2.4, "columnspacing": 1.6, "borderaxespad": 0.4, "labelcolor": INK,
    }  # fmt: skip
    for columns in range(len(labels), 0, -1):
        legend = figure.legend(handles, labels, ncols=columns, **style)
        taken = legend.get_window_extent()
        if taken.width <= box.width * width * figure.dpi or columns == 1:
            break
        legend.remove()
    lift = drop + float(taken.height) / figure.dpi
    taller = height + lift
    for each in figure.axes:
        x, y, wide, high = each.get_position().bounds
        each.set_position((x, (y * height + lift) / taller, wide, high * height / taller))
    figure.set_size_inches(width, taller)


def save(figure: Figure, file: Path) -> None:
    """Write a figure; equal figures give equal bytes."""
    check_folder(file, "--plot")
    metadata = {".png": {"Software": None}, ".svg": {"Date": None}, ".pdf": {"CreationDate": None}}
    try:
        with rc_context({"svg.hashsalt": "cohelm"}):  # else ids in the file are random
            figure.savefig(file, metadata=metadata.get(file.suffix.lower()))
    except OSError as cause:
        raise not_written(file, "--plot", cause) from None
