"""Where walkers are thought to go: their hypotheses at some moments, and how likely each was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cohelm.arrays import Floats
from cohelm.messages import Predictions
from cohelm.plotting import canvas

COLOURS = ("#1d2530", "#c23b3b", "#8f5cc3", "#2e9e4f", "#3d6fb4", "#e08a1e")
"""Of the hypotheses, in their order."""
DASHES = (
    "solid",
    (0, (5, 2)),
    (0, (1, 1.2)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (3, 1, 1, 1, 1, 1)),
    "solid",
)
DRAWN = 0.05
"""Least probability of a hypothesis that is drawn."""


@dataclass(frozen=True)
class Foretold:
    """One walker, tick by tick."""

    title: str
    change: float
    """When he changes his mind, s."""
    times: Floats
    """(k,) s."""
    positions: Floats
    """(k, 2), where he was seen, m."""
    predictions: Sequence[Predictions]
    """k, of him alone."""


def draw_futures(
    walkers: Sequence[Foretold],
    file: Path,
    *,
    moments: Sequence[float],
    alarm: float,
    soon: float,
) -> None:
    """A column for each walker: his way with what was foretold at ``moments``, and the odds.

    Args:
        walkers: at least one; their hypotheses must be the same.
        file: the picture.
        moments: after each walker's change, s.
        alarm: the probability from which on a change counts as noticed.
        soon: how long it may take until then, s.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure = Figure(figsize=(3.1 * len(walkers), 5.2), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(walkers), squeeze=False, height_ratios=[1.3, 1.0])
    for column, walker in enumerate(walkers):
        _draw_ways(axes[0, column], walker, moments)
        _draw_odds(axes[1, column], walker)
        axes[1, column].axhline(alarm, color="#9aa3ad", lw=0.8)
        axes[1, column].axvspan(0.0, soon, color="#f0e6c8", zorder=0)
        axes[1, column].set_xlim(min(moments) - 0.6, max(moments) + 0.4)
    axes[0, 0].set_ylabel("m")
    axes[1, 0].set_ylabel("probability")
    handles, labels = axes[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    canvas.save(figure, file)


def _draw_ways(axes: Axes, walker: Foretold, moments: Sequence[float]) -> None:
    axes.plot(*walker.positions.T, color="#9aa3ad", lw=4.0, solid_capstyle="round", zorder=1)
    for moment in moments:
        at = int(np.abs(walker.times - walker.change - moment).argmin())
        told = walker.predictions[at]
        for h, weight in enumerate(told.weight[0]):
            if weight < DRAWN:
                continue
            colour, dashes = _style(h)
            style: dict[str, Any] = {"color": colour, "alpha": 0.25 + 0.75 * float(weight)}
            axes.plot(*told.mean[0, h].T, lw=1.0 + 1.5 * weight, ls=dashes, zorder=3, **style)
            end, reach = told.mean[0, h, -1], float(told.deviation[0, h, -1])
            axes.add_patch(Circle((end[0], end[1]), reach, fill=False, lw=1.0, zorder=2, **style))
        axes.plot(*walker.positions[at], "o", color="#1d2530", ms=4, zorder=4)
        axes.annotate(
            f"{moment:+.1f} s", walker.positions[at], (4, 5), textcoords="offset points", fontsize=7
        )
    axes.set_title(walker.title, fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.tick_params(labelsize=7)


def _style(h: int) -> tuple[str, Any]:
    """Colour and dashes of a hypothesis; those of one colour differ in their dashes."""
    return COLOURS[h % len(COLOURS)], DASHES[(h + h // len(COLOURS)) % len(DASHES)]


def _draw_odds(axes: Axes, walker: Foretold) -> None:
    since = walker.times - walker.change
    weights = np.array([told.weight[0] for told in walker.predictions])
    for h, name in enumerate(walker.predictions[0].names):
        label = name.replace("_", " ")
        colour, dashes = _style(h)
        axes.plot(since, weights[:, h], color=colour, ls=dashes, lw=1.6, label=label)
    axes.set_ylim(0.0, 1.02)
    axes.set_xlabel("since the change, s", fontsize=8)
    axes.tick_params(labelsize=7)
