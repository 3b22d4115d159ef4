"""Many values by who they belong to: every one a mark, the median a bar."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Booleans, Floats
from cohelm.pictures import canvas

_ROW, _WIDTH = 0.26, 4.6  # of a planner and of a panel, inches
_SPREAD = 0.28  # of the marks about their row's middle, rows


@dataclass(frozen=True)
class Strip:
    """What belongs to one name."""

    values: Floats
    """(k,); NaN are left out."""
    bad: Booleans
    """(k,): drawn as crosses."""


@dataclass(frozen=True)
class StripPanel:
    """One quantity in one case; the names from top to bottom."""

    title: str
    axis: str
    strips: Mapping[str, Strip]


def draw_strips(rows: Sequence[Sequence[StripPanel]], file: Path, bad: str) -> None:
    """Write a picture of strips: a row of panels for each case.

    Args:
        rows: panels, equally many in each row.
        file: to be written.
        bad: what a cross means.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    heights = [max(len(panel.strips) for panel in row) * _ROW + 0.75 for row in rows]
    figure = Figure(
        figsize=(_WIDTH * len(rows[0]) + 0.8, sum(heights) + 0.2),
        dpi=90, facecolor="white", layout="constrained",
    )  # fmt: skip
    FigureCanvasAgg(figure)
    all_axes = figure.subplots(
        len(rows), len(rows[0]), squeeze=False, height_ratios=heights, sharex="col", sharey="row"
    )
    for row, axes_row in zip(rows, all_axes, strict=True):
        for panel, axes in zip(row, axes_row, strict=True):
            _draw(axes, panel)
    figure.supxlabel(f"a dot: a ride, a bar: their median, a cross: {bad}", fontsize=9)
    canvas.save(figure, file)


def _draw(axes: Axes, panel: StripPanel) -> None:
    names = list(panel.strips)
    for y, strip in enumerate(panel.strips.values()):
        there = np.isfinite(strip.values)
        values, bad = strip.values[there], strip.bad[there]
        offset = _SPREAD * (2.0 * ((np.arange(len(values)) * 0.618034) % 1.0) - 1.0)
        axes.plot(
            values[~bad], y + offset[~bad], "o", color=canvas.PERSON, markersize=3.0,
            markeredgewidth=0.0, alpha=0.6,
        )  # fmt: skip
        axes.plot(values[bad], y + offset[bad], "x", color=canvas.WISH, markersize=5.0)
        if len(values):
            middle = float(np.median(values))
            axes.plot([middle, middle], [y - 0.4, y + 0.4], color=canvas.INK, linewidth=2.0)
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_ylim(len(names) - 0.4, -0.6)
    axes.set_xlabel(panel.axis, fontsize=8)
    axes.set_title(panel.title, loc="left", fontsize=9, color=canvas.INK, parse_math=False)
    axes.tick_params(axis="x", labelsize=8)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.8, axis="x")
    axes.spines[["top", "right"]].set_visible(False)
