"""A ride as a trajectory of SocNav3, whose raters and learned metric judge social navigation.

The format is that of the repository SocNavData/SocNav3 (Bachiller-Burgos et al. 2025,
arXiv:2509.01251): positions in m, angles in rad.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.episode.ride import GOAL_RADIUS, Ride
from cohelm.geometry import compose
from cohelm.maps import OccupancyGrid

RATE = 10.0
"""Largest number of steps per second."""


def trajectory(ride: Ride) -> dict[str, Any]:
    """Plain data of a ride; furniture is in the grid, walls have no lines of their own."""
    every = max(1, round(1.0 / (RATE * ride.step)))
    low, high = ride.robot.outline.min(axis=0), ride.robot.outline.max(axis=0)
    middle = (low + high) / 2.0
    shape = {"type": "rectangle", "width": float((high - low)[1]), "length": float((high - low)[0])}
    goal = {
        "type": "go-to",
        "human": None,
        **_place(ride.goal, 0.0),
        "pos_threshold": GOAL_RADIUS,
        "angle_threshold": math.pi,  # no heading is asked for
    }
    return {
        "grid": _grid(ride.world),
        "walls": [],
        "sequence": [
            {
                "timestamp": float(ride.time[k]),
                "goal": goal,
                "robot": {**_robot(ride.pose[k], ride.twist[k], middle), "shape": shape},
                "people": _people(ride.people[k], ride.people_heading[k]),
                "objects": [],
            }
            for k in range(0, len(ride.time), every)
        ],
    }


def _place(at: Floats, angle: float) -> dict[str, float]:
    return {"x": float(at[0]), "y": float(at[1]), "angle": float(angle)}


def _robot(pose: Floats, twist: Floats, middle: Floats) -> dict[str, float]:
    """Pose of the middle of the outline, and its velocity along the map's axes."""
    centre = compose(pose, [*middle, 0.0])
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    ahead, aside = twist[0] - twist[2] * middle[1], twist[1] + twist[2] * middle[0]
    return {
        **_place(centre, centre[2]),
        "speed_x": float(cos * ahead - sin * aside),
        "speed_y": float(sin * ahead + cos * aside),
        "speed_a": float(twist[2]),
    }


def _people(people: Floats, heading: Floats) -> list[dict[str, float]]:
    present = np.flatnonzero(np.isfinite(people[:, 0]))
    return [{"id": int(i), **_place(people[i], heading[i])} for i in present]


def _grid(grid: OccupancyGrid) -> dict[str, Any]:
    """Cells of −1 unknown, 0 free, 1 occupied, from the upper row down."""
    cells = np.where(grid.data < 0, -1, grid.occupied().astype(int))
    x, y, angle = (float(each) for each in grid.X_MG)
    rows, columns = grid.shape
    return {
        "width": columns,
        "height": rows,
        "cell_size": grid.resolution,
        "x_orig": x,
        "y_orig": y,
        "angle_orig": angle,
        "data": cells[::-1].tolist(),
    }
