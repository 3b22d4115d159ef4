"""Picture of a storey: rooms tinted and named, doors with their clear widths, lifts and stairs.

For a report on accessibility, rooms are tinted and hatched by their answer; paths and barriers are
drawn.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke

from cohelm.arrays import Floats, replace, value
from cohelm.buildings import BuildingStorey, room_places
from cohelm.plotting import canvas
from cohelm.plotting.panels import as_svg

_TINTS = ("#4e79a7", "#f28e2b", "#59a14f", "#b07aa1", "#edc948", "#76b7b2", "#e15759", "#9c755f")
_DOOR, _LINK = "#c23b3b", "#5a4fcf"
_LINES: dict[bool, dict[str, Any]] = {
    True: {"color": _DOOR, "linewidth": 3.0, "solid_capstyle": "butt"},
    False: {"color": _DOOR, "linewidth": 1.6, "linestyle": (0, (2, 1))},
}
"""Lines of doors, and of openings without one."""
_ANSWERS = {True: ("#2e8b57", None), False: ("#c0392b", "xx")}
"""Tint and hatch of rooms that are reached, and of the others."""
_PAGE = 7.0
"""Width of the map in a report, inches: its words stay legible on paper and phones."""
_MARGIN = 0.7
"""Around the rooms and doors, m."""


@value
class AccessMarks:
    """Answers on accessibility to draw on a storey."""

    reached: Mapping[str, bool]
    """By the id of a room."""
    paths: tuple[Floats, ...]
    """Paths (k, 2), m."""
    barriers: Mapping[int, tuple[float, float]]
    """Points by the number of a barrier, m."""


def draw_storey(storey: BuildingStorey, file: Path, *, title: str = "") -> None:
    """Draw the map of a storey with its rooms, doors, lifts, stairs and ramps.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    canvas.save(_figure(storey, title or storey.name, None), file)


def storey_svg(storey: BuildingStorey, marks: AccessMarks) -> str:
    """Picture of a storey as an ``svg`` element, with rooms tinted by their answer."""
    says = f"{storey.name}: plan with reached and other rooms, paths and barriers"
    return as_svg(_figure(storey, "", marks), says, own_colours=True)


def _figure(storey: BuildingStorey, title: str, marks: AccessMarks | None) -> Figure:
    shown = [polygon for room in storey.rooms for polygon in room.polygons]
    shown += [door.ends for door in storey.doors]
    window = storey.grid.bounds
    if shown:
        window = canvas.around(np.concatenate(shown), storey.grid, _MARGIN)
    figure, axes = canvas.sheet(window, title, canvas.LARGEST[0] if marks is None else _PAGE)
    canvas.draw_floor(axes, storey.grid)
    for i, room in enumerate(storey.rooms):
        tint, hatch = _TINTS[i % len(_TINTS)], None
        if marks is not None:
            tint, hatch = _ANSWERS[marks.reached.get(room.id, False)]
        for polygon in room.polygons:
            axes.add_patch(Polygon(polygon, facecolor=tint, alpha=0.25, zorder=1))
            axes.add_patch(
                Polygon(
                    polygon, fill=False, edgecolor=tint, hatch=hatch, alpha=0.5, linewidth=0.0,
                    zorder=1,
                )
            )  # fmt: skip
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
    places = room_places(storey)
    if marks is not None:
        signs = ["✓" if marks.reached.get(room.id) else "✗" for room in storey.rooms]
        named = zip(places, signs, strict=True)
        places = replace(places, places=tuple(replace(p, name=f"{s} {p.name}") for p, s in named))
    canvas.draw_places(axes, places, np.array([d.point for d in storey.doors]).reshape(-1, 2))
    for is_door in sorted({door.kind == "door" for door in storey.doors}, reverse=True):
        label = "door, clear width in m" if is_door else "opening or passage without a door"
        axes.plot([], [], **_LINES[is_door], label=label)
    if marks is not None:
        _draw_marks(axes, marks)
    if storey.doors or marks is not None:
        canvas.draw_legend(figure, axes)
    return figure


def _draw_marks(axes: Axes, marks: AccessMarks) -> None:
    for path in marks.paths:
        axes.plot(*path.T, color=canvas.ROUTE, linewidth=1.0, zorder=5)
    for number, (x, y) in marks.barriers.items():
        axes.annotate(
            str(number), (x, y), color="white", fontsize=9, weight="bold", ha="center",
            va="center", zorder=10, bbox={"boxstyle": "circle,pad=0.25", "facecolor": canvas.INK},
        )  # fmt: skip
    for reached, label in ((True, "reached"), (False, "not reached")):
        tint, hatch = _ANSWERS[reached]
        axes.add_patch(
            Polygon(
                np.full((3, 2), np.nan), facecolor=tint, edgecolor=tint, hatch=hatch, alpha=0.4,
                label=label,
            )
        )  # fmt: skip
    axes.plot([], [], color=canvas.ROUTE, linewidth=1.0, label="path")
    if marks.barriers:
        axes.plot([], [], "o", color=canvas.INK, markersize=9, label="barrier, by its number")
