"""Standing people as static obstacles, and the passing side that the rider selected."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Booleans, Floats, replace
from cohelm.maps import OccupancyGrid
from cohelm.messages import LiveObstacles, People, Side

_AHEAD = 4.0
"""Distance ahead within which a standing person closes a side, m."""
_BAR_LENGTH, _BAR_HALF_WIDTH = 2.5, 0.1
"""Extent of the bar beside the person, m."""


def with_static_people(
    live: LiveObstacles, grid: OccupancyGrid, people: People, standing_speed: float
) -> LiveObstacles:
    """Add people slower than ``standing_speed``, m/s, to the live obstacles."""
    occupied, centres = live.occupied.copy(), _centres(live, grid)
    standing = _standing(people, standing_speed)
    for (x, y), radius in zip(people.mean[standing, :2], people.radius[standing], strict=True):
        occupied[np.hypot(centres[..., 0] - x, centres[..., 1] - y) < radius] = 1
    return replace(live, occupied=occupied)


def with_closed_side(
    side: Side,
    live: LiveObstacles,
    grid: OccupancyGrid,
    people: People,
    pose: Floats,
    standing_speed: float,
) -> LiveObstacles:
    """Add a bar on the other side of each person who stands ahead of ``pose`` (3,).

    So the rider's choice of a side binds every planner. Returns ``live`` itself if none stands.
    """
    standing = people.mean[_standing(people, standing_speed), :2]
    offset = standing - pose[:2]
    ahead = offset @ np.array([np.cos(pose[2]), np.sin(pose[2])])
    distance = np.hypot(*offset.T)
    barred = (distance <= _AHEAD) & (ahead > 0.0)
    if side == "none" or not barred.any():
        return live
    occupied, centres = live.occupied.copy(), _centres(live, grid)
    for person, unit in zip(standing[barred], (offset / distance[:, None])[barred], strict=True):
        left = np.array([-unit[1], unit[0]])
        lateral = (centres - person) @ (-left if side == "left" else left)
        along = np.abs((centres - person) @ unit)
        occupied[(along < _BAR_HALF_WIDTH) & (lateral >= 0.0) & (lateral < _BAR_LENGTH)] = 1
    return replace(live, occupied=occupied)


def _standing(people: People, standing_speed: float) -> Booleans:
    slow: Booleans = np.hypot(*people.mean[:, 2:].T) < standing_speed
    return slow


def _centres(live: LiveObstacles, grid: OccupancyGrid) -> Floats:
    rows, cols = np.indices(live.occupied.shape)
    return grid.centres(np.stack([rows, cols], axis=-1) + live.corner)
