"""How the people of a ride would have walked had there been no chair: same seed, same floor."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.evaluation.noting import states_of
from cohelm.evaluation.ride import Ride
from cohelm.simulation import Scene, WorldSetup, generator
from cohelm.simulation.changes import present

_FAR = np.full(2, 1e6)
"""Where a chair is that nobody meets, m."""


@value
class Unmet:
    """People without the chair, at the ticks of a ride; k ticks, n people."""

    people: Annotated[Floats, Shape("k n 4")]
    """(x, y, v_x, v_y); NaN where a person is not there."""
    people_target: Annotated[Integers, Shape("k n")]
    """Index of the way-point that each walks to."""


def unmet(ride: Ride) -> Unmet | None:
    """The ride's people without the chair; None where nobody reacts to it, or nobody knows."""
    sees = ride.people_see
    if ride.setup is None or sees is None or not sees.any():
        return None
    return _walked(ride.setup, ride.seed, len(ride.time))


@lru_cache(maxsize=1)  # more than one measure asks for those of the same ride
def _walked(setup: WorldSetup, seed: int, ticks: int) -> Unmet:
    """The pedestrian model alone, step by step as a world takes them; the chair is far away."""
    rng = generator(seed, "people")
    blind = np.zeros(len(setup.crowd.radius), dtype=np.bool_)
    crowd, grid, crowds = replace(setup.crowd, sees_robot=blind), setup.grid, []
    outline = setup.robot.outline + _FAR
    for k in range(ticks):
        crowds.append(crowd)
        time, bodies = k * setup.control_step, np.column_stack([crowd.position, crowd.radius])
        grid = present(setup.changes, grid, time, outline, bodies[crowd.there])
        scene = Scene(
            grid=grid,
            robot_position=_FAR,
            robot_velocity=np.zeros(2),
            robot_radius=0.0,
            time=time,
        )
        crowd = setup.pedestrian_model.step(crowd, scene, setup.control_step, rng)
    return Unmet(
        people=np.array([states_of(each) for each in crowds]),
        people_target=np.array([each.target for each in crowds]),
    )
