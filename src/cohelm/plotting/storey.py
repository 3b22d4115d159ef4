"""Picture of a storey: rooms tinted and named, doors with their clear widths, lifts and stairs."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from cohelm.buildings import BuildingStorey, room_places
from cohelm.plotting import canvas

_TINTS = ("#4e79a7", "#f28e2b", "#59a14f", "#b07aa1", "#edc948", "#76b7b2", "#e15759", "#9c755f")
_DOOR, _LINK = "#c23b3b", "#5a4fcf"
_LINES: dict[bool, dict[str, Any]] = {
    True: {"color": _DOOR, "linewidth": 3.0, "solid_capstyle": "butt"},
    False: {"color": _DOOR, "linewidth": 1.6, "linestyle": (0, (2, 1))},
}
"""Lines of doors, and of openings without one."""
_MARGIN = 0.7
"""Around the rooms and doors, m."""


def draw_storey(storey: BuildingStorey, file: Path, *, title: str = "") -> None:
    """Draw the map of a storey with its rooms, doors, lifts, stairs and ramps.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    shown = [polygon for room in storey.rooms for polygon in room.polygons]
    shown += [door.ends for door in storey.doors]
    window = storey.grid.bounds
    if shown:
        window = canvas.around(np.concatenate(shown), storey.grid, _MARGIN)
    figure, axes = canvas.sheet(window, title or storey.name)
    canvas.draw_floor(axes, storey.grid)
    for i, room in enumerate(storey.rooms):
        for polygon in room.polygons:
            tint = _TINTS[i % len(_TINTS)]
            axes.add_patch(Polygon(polygon, facecolor=tint, alpha=0.25, zorder=1))
            axes.add_patch(Polygon(polygon, fill=False, edgecolor=tint, linewidth=1.0, zorder=2))
    for link in storey.links:
        axes.add_patch(
            Polygon(link.polygon, fill=False, edgecolor=_LINK, hatch="///", alpha=0.6, zorder=3)
        )
        x, y = link.polygon.mean(axis=0)
        axes.annotate(
            link.kind, (x, y), color=_LINK, fontsize=8, ha="center", zorder=8,
            path_effects=[withStroke(linewidth=2.0, foreground="white")],
        )  # fmt: skip
    for door in storey.doors:
        axes.plot(*door.ends.T, **_LINES[door.kind == "door"], zorder=6)
        x, y = door.point
        axes.annotate(
            f"{door.width:.2f}", (x, y), xytext=(0, 5), textcoords="offset points",
            color=_DOOR, fontsize=7, ha="center", zorder=7,
            path_effects=[withStroke(linewidth=2.0, foreground="white")],
        )  # fmt: skip
    canvas.draw_places(
        axes, room_places(storey), np.array([d.point for d in storey.doors]).reshape(-1, 2)
    )
    for is_door in sorted({door.kind == "door" for door in storey.doors}, reverse=True):
        label = "door, clear width in m" if is_door else "opening or passage without a door"
        axes.plot([], [], **_LINES[is_door], label=label)
    if storey.doors:
        canvas.draw_legend(figure, axes)
    canvas.save(figure, file)
