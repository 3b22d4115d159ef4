"""Picture of a map with a metre grid, its named places, and checked points."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from cohelm.maps import OccupancyGrid, Places
from cohelm.planning.free_space import FreeSpaceCheck
from cohelm.plotting import canvas

_FITS, _BLOCKED = "#2e9e4f", "#c23b3b"


def draw_map(
    grid: OccupancyGrid,
    places: Places,
    file: Path,
    *,
    title: str = "",
    checks: Sequence[FreeSpaceCheck] = (),
) -> None:
    """Draw a map; checked points are green where the chair fits, else red with the nearest one.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    figure, axes = canvas.sheet(grid.bounds, title)
    canvas.draw_floor(axes, grid)
    points = np.array([check.point for check in checks]).reshape(-1, 2)
    canvas.draw_places(axes, places, points)
    for check in checks:
        colour = _FITS if check.fits else _BLOCKED
        x, y = check.point
        axes.plot(x, y, marker="o" if check.fits else "X", color=colour, markersize=9, zorder=12)
        if not check.fits and check.nearest is not None:
            near_x, near_y = check.nearest
            axes.plot([x, near_x], [y, near_y], color=_BLOCKED, linewidth=1.0, zorder=11)
            axes.plot(near_x, near_y, marker="o", color=_FITS, markersize=9, zorder=12)
    if checks:
        axes.plot([], [], "o", color=_FITS, markersize=9, label="chair fits")
        if not all(check.fits for check in checks):
            axes.plot([], [], "X", color=_BLOCKED, markersize=9, label="does not fit")
        canvas.draw_legend(figure, axes)
    canvas.save(figure, file)
