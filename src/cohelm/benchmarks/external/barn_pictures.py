"""Pictures of ``cohelm bench barn``."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from cohelm.arrays import Floats
from cohelm.benchmarks.bench import Result
from cohelm.evaluation.external.barn import BarnOutcome, BarnWorlds
from cohelm.plotting import canvas
from cohelm.plotting.route_panels import STYLES

SHOWN = 8
"""Number of worlds in the gallery, from the straightest to the most winding."""

_COLOURS = tuple(colour for colour, _, _ in STYLES)


def draw_difficulty(classes: Mapping[str, Sequence[float]], file: Path) -> Path:
    """Draw the share of successes in each class of difficulty.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    figure = _figure(6.0, 3.4)
    axes = figure.subplots()
    for k, (planner, shares) in enumerate(classes.items()):
        at = np.arange(len(shares)) + 0.8 * (k + 0.5) / len(classes) - 0.4
        there, colour = np.isfinite(shares), _COLOURS[k % len(_COLOURS)]
        axes.bar(
            at[there], np.array(shares)[there], 0.74 / len(classes), label=planner, color=colour
        )
    count = len(next(iter(classes.values())))
    for k in range(count):
        if not any(np.isfinite(shares[k]) for shares in classes.values()):
            axes.annotate("none ridden", (k, 0.02), ha="center", fontsize=7, color=canvas.INK)
    words = ["straightest", *[""] * (count - 2), "most winding"]
    axes.set(ylim=(0.0, 1.0), xticks=range(count), xticklabels=words)
    axes.set_ylabel("success")
    axes.grid(axis="y", color=canvas.UNKNOWN, linewidth=0.8)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.set_title("BARN worlds, 2-D port: success by reference path, in fifths", fontsize=9)
    figure.legend(loc="outside lower center", ncols=min(len(classes), 4), fontsize=8)
    canvas.save(figure, file)
    return file


def draw_gallery(
    results: Mapping[str, Sequence[Result]], worlds: BarnWorlds, hardness: Floats, file: Path
) -> Path:
    """Draw some worlds with the tracks through them.

    Args:
        results: planner → rides with ``track`` (k, 2).
        worlds: the data.
        hardness: of each world, (n,); sorts the panels.
        file: to be written.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    # One panel per quantile of difficulty among the worlds that were ridden.
    ridden = sorted({r.row["world"] for each in results.values() for r in each})
    ridden.sort(key=lambda world: float(hardness[world]))
    picks = np.unique(np.linspace(0, len(ridden) - 1, min(SHOWN, len(ridden))).round().astype(int))
    figure = _figure(1.55 * len(picks) + 0.3, 3.9)
    for axes, pick in zip(
        np.ravel(figure.subplots(1, len(picks), squeeze=False)), picks, strict=True
    ):
        world = ridden[pick]
        discs = [Circle((x, y), worlds.radius) for x, y in worlds.cylinders[world]]
        axes.add_collection(PatchCollection(discs, facecolor=canvas.INK, linewidth=0.0))
        for k, (planner, each) in enumerate(results.items()):
            for ride in (r for r in each if r.row["world"] == world):
                won = ride.row["outcome"] == BarnOutcome.SUCCESS.value
                track, colour = ride.arrays["track"], _COLOURS[k % len(_COLOURS)]
                axes.plot(*track.T, color=colour, linewidth=1.4, label=planner)
                if not won:
                    axes.plot(*track[-1], marker="x", color=colour, markersize=9)
        axes.add_patch(Circle(tuple(worlds.goal), worlds.goal_tolerance, fill=False, ls=":"))
        axes.set(xlim=(-4.7, 0.2), ylim=(2.0, 14.1), aspect="equal", xticks=[], yticks=[])
        axes.set_title(f"{world}", fontsize=8)
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), fontsize=8)
    canvas.save(figure, file)
    return file


def _figure(width: float, height: float) -> Figure:
    figure = Figure(figsize=(width, height), dpi=110, facecolor="white", layout="constrained")
    FigureCanvasAgg(figure)
    return figure
