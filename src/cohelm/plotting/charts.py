"""Charts: computing times against an amount, values by name, commands of two rides over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Booleans, Floats
from cohelm.plotting import canvas

_RECORDED, _REPLAYED = canvas.INK, "#e0523f"
_ROW, _WIDTH = 0.26, 4.6
"""Height of a row and width of a panel, inches."""
_SPREAD = 0.28
"""Vertical spread of the marks in a row, rows."""


@dataclass(frozen=True)
class CostPanel:
    """Computing time against one quantity."""

    title: str
    amount: str
    """Label of the horizontal axis."""
    costs: Floats
    """(k, 3): amount, median and 99th percentile of the time, ms."""
    wanted: float | None = None
    """Required median at ``at``, ms."""
    at: float | None = None


def draw_costs_against(panels: Sequence[CostPanel], file: Path) -> None:
    """Draw computing times, one panel for each quantity.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = Figure(
        figsize=(5.2 * len(panels), 3.8), dpi=110, facecolor="white", layout="constrained"
    )
    FigureCanvasAgg(figure)
    for axes, panel in zip(np.ravel(figure.subplots(1, len(panels))), panels, strict=True):
        amount, median, p99 = panel.costs.T
        axes.plot(amount, median, "o-", color=canvas.ROUTE, linewidth=2.0, label="median")
        axes.plot(amount, p99, "^--", color=canvas.UNMAPPED, linewidth=1.4, label="99 %")
        if panel.wanted is not None and panel.at is not None:
            axes.plot(
                panel.at, panel.wanted, "_", color=canvas.WISH, markersize=22, markeredgewidth=2.5,
                linestyle="none", label=f"required: {panel.wanted:g} ms",
            )  # fmt: skip
        axes.set(xlim=(0.0, None), ylim=(0.0, None), xlabel=panel.amount, ylabel="CPU time, ms")
        axes.set_title(panel.title, loc="left", fontsize=10, color=canvas.INK)
        axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=9, labelcolor=canvas.INK)
    canvas.save(figure, file)


@dataclass(frozen=True)
class Strip:
    """Values of one name."""

    values: Floats
    """(k,); NaN are left out."""
    bad: Booleans
    """(k,): drawn as crosses."""


@dataclass(frozen=True)
class StripPanel:
    """One quantity in one case, with the names from top to bottom."""

    title: str
    axis: str
    strips: Mapping[str, Strip]


def draw_strips(rows: Sequence[Sequence[StripPanel]], file: Path, bad: str) -> None:
    """Write a picture of strips: a row of panels for each case.

    Args:
        rows: Panels, the same number in each row.
        file: Picture to write.
        bad: Meaning of a cross.

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
            _draw_strips(axes, panel)
    figure.supxlabel(f"dot: a ride, bar: median, cross: {bad}", fontsize=9)
    canvas.save(figure, file)


def _draw_strips(axes: Axes, panel: StripPanel) -> None:
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


def draw_replay(
    commands: Floats, file: Path, title: str, *, first: float | None = None, names: str = "replayed"
) -> None:
    """Draw recorded and replayed speeds and turn rates over time.

    Args:
        commands: (k, 7), one row per tick: time, s, then the recorded and the replayed twist
            (v_x, v_y, ω), m/s and rad/s.
        file: Picture to write.
        title: Title.
        first: Time of the first difference, s; None: none.
        names: Label of the replayed series.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure = Figure(figsize=(9.6, 5.4), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    for axes, column, label in ((above, 1, "speed, m/s"), (below, 3, "turn rate, rad/s")):
        axes.plot(
            commands[:, 0], commands[:, column], color=_RECORDED, linewidth=2.4, label="recorded"
        )
        axes.plot(
            commands[:, 0], commands[:, column + 3], color=_REPLAYED, linewidth=1.1, label=names
        )
        _style_replay(axes, label, first)
    above.set_title(title, loc="left", fontsize=10, color=canvas.INK, parse_math=False)
    above.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)
    below.set_xlabel("time, s", fontsize=8)
    canvas.save(figure, file)


def _style_replay(axes: Axes, label: str, first: float | None) -> None:
    if first is not None and np.isfinite(first):
        axes.axvline(first, color=_REPLAYED, linewidth=0.8, linestyle=":")
    axes.set_ylabel(label, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.01, y=0.12)
