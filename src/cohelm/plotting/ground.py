"""Picture of the floor that a robot has seen: heights, edges, objects."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgba

from cohelm.arrays import Floats
from cohelm.perception import GroundMap
from cohelm.perception.ground.cells import HIGHER, LOWER, OBJECT
from cohelm.plotting import canvas
from cohelm.robots import Robot

_HEIGHTS = LinearSegmentedColormap.from_list(
    "heights", [canvas.LOWER_FLOOR, "#f4f1ea", canvas.HIGHER_FLOOR]
)
_EDGE_DOWN, _EDGE_UP, _OBJECT = "#8e2464", "#d1495b", "#9aa3ad"
_SPAN = 0.2
"""Height over or below the robot's floor that has the full colour, m."""


def draw_ground(
    ground: GroundMap,
    resolution: float,
    robot: Robot,
    pose: Floats,
    file: Path,
    title: str = "",
) -> None:
    """Draw the window of a ground map whose grid has its origin in (0, 0).

    Args:
        ground: the map.
        resolution: side of its cells, m.
        robot: drawn at ``pose`` (3,).
        pose: X_MR.
        file: picture to write.
        title: of the picture.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    rows, cols = ground.kind.shape
    x, y = ground.corner[::-1] * resolution
    window = x, y, x + cols * resolution, y + rows * resolution
    figure, axes = canvas.sheet(window, title)
    seen = ground.seen > 0
    over = np.clip((ground.height - ground.level) / _SPAN, -1.0, 1.0)
    image = np.where(seen[..., None], _HEIGHTS(0.5 + 0.5 * over), to_rgba(canvas.UNKNOWN))
    kinds = {
        _OBJECT: ((ground.tall > 0) | (ground.kind == OBJECT), "object"),
        _EDGE_DOWN: (ground.kind == LOWER, "behind an edge down"),
        _EDGE_UP: (ground.kind == HIGHER, "behind an edge up"),
    }
    shown: list[tuple[Any, str]] = [
        (_HEIGHTS(0.0), f"{100 * _SPAN:.0f} cm lower"),
        (_HEIGHTS(0.5), "floor"),
        (_HEIGHTS(1.0), f"{100 * _SPAN:.0f} cm higher"),
        (canvas.UNKNOWN, "not seen"),
    ]
    for tint, (where, label) in kinds.items():
        image[where] = to_rgba(tint)
        shown.append((tint, label))
    extent = window[0], window[2], window[1], window[3]
    axes.imshow(image, origin="lower", extent=extent, interpolation="nearest", zorder=0.3)
    axes.set(xlim=extent[:2], ylim=extent[2:])
    axes.add_patch(canvas.footprint(robot, pose, facecolor=canvas.CHAIR, zorder=5))
    for colour, label in shown:
        axes.plot([], [], "s", color=colour, markeredgecolor=canvas.PLAIN_ROUTE, label=label)
    canvas.draw_legend(figure, axes)
    canvas.save(figure, file)
