"""What something costs against how much of it there is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Floats
from cohelm.pictures import canvas


@dataclass(frozen=True)
class CostPanel:
    """One quantity, and the times that it takes."""

    title: str
    amount: str
    """What the horizontal axis counts."""
    costs: Floats
    """(k, 3): amount, median and 99th percentile of the time, ms."""
    wanted: float | None = None
    """The median asked for at ``at``, ms."""
    at: float | None = None


def draw_costs_against(panels: Sequence[CostPanel], file: Path) -> None:
    """Write a picture of costs, a panel for each quantity.

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
                linestyle="none", label=f"asked for: {panel.wanted:g} ms",
            )  # fmt: skip
        axes.set(xlim=(0.0, None), ylim=(0.0, None), xlabel=panel.amount, ylabel="CPU time, ms")
        axes.set_title(panel.title, loc="left", fontsize=10, color=canvas.INK)
        axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=9, labelcolor=canvas.INK)
    canvas.save(figure, file)
