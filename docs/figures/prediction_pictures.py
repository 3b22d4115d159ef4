"""Pictures of predictions: hypotheses at some moments, and their probabilities over time."""

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
"""Colours of the hypotheses, in their order."""
DASHES = (
    "solid",
    (0, (5, 2)),
    (0, (1, 1.2)),
    (0, (6, 1.5, 1, 1.5)),
    (0, (3, 1, 1, 1, 1, 1)),
    "solid",
)
DRAWN = 0.05
"""Minimum probability of a drawn hypothesis."""


@dataclass(frozen=True)
class PredictedChange:
    """Predictions of one pedestrian, tick by tick."""

    title: str
    onset: float
    """Time of the change of behaviour, s."""
    times: Floats
    """(k,) s."""
    positions: Floats
    """(k, 2) tracked positions, m."""
    predictions: Sequence[Predictions]
    """k predictions of this pedestrian only."""


def draw_predictions(
    changes: Sequence[PredictedChange],
    file: Path,
    *,
    moments: Sequence[float],
    alarm: float,
    soon: float,
) -> None:
    """Draw a column per pedestrian: path with predictions at ``moments``, and probabilities.

    Args:
        changes: at least one; all with the same hypotheses.
        file: of the picture.
        moments: times after the change, s.
        alarm: probability from which a change counts as detected.
        soon: accepted delay of the detection, s.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure = Figure(figsize=(3.1 * len(changes), 5.2), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots(2, len(changes), squeeze=False, height_ratios=[1.3, 1.0])
    for column, change in enumerate(changes):
        _draw_paths(axes[0, column], change, moments)
        _draw_probabilities(axes[1, column], change)
        axes[1, column].axhline(alarm, color="#9aa3ad", lw=0.8)
        axes[1, column].axvspan(0.0, soon, color="#f0e6c8", zorder=0)
        axes[1, column].set_xlim(min(moments) - 0.6, max(moments) + 0.4)
    axes[0, 0].set_ylabel("m")
    axes[1, 0].set_ylabel("probability")
    handles, labels = axes[1, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), frameon=False)
    canvas.save(figure, file)


def _draw_paths(axes: Axes, change: PredictedChange, moments: Sequence[float]) -> None:
    axes.plot(*change.positions.T, color="#9aa3ad", lw=4.0, solid_capstyle="round", zorder=1)
    for moment in moments:
        at = int(np.abs(change.times - change.onset - moment).argmin())
        found = change.predictions[at]
        for h, weight in enumerate(found.weight[0]):
            if weight < DRAWN:
                continue
            colour, dashes = _style(h)
            style: dict[str, Any] = {"color": colour, "alpha": 0.25 + 0.75 * float(weight)}
            axes.plot(*found.mean[0, h].T, lw=1.0 + 1.5 * weight, ls=dashes, zorder=3, **style)
            end, extent = found.mean[0, h, -1], float(found.deviation[0, h, -1])
            axes.add_patch(Circle((end[0], end[1]), extent, fill=False, lw=1.0, zorder=2, **style))
        axes.plot(*change.positions[at], "o", color="#1d2530", ms=4, zorder=4)
        axes.annotate(
            f"{moment:+.1f} s", change.positions[at], (4, 5), textcoords="offset points", fontsize=7
        )
    axes.set_title(change.title, fontsize=10)
    axes.set_aspect("equal", adjustable="datalim")
    axes.margins(0.15)
    axes.tick_params(labelsize=7)


def _style(h: int) -> tuple[str, Any]:
    """Colour and dashes of a hypothesis; those of one colour differ in their dashes."""
    return COLOURS[h % len(COLOURS)], DASHES[(h + h // len(COLOURS)) % len(DASHES)]


def _draw_probabilities(axes: Axes, change: PredictedChange) -> None:
    since = change.times - change.onset
    weights = np.array([each.weight[0] for each in change.predictions])
    for h, name in enumerate(change.predictions[0].names):
        label = name.replace("_", " ")
        colour, dashes = _style(h)
        axes.plot(since, weights[:, h], color=colour, ls=dashes, lw=1.6, label=label)
    axes.set_ylim(0.0, 1.02)
    axes.set_xlabel("since the change, s", fontsize=8)
    axes.tick_params(labelsize=7)
