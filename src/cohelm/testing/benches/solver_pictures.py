"""The picture of ``cohelm bench solver``: time over people."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from cohelm.pictures import canvas
from cohelm.pictures.routes import STYLES
from cohelm.testing.benches.solver_speed import IPOPT, PLAN, PLAN_2, PLAN_6, SOLVE, SOLVE_6

SHOWN = (IPOPT, PLAN_6, PLAN_2, SOLVE_6, PLAN, SOLVE)


def draw_speed(rows: Sequence[Any], horizon: int, file: Path) -> Path:
    """Write a picture of the median times over people on a logarithmic scale, p99 dotted.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = Figure(figsize=(6.4, 3.8), dpi=110, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    for what, (colour, _, _) in zip(SHOWN, STYLES, strict=False):
        line = sorted(
            (row["people"], row["median_ms"], row["p99_ms"])
            for row in rows
            if (row["what"], row["horizon"]) == (what, horizon)
        )
        if line:
            people, median, p99 = zip(*line, strict=True)
            axes.plot(people, median, color=colour, marker="o", markersize=3, label=what)
            axes.plot(people, p99, color=colour, linestyle=":", linewidth=1)
    axes.set_yscale("log")
    axes.set(xlabel="people", ylabel="thread CPU time, ms")
    axes.set_title(f"N = {horizon}, walls included: median, and p99 dotted", fontsize=9)
    axes.grid(color=canvas.UNKNOWN, linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=8)
    canvas.save(figure, file)
    return file
