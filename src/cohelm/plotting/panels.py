"""Small panels for a page: boxes, curves and tracks of many contenders, as SVG that fits in HTML.

The colours are those of Okabe and Ito (2008), which most colour-blind people can distinguish; each
contender also has its own dash and mark. Text and frames take the page's colour.
"""

from __future__ import annotations

import io
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from cohelm.arrays import Booleans, Floats
from cohelm.maps import OccupancyGrid
from cohelm.plotting import canvas

_COLOURS = (
    "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8b7f00", "#7f8791",
)  # fmt: skip
_DASHES: tuple[Any, ...] = ("-", (0, (5, 1.5)), (0, (1.2, 1.2)), (0, (6, 1.5, 1.2, 1.5)))
_MARKS = "osD^vPX*"
_WIDTH, _HEIGHT, _ROW = 4.6, 2.7, 0.3  # of a panel, and of a box in it, inches
_DOTS = 150  # of a box at most
_EVERY = 2.0  # s between marks on a track


@dataclass(frozen=True)
class Look:
    """Line style of a contender, the same in every panel."""

    colour: str
    dashes: Any
    mark: str


def look(index: int) -> Look:
    """Line style of a contender by its index."""
    return Look(
        colour=_COLOURS[index % len(_COLOURS)],
        dashes=_DASHES[(index + index // len(_COLOURS)) % len(_DASHES)],
        mark=_MARKS[(index + 3 * (index // len(_COLOURS))) % len(_MARKS)],
    )


@dataclass(frozen=True)
class Values:
    """Values of one contender."""

    look: Look
    values: Floats
    """(k,); NaN are left out."""
    bad: Booleans
    """(k,): drawn as crosses."""


def box_panel(title: str, axis: str, by_name: Mapping[str, Values]) -> str:
    """Quartiles, whiskers to 1.5 × their distance, and every value as a dot, or a cross if bad."""
    figure, axes = _panel(title, 0.95 + _ROW * len(by_name))
    for y, each in enumerate(by_name.values()):
        there = np.isfinite(each.values)
        values, bad = each.values[there], each.bad[there]
        if not len(values):
            continue
        colour = each.look.colour
        line = {"color": colour, "linewidth": 1.4}
        axes.boxplot(
            values, positions=[y], orientation="horizontal", widths=0.62, showfliers=False,
            manage_ticks=False, patch_artist=True, boxprops={"facecolor": colour + "30", **line},
            whiskerprops=line, capprops=line, medianprops={"color": canvas.INK, "linewidth": 2.0},
        )  # fmt: skip
        kept = np.linspace(0, len(values) - 1, min(len(values), _DOTS)).astype(int)
        offset = 0.22 * (2.0 * ((np.arange(len(kept)) * 0.618034) % 1.0) - 1.0)
        dots, crossed = values[kept], bad[kept]
        _draw_dots(axes, dots[~crossed], y + offset[~crossed], colour)
        axes.plot(
            dots[crossed], y + offset[crossed], linestyle="none", marker="x", color=colour,
            markersize=4.5,
        )  # fmt: skip
    axes.set_yticks(range(len(by_name)), list(by_name), fontsize=9, parse_math=False)
    axes.set_ylim(len(by_name) - 0.4, -0.6)
    axes.set_xlabel(axis, fontsize=9, parse_math=False)
    axes.grid(axis="x", color=canvas.UNKNOWN, linewidth=0.8)
    return as_svg(figure, f"{title}: {axis}, box plots")


def curve_panel(
    title: str, axis: str, by_name: Mapping[str, tuple[Look, Floats, Floats]], top: float | None
) -> str:
    """Draw a quantity over time, one line per contender.

    Args:
        title: title.
        axis: label of the vertical axis.
        by_name: contender → (look, time (k,) s, values (k,)); only finite values are drawn.
        top: upper limit of the axis; None: no limit.
    """
    figure, axes = _panel(title, _HEIGHT)
    for name, (each, time, values) in by_name.items():
        shown = np.where(np.isfinite(values), values, np.nan)
        shown = shown if top is None else np.where(shown > top, np.nan, shown)
        axes.plot(time, shown, color=each.colour, linestyle=each.dashes, linewidth=1.5, label=name)
    axes.set_xlabel("time, s", fontsize=9)
    axes.set_ylabel(axis, fontsize=9, parse_math=False)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
    return as_svg(figure, f"{title}: {axis} over time")


def track_panel(
    title: str,
    by_name: Mapping[str, tuple[Look, Floats]],
    floor: OccupancyGrid | None,
    ends: Floats,
) -> str:
    """Draw the track of every contender on the floor, with a mark every 2 s.

    Args:
        title: title.
        by_name: contender → (look, (k, 3): time s, x, y m).
        floor: drawn below the tracks; None: unknown.
        ends: (2, 2), start and goal, m; NaN: unknown.
    """
    points = np.concatenate([each[:, 1:3] for _, each in by_name.values()] + [ends])
    points = points[np.isfinite(points).all(axis=1)]
    low, high = points.min(axis=0) - 1.2, points.max(axis=0) + 1.2
    extent = np.maximum(high - low, 3.0)
    low = (low + high - extent) / 2.0
    height = float(np.clip(_WIDTH * extent[1] / extent[0], 1.6, 6.0))
    figure, axes = _panel(title, height + 0.4)
    axes.set(xlim=(low[0], low[0] + extent[0]), ylim=(low[1], low[1] + extent[1]), aspect="equal")
    if floor is not None:
        canvas.draw_floor(axes, floor)
    for each, track in by_name.values():
        axes.plot(*track[:, 1:3].T, color=each.colour, linestyle=each.dashes, linewidth=1.6)
        step = np.flatnonzero(np.diff(np.floor((track[:, 0] + 1e-9) / _EVERY)) > 0) + 1
        axes.plot(
            *track[step, 1:3].T, linestyle="none", marker=each.mark, color=each.colour,
            markersize=4.5, markeredgecolor="white", markeredgewidth=0.5,
        )  # fmt: skip
    if np.isfinite(ends).all():
        canvas.draw_ends(axes, ends[0], ends[1])
    axes.set(xticks=[], yticks=[])
    canvas.draw_scale_bar(axes)
    return as_svg(figure, f"{title}: tracks", own_colours=True)


def sample(each: Look) -> str:
    """Draw a piece of a contender's line with its mark, for a legend."""
    figure = Figure(figsize=(0.45, 0.16))
    FigureCanvasSVG(figure)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.plot([0, 1, 2], [0, 0, 0], color=each.colour, linestyle=each.dashes, linewidth=2.0)
    axes.plot([1], [0], color=each.colour, marker=each.mark, markersize=5.0)
    axes.set_axis_off()
    return as_svg(figure, "")


def as_svg(figure: Figure, says: str, *, own_colours: bool = False) -> str:
    """Figure as an ``svg`` element for HTML, without addresses; equal figures give equal text.

    Args:
        figure: figure.
        says: description for screen readers.
        own_colours: text and grid keep their colours instead of taking the page's.
    """
    out = io.StringIO()
    with rc_context({"svg.hashsalt": "cohelm", "svg.fonttype": "none"}):
        figure.savefig(out, format="svg", metadata={"Date": None}, transparent=not own_colours)
    whole = out.getvalue()
    svg = whole[whole.index("<svg") :]
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r'\s+xmlns(:\w+)?="[^"]*"', "", svg)
    svg = re.sub(r"<style.*?</style>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<[^>]*>", _shortened, svg)
    svg = re.sub(r"font-family: [^;\"]*", "font-family: inherit", svg)
    svg = re.sub(r"\s*\n\s*", " ", svg)
    if not own_colours:
        svg = svg.replace(canvas.INK, "currentColor").replace(canvas.UNKNOWN, "var(--line)")
    label = f'role="img" aria-label="{_attribute(says)}"' if says else 'aria-hidden="true"'
    return svg.replace("<svg ", f'<svg {label} stroke-linejoin="round" ', 1)


def _shortened(tag: re.Match[str]) -> str:
    """Round the coordinates in a tag to two digits; text between tags is unchanged."""
    return re.sub(r"(\d\.\d\d)\d+", r"\1", tag[0])


def _draw_dots(axes: Axes, x: Floats, y: Floats, colour: str) -> None:
    """Round dots as one path, which takes a fifth of the text of separate markers."""
    if not len(x):
        return
    points = np.repeat(np.column_stack([x, y]), 2, axis=0)
    path = Path(points, np.tile([Path.MOVETO, Path.LINETO], len(x)))
    path.should_simplify = False  # else segments without length are dropped
    axes.add_patch(
        PathPatch(
            path, facecolor="none", edgecolor=colour, alpha=0.75, linewidth=2.6, capstyle="round"
        )
    )


def _attribute(words: str) -> str:
    for sign, name in (("&", "amp"), ("<", "lt"), (">", "gt"), ('"', "quot")):
        words = words.replace(sign, f"&{name};")
    return words


def _panel(title: str, height: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(_WIDTH, height), layout="constrained")
    FigureCanvasSVG(figure)
    axes = figure.add_subplot()
    axes.set_title(title, loc="left", fontsize=10, color=canvas.INK, parse_math=False)
    axes.tick_params(labelsize=8.5, colors=canvas.INK)
    axes.xaxis.label.set_color(canvas.INK)
    axes.yaxis.label.set_color(canvas.INK)
    for side, spine in axes.spines.items():
        spine.set(color=canvas.INK, linewidth=0.8, visible=side in {"left", "bottom"})
    return figure, axes
