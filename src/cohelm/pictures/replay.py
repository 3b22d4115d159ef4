"""Two courses of commands over the same ride, one above the other."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.arrays import Floats
from cohelm.pictures import canvas

THEN, NOW = canvas.INK, "#e0523f"


def draw_replay(
    commands: Floats, file: Path, title: str, *, first: float | None = None, names: str = "replayed"
) -> None:
    """Draw the speed and the turn rate of what was commanded then and now.

    Args:
        commands: (k, 7), a row each tick: time in s, then the twist (v_x, v_y, ω) that was recorded
            and the one that was decided again, m/s and rad/s.
        file: of the picture.
        title: above it.
        first: when they begin to differ, s; None: never.
        names: what the second course is called.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure = Figure(figsize=(9.6, 5.4), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    above, below = figure.subplots(2, 1, sharex=True)
    for axes, column, label in ((above, 1, "speed, m/s"), (below, 3, "turn rate, rad/s")):
        axes.plot(commands[:, 0], commands[:, column], color=THEN, linewidth=2.4, label="recorded")
        axes.plot(commands[:, 0], commands[:, column + 3], color=NOW, linewidth=1.1, label=names)
        _dress(axes, label, first)
    above.set_title(title, loc="left", fontsize=10, color=canvas.INK, parse_math=False)
    above.legend(loc="upper right", fontsize=8, frameon=False, ncols=2)
    below.set_xlabel("time, s", fontsize=8)
    canvas.save(figure, file)


def _dress(axes: Axes, label: str, first: float | None) -> None:
    if first is not None and np.isfinite(first):
        axes.axvline(first, color=NOW, linewidth=0.8, linestyle=":")
    axes.set_ylabel(label, fontsize=8)
    axes.tick_params(labelsize=8)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.01, y=0.12)
