"""Picture of a scene at its start: floor, chair, route, and paths of the pedestrians."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from cohelm import messages
from cohelm.arrays import Floats
from cohelm.maps import OccupancyGrid
from cohelm.messages import Wish
from cohelm.plotting import canvas
from cohelm.plotting.route import draw_strokes, draw_zones
from cohelm.robots import Robot
from cohelm.simulation import Crowd

SMALL = 0.5
"""Scale of the figure; the picture is one of many."""
STANDING = 0.5
"""A pedestrian whose path is shorter than this stands, m."""


class SceneRecord(Protocol):
    """Content of a picture of a scene; k points of the route, w wished points."""

    @property
    def grid(self) -> OccupancyGrid:
        """The map."""

    @property
    def world(self) -> OccupancyGrid:
        """True obstacles at any time, on the same cells."""

    @property
    def robot(self) -> Robot:
        """The chair."""

    @property
    def start(self) -> Floats:
        """X_MR (3,)."""

    @property
    def route(self) -> messages.Path:
        """Planned on the map alone."""

    @property
    def rider_routes(self) -> Sequence[Floats]:
        """Routes (k, 2) that the rider has in mind and the chair does not know."""

    @property
    def wishes(self) -> Sequence[Wish]:
        """The rider's, of the route."""

    @property
    def crowd(self) -> Crowd:
        """The people at the beginning."""


def draw_scene(scene: SceneRecord, file: Path, title: str = "") -> None:
    """Write a small picture of a scene.

    Raises:
        ConfigError: if the file cannot be written as a picture.
    """
    canvas.check_picture(file)
    points = [
        scene.route.points,
        *scene.rider_routes,
        scene.start[None, :2],
        *paths_of(scene.crowd),
    ]
    window = canvas.around(np.concatenate(points), scene.grid, margin=1.5)
    figure, axes = canvas.sheet(window, title)
    canvas.draw_floor(axes, scene.grid, scene.world)
    draw_zones(axes, scene.wishes)
    draw_strokes(axes, scene.wishes)
    for line in scene.rider_routes:
        axes.plot(*line.T, color=canvas.PLAIN_ROUTE, linewidth=1.4, zorder=4)
    canvas.draw_route(axes, scene.route.points, scene.route.without_wishes)
    _draw_paths(axes, scene.crowd)
    attract = [wish.points for wish in scene.wishes if wish.kind == "attract"]
    canvas.draw_wishes(axes, np.concatenate([np.empty((0, 2)), *attract]))
    axes.add_patch(
        canvas.footprint(
            scene.robot, scene.start, facecolor="white", edgecolor=canvas.CHAIR, linewidth=1.6,
            zorder=11,
        )
    )  # fmt: skip
    canvas.draw_ends(axes, scene.start, scene.route.points[-1])
    figure.set_size_inches(*(SMALL * figure.get_size_inches()))
    canvas.save(figure, file)


def paths_of(crowd: Crowd) -> list[Floats]:
    """Path (k, 2) of each present pedestrian; closed where it is a loop."""
    paths = []
    for i in np.flatnonzero(crowd.there):
        at = crowd.position[i]
        ahead = crowd.waypoints[i, crowd.target[i] :]
        line = np.vstack([at, ahead[np.isfinite(ahead).all(axis=1)]])
        if np.hypot(*(line - at).T).max() < STANDING:
            line = line[:1]
        paths.append(np.vstack([line, at]) if crowd.loop[i] and len(line) > 1 else line)
    return paths


def _draw_paths(axes: Axes, crowd: Crowd) -> None:
    """Draw each person's path, dotted with an arrow head, and the body."""
    for line, radius in zip(paths_of(crowd), crowd.radius[crowd.there], strict=True):
        axes.plot(
            *line.T, color=canvas.PERSON, linewidth=1.1, linestyle=(0, (1, 2)), alpha=0.8, zorder=6
        )
        if len(line) > 1:
            axes.annotate(
                "", xy=tuple(line[-1]), xytext=tuple(_before(line)),
                arrowprops={"arrowstyle": "-|>", "color": canvas.PERSON, "linewidth": 1.1},
                zorder=7,
            )  # fmt: skip
        axes.add_patch(
            Circle(
                (line[0, 0], line[0, 1]), radius, facecolor=canvas.PERSON, edgecolor="white",
                linewidth=0.6, zorder=8,
            )
        )  # fmt: skip


def _before(line: Floats) -> Floats:
    """A point (2,) shortly before the end of a line (k, 2)."""
    away = line[-2] - line[-1]
    return np.asarray(line[-1] + away / max(float(np.hypot(*away)), 1e-9) * 0.5)
