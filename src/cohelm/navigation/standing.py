"""People who stand, where things are asked for: to be gone round, and on the rider's side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, People, Side

_AHEAD, _REACH, _THICK = 4.0, 2.5, 0.1
"""Who stands so near ahead reaches so far to the side on which not to pass, so thickly, m."""


def as_things(
    live: LiveObstacles, grid: OccupancyGrid, people: People, below: float
) -> LiveObstacles:
    """The live obstacles, and whoever is slower than ``below``, m/s, as if they were things."""
    occupied, centres = live.occupied.copy(), _centres(live, grid)
    standing = _standing(people, below)
    for (x, y), radius in zip(people.mean[standing, :2], people.radius[standing], strict=True):
        occupied[np.hypot(centres[..., 0] - x, centres[..., 1] - y) < radius] = 1
    return replace(live, occupied=occupied)


def closed_but_for(
    side: Side,
    live: LiveObstacles,
    grid: OccupancyGrid,
    people: People,
    pose: Floats,
    below: float,
) -> LiveObstacles:
    """The live obstacles, and a bar on the other side of whoever stands ahead of ``pose`` (3,).

    So the rider's word for a side binds every planner. ``live`` itself where nobody does.
    """
    standing = people.mean[_standing(people, below), :2]
    ahead = standing - pose[:2]
    faces = ahead @ np.array([np.cos(pose[2]), np.sin(pose[2])])
    away = np.hypot(*ahead.T)
    barred = (away <= _AHEAD) & (faces > 0.0)
    if side == "none" or not barred.any():
        return live
    occupied, centres = live.occupied.copy(), _centres(live, grid)
    for person, unit in zip(standing[barred], (ahead / away[:, None])[barred], strict=True):
        left = np.array([-unit[1], unit[0]])
        aside = (centres - person) @ (-left if side == "left" else left)
        along = np.abs((centres - person) @ unit)
        occupied[(along < _THICK) & (aside >= 0.0) & (aside < _REACH)] = 1
    return replace(live, occupied=occupied)


def _standing(people: People, below: float) -> Booleans:
    slow: Booleans = np.hypot(*people.mean[:, 2:].T) < below
    return slow


def _centres(live: LiveObstacles, grid: OccupancyGrid) -> Floats:
    rows, cols = np.indices(live.occupied.shape)
    return grid.centres(np.stack([rows, cols], axis=-1) + live.corner)
