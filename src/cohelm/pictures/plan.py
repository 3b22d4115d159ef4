"""A route on its map."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohelm import messages
from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid, Places
from cohelm.pictures import canvas


def draw_plan(
    grid: OccupancyGrid, route: messages.Path, prefer: Floats, file: Path, places: Places
) -> None:
    """Write a picture of a route, of the one without wishes, of the wishes (w, 2) and the places.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    window = canvas.around(
        np.concatenate([route.points, route.without_wishes, prefer]), grid, margin=3.0
    )
    title = f"{route.method}: {route.length:.1f} m"
    if len(prefer):
        title += (
            f", {route.wishes.extra_length + 0.0:+.2f} m for the wish, "
            f"{route.wishes.closest.max(initial=0.0):.2f} m from it at worst"
        )
    figure, axes = canvas.sheet(window, title)
    canvas.draw_floor(axes, grid)
    canvas.draw_places(axes, places, np.concatenate([route.points, prefer]))
    canvas.draw_route(axes, route.points, route.without_wishes)
    canvas.draw_wishes(axes, prefer)
    canvas.draw_ends(axes, route.points[0], route.points[-1])
    canvas.draw_scale_bar(axes)
    canvas.draw_legend(figure, axes)
    canvas.save(figure, file)
