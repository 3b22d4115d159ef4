"""CrowdNav cases of our own: other seeds, other layouts, other numbers; walked by our ORCA.

Nothing may be tuned on the recorded cases, so that these exist to be tuned on. Walked from the
recorded starts, the same ORCA repeats the recorded ways.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.crowdnav import DISCOMFORT, DT, GOAL, RADIUS, SPEED, START
from cohelm.maps import FREE, OccupancyGrid
from cohelm.simulation import Orca
from cohelm.simulation.api import Crowd, Scene

Layout = Literal["circle", "square"]
LAYOUTS: tuple[Layout, ...] = ("circle", "square")
CIRCLE = 4.0
"""Radius on which everybody starts who crosses a circle, m."""
SQUARE = 10.0
"""Side of the square that is crossed, m."""
STATES = 101
"""Of every case: 25 s."""
_SEED = 71_000_000
"""Apart from all other seeds."""
_TRIES = 2000


def own_case(layout: Layout, people: int, seed: int) -> Floats:
    """The ways (101, n, 4) of n people who cross a circle or a square, at rest at first."""
    rng = np.random.default_rng([_SEED, seed])
    starts, goals = placed(layout, people, rng)
    return walked(np.hstack([starts, np.zeros((people, 2))]), goals, STATES)


def placed(layout: Layout, people: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Starts and goals (n, 2) as CrowdNav draws them, none too near another or the robot's.

    Args:
        layout: ``circle``: from anywhere on it to the opposite point, both moved by up to half a
            metre; ``square``: from one half of it to the other.
        people: n.
        rng: where they are drawn from.
    """
    starts, goals = np.array([START[:2]]), np.array([GOAL])
    apart = 2.0 * RADIUS + DISCOMFORT
    for _ in range(_TRIES * people):
        if len(starts) == people + 1:
            break
        start, goal = _drawn(layout, rng)
        near = min(np.hypot(*(starts - start).T).min(), np.hypot(*(goals - goal).T).min())
        if near >= apart:
            starts, goals = np.vstack([starts, start]), np.vstack([goals, goal])
    return starts[1:], goals[1:]


def _drawn(layout: Layout, rng: np.random.Generator) -> tuple[Floats, Floats]:
    if layout == "circle":
        angle = rng.uniform(0.0, 2.0 * np.pi)
        start = CIRCLE * np.array([np.cos(angle), np.sin(angle)]) + rng.uniform(-0.5, 0.5, 2)
        return start, -start
    side = rng.choice([-1.0, 1.0])
    across, along = rng.uniform(0.0, 0.5 * SQUARE, 2), rng.uniform(-0.5, 0.5, 2) * SQUARE
    return np.array([side * across[0], along[0]]), np.array([-side * across[1], along[1]])


def walked(states: Floats, goals: Floats, count: int) -> Floats:
    """``count`` states of people who walk to their goals and avoid each other only.

    Args:
        states: (n, 4), the first of them.
        goals: (n, 2).
        count: every quarter of a second.
    """
    out = np.empty((count, *states.shape))
    out[0] = states
    for k in range(1, count):
        offset = goals - out[k - 1, :, :2]
        wanted = offset / np.maximum(np.hypot(*offset.T), SPEED)[:, None] * SPEED
        velocity = avoiding(out[k - 1], wanted, goals)
        out[k] = np.hstack([out[k - 1, :, :2] + DT * velocity, velocity])
    return out


def avoiding(states: Floats, wanted: Floats, goals: Floats, extra_radius: float = 0.01) -> Floats:
    """The velocities (n, 2) that ORCA leaves agents who want ``wanted`` (n, 2), m/s."""
    n = len(states)
    crowd = Crowd(
        position=states[:, :2],
        velocity=states[:, 2:],
        heading=np.zeros(n),
        radius=np.full(n, RADIUS),
        preferred_speed=np.full(n, SPEED),
        waypoints=goals[:, None],
        target=np.zeros(n, dtype=np.int64),
        loop=np.zeros(n, dtype=bool),
        sees_robot=np.zeros(n, dtype=bool),
    )
    orca = Orca(Orca.Parameters(walls=False, extra_radius=extra_radius))
    return orca.velocities(crowd, _NOTHING, wanted, np.full(n, SPEED), DT)


_NOTHING = Scene(
    grid=OccupancyGrid(data=np.full((2, 2), FREE, dtype=np.int8), resolution=1.0, X_MG=np.zeros(3)),
    robot_position=np.zeros(2),
    robot_velocity=np.zeros(2),
    robot_radius=RADIUS,
    time=0.0,
)
