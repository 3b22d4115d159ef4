"""First contact of a motion with walls and people: one answer for planners and safety gate.

The footprint is ``Robot.capsule`` against people and ``Robot.discs`` against walls; both contain
it. Motions are swept: tested between poses as well (0.16 s at 2.4 m/s closing speed is 0.38 m).
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats
from cohelm.kernels import CACHED
from cohelm.maps import DistanceField
from cohelm.messages import People, Predictions
from cohelm.robots.capsule import gap_to_disc
from cohelm.robots.contact_kernel import TOUCHING, Bodies, ContactMargins, contact_kernel
from cohelm.robots.robot import Robot
from cohelm.robots.wall_contact import wall_grid


def first_contact(
    robot: Robot,
    poses: Floats,
    step: float,
    *,
    people: People,
    predictions: Predictions,
    walls: DistanceField,
    margins: ContactMargins,
    paces: Floats | None = None,
) -> float:
    """Time when a motion first touches a wall or, while moving, a predicted body, s; else +inf.

    Arguments as of :func:`contact_times`.
    """
    bodies = _bodies(people, predictions, paces)
    grid = wall_grid(walls)
    times = contact_kernel(robot.capsule, robot.discs, poses, step, bodies, grid, margins, True)
    return float(times.min())


def contact_times(
    robot: Robot,
    poses: Floats,
    step: float,
    *,
    people: People,
    predictions: Predictions,
    walls: DistanceField,
    margins: ContactMargins,
    paces: Floats | None = None,
) -> Floats:
    """Times (1 + n,) when a motion first touches a wall, and each person while moving; else +inf.

    Args:
        robot: its footprint is tested.
        poses: of the motion, (k, 3); straight lines between them.
        step: between poses, s.
        people: their radii and present speeds.
        predictions: of these people; beyond the end they keep their velocity.
        walls: distance to everything that is not a person.
        margins: gaps that count as contact.
        paces: (n,) of people, m/s, see ``ContactMargins.growth``; None: their speeds.
    """
    bodies = _bodies(people, predictions, paces)
    grid = wall_grid(walls)
    return contact_kernel(robot.capsule, robot.discs, poses, step, bodies, grid, margins, False)


def _bodies(people: People, predictions: Predictions, paces: Floats | None) -> Bodies:
    """The arrays of predictions."""
    if paces is None:
        paces = np.hypot(people.mean[:, 2], people.mean[:, 3])
    return Bodies(
        predictions.mean,
        predictions.velocity,
        predictions.weight,
        people.radius,
        paces,
        predictions.step,
    )


def touching(robot: Robot, pose: Floats, people: People, gap: float = TOUCHING) -> Booleans:
    """Mask of the people (n,) who touch a robot at ``pose`` now, within sensor accuracy.

    gap: below which they touch it, m; negative: they overlap its footprint by so much.
    """
    return _touching(robot.capsule, np.asarray(pose, dtype=float), people.mean, people.radius, gap)


@njit(**CACHED)
def _touching(
    capsule: Floats, pose: Floats, people: Floats, radius: Floats, gap: float
) -> Booleans:
    out = np.empty(people.shape[0], dtype=np.bool_)
    for i in range(people.shape[0]):
        out[i] = gap_to_disc(capsule, pose, people[i, 0], people[i, 1], radius[i]) < gap
    return out
