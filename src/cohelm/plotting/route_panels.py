"""Routes of several methods: side by side on their maps, and their errors over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid
from cohelm.plotting import canvas

STYLES = (
    ("#2e9e4f", "solid", 3.2),
    ("#3d6fb4", (0, (5, 2)), 1.5),
    ("#e08a1e", (0, (1, 1.2)), 1.9),
    ("#c23b3b", (0, (6, 1.5, 1, 1.5)), 1.6),
    ("#1d2530", "solid", 1.5),
    ("#8f5cc3", (0, (3, 1, 1, 1, 1, 1)), 1.5),
    ("#0b7a75", (0, (8, 3)), 1.5),
)
"""Colour, dashes and width of the methods in their order; distinct without colour, too."""
COLUMNS, SIDE = 5, 2.5
"""Panels in a row, and their width, inches."""


@dataclass(frozen=True)
class RoutePanel:
    """One scene."""

    title: str
    grid: OccupancyGrid
    point: Floats
    """Click of the rider, (2,), m."""
    lines: Mapping[str, Floats]
    """Method → path (k, 2), m."""


def draw_route_panels(panels: Sequence[RoutePanel], methods: Sequence[str], file: Path) -> None:
    """Write a picture of routes on their maps, one panel for each scene.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    rows, columns = -(-len(panels) // COLUMNS), min(len(panels), COLUMNS)
    tall = max(panel.grid.size[1] / panel.grid.size[0] for panel in panels)
    figure = _figure(columns * SIDE, rows * (SIDE * tall + 0.3))
    all_axes = list(np.ravel(figure.subplots(rows, columns, squeeze=False)))
    for axes, panel in zip(all_axes, panels, strict=False):
        x0, y0, x1, y1 = panel.grid.bounds
        axes.set(xlim=(x0, x1), ylim=(y0, y1), aspect="equal", xticks=[], yticks=[])
        axes.set_title(panel.title, fontsize=9, color=canvas.INK, parse_math=False)
        canvas.draw_floor(axes, panel.grid)
        for method in methods:
            if method in panel.lines:
                axes.plot(*panel.lines[method].T, **_style(methods, method), label=method)
        axes.plot(
            *panel.point, marker="*", color=canvas.WISH, markeredgecolor=canvas.INK,
            markersize=11, linestyle="none", label="the rider's click", zorder=12,
        )  # fmt: skip
    for axes in all_axes[len(panels) :]:
        axes.set_visible(False)
    _legend(figure, all_axes[: len(panels)])
    canvas.save(figure, file)


def draw_error_plot(
    errors: Mapping[str, Sequence[Floats]], methods: Sequence[str], file: Path
) -> None:
    """Write a picture of distances over time: the mean over rides, and the band of half of them.

    Args:
        errors: method → one (k, 2) of (time s, distance m) for each ride; after the
            arrival the last value is kept.
        methods: in the order of their styles.
        file: to be written.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = _figure(7.5, 4.2)
    axes = figure.subplots()
    longest = max(ride[-1, 0] for rides in errors.values() for ride in rides)
    times = np.arange(0.0, longest, 0.1)
    for method in methods:
        if method in errors:
            each = np.array([np.interp(times, *ride.T) for ride in errors[method]])
            style = _style(methods, method)
            axes.plot(times, each.mean(axis=0), **style, label=method)
            low, high = np.quantile(each, [0.25, 0.75], axis=0)
            axes.fill_between(times, low, high, color=style["color"], alpha=0.12, linewidth=0.0)
    axes.set(xlim=(0.0, longest), ylim=(0.0, None))
    axes.set_xlabel("time since the start, s")
    axes.set_ylabel("from the rider's own path at that time, m")
    axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title(
        "mean over the scenes, and the middle half of them", loc="left", fontsize=10,
        color=canvas.INK,
    )  # fmt: skip
    _legend(figure, [axes])
    canvas.save(figure, file)


def _figure(width: float, height: float) -> Figure:
    size = (max(width, 5.0), height + 0.45)
    figure = Figure(figsize=size, dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _style(methods: Sequence[str], method: str) -> dict[str, Any]:
    colour, dashes, width = STYLES[list(methods).index(method) % len(STYLES)]
    return {"color": colour, "linestyle": dashes, "linewidth": width, "zorder": 5}


def _legend(figure: Figure, axes: Sequence[Axes]) -> None:
    """Add one legend for all axes, below them."""
    handles = {
        label: handle
        for each in axes
        for handle, label in zip(*each.get_legend_handles_labels(), strict=True)
    }
    figure.legend(
        handles.values(), handles.keys(), loc="outside lower center", ncols=6, frameon=False,
        fontsize=9, labelcolor=canvas.INK, handlelength=2.6,
    )  # fmt: skip
