"""Rides made by hand, for tests that derive what a measure must be."""

import numpy as np

from cohelm.evaluation import Outcome, Ride
from cohelm.maps import OccupancyGrid
from cohelm.robots import Robot
from cohelm.scenarios.scenario import Scenario

SQUARE = Robot(
    name="square",
    footprint=((0.5, 0.5), (-0.5, 0.5), (-0.5, -0.5), (0.5, -0.5)),
    max_speed=2.0,
    max_turn_rate=1.0,
    max_acceleration=1.0,
    max_deceleration=1.0,
    emergency_deceleration=1.0,
    max_turn_acceleration=1.0,
)


def made_ride(pose, *, step=0.5, people=None, **changes):
    """A ride through poses (k, 3) with speeds of its own; people (k, n, 4)."""
    pose = np.asarray(pose, dtype=float)
    k = len(pose)
    people = np.empty((k, 0, 4)) if people is None else np.asarray(people, dtype=float)
    n = people.shape[1]
    grid = OccupancyGrid(data=np.zeros((20, 20), dtype=np.int8), resolution=1.0, X_MG=np.zeros(3))
    given = {
        "scenario": Scenario(name="made", floor="hall", start=(0.0, 0.0), goal=(10.0, 0.0)),
        "seed": 0,
        "outcome": Outcome.REACHED,
        "robot": SQUARE,
        "grid": grid,
        "world": grid,
        "goal": [10.0, 0.0],
        "prefer": np.empty((0, 2)),
        "step": step,
        "time": step * np.arange(k),
        "pose": pose,
        "twist": np.zeros((k, 3)),
        "command": np.zeros((k, 3)),
        "requested": np.full((k, 3), np.nan),
        "stick": np.full((k, 2), np.nan),
        "eta": np.zeros(k),
        "gap_people": np.full((k, n), 5.0),
        "gap_wall": np.full(k, 3.0),
        "hit_moving": np.zeros((k, n), dtype=bool),
        "hit_standing": np.zeros((k, n), dtype=bool),
        "hit_wall": np.zeros(k, dtype=bool),
        "people": people,
        "people_heading": np.zeros((k, n)),
        "people_target": np.zeros((k, n), dtype=np.int64),
        "people_radius": np.full(n, 0.25),
        "durations": {"tick": np.full(k, 0.001)},
    }
    return Ride(**{**given, **changes})
