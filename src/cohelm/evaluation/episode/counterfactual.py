"""Counterfactual of a ride: the same pedestrians, seed and floor without the chair."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.evaluation.episode.ride import Ride
from cohelm.evaluation.episode.ride_log import states_of
from cohelm.simulation import CrowdScene, WorldSetup, generator
from cohelm.simulation.dynamic_objects import current_grid

_FAR = np.full(2, 1e6)
"""Position of an absent chair, m."""


@value
class Counterfactual:
    """People without the chair at the ticks of a ride; k ticks, n people."""

    people: Annotated[Floats, Shape("k n 4")]
    """(x, y, v_x, v_y); NaN where a person is absent."""
    people_target: Annotated[Integers, Shape("k n")]
    """Index of each person's next waypoint."""


def counterfactual(ride: Ride) -> Counterfactual | None:
    """People of a ride without the chair; None where no person reacts to it, or it is not known."""
    sees = ride.people_see
    if ride.setup is None or sees is None or not sees.any():
        return None
    return simulate_without_robot(ride.setup, ride.seed, len(ride.time))


@lru_cache(maxsize=1)  # several measures of one ride need it
def simulate_without_robot(setup: WorldSetup, seed: int, ticks: int) -> Counterfactual:
    """Run the pedestrian model alone, in the steps of a world, with the chair far away."""
    rng = generator(seed, "people")
    blind = np.zeros(len(setup.crowd.radius), dtype=np.bool_)
    crowd, grid, crowds = replace(setup.crowd, sees_robot=blind), setup.grid, []
    outline = setup.robot.outline + _FAR
    for k in range(ticks):
        crowds.append(crowd)
        time, bodies = k * setup.control_step, np.column_stack([crowd.position, crowd.radius])
        grid = current_grid(setup.changes, grid, time, outline, bodies[crowd.there])
        scene = CrowdScene(
            grid=grid,
            robot_position=_FAR,
            robot_velocity=np.zeros(2),
            robot_radius=0.0,
            time=time,
        )
        crowd = setup.pedestrian_model.step(crowd, scene, setup.control_step, rng)
    return Counterfactual(
        people=np.array([states_of(each) for each in crowds]),
        people_target=np.array([each.target for each in crowds]),
    )
