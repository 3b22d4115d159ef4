"""Interfaces of pedestrian models and riders."""

from __future__ import annotations

import math
from dataclasses import field
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, read_only, value
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import RiderCommand


@value
class Crowd:
    """True state of n pedestrians with at most w way-points each."""

    position: Annotated[Floats, Shape("n 2")]
    velocity: Annotated[Floats, Shape("n 2")]
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad."""
    radius: Annotated[Floats, Shape("n")]
    preferred_speed: Annotated[Floats, Shape("n")]
    waypoints: Annotated[Floats, Shape("n w 2")]
    """Way-points in order; NaN beyond a person's last."""
    target: Annotated[Integers, Shape("n")]
    """Index of the current way-point; the number of way-points when done."""
    loop: Annotated[Booleans, Shape("n")]
    """Start again at the first way-point after the last."""
    sees_robot: Annotated[Booleans, Shape("n")]
    """Avoid the robot."""
    group: Annotated[Integers, Shape("n")] | None = None
    """Group number; −1: alone. None: all are alone."""
    present: Annotated[Booleans, Shape("n")] | None = None
    """False for people who have not come yet or have left, who are far away. None: all True."""
    memory: Annotated[Floats, Shape("n m")] | None = None
    """Private state of the pedestrian model, a row for each person; NaN: none yet."""

    @property
    def there(self) -> Booleans:
        """Mask (n,) of people who are present."""
        return _all_true(len(self.radius)) if self.present is None else self.present


@lru_cache(maxsize=64)
def _all_true(count: int) -> Booleans:
    """Return (count,) True, read-only."""
    return read_only(np.ones(count, dtype=np.bool_))


@value
class CrowdScene:
    """Surroundings of the pedestrians in one step."""

    grid: OccupancyGrid
    """True obstacles."""
    robot_position: Annotated[Floats, Shape("2")]
    robot_velocity: Annotated[Floats, Shape("2")]
    """Map frame, m/s."""
    robot_radius: float
    """Radius of the disc about the robot's outline, m; ``robot_position`` is its centre."""
    time: float
    robot_heading: float = 0.0
    """Direction of the robot's x axis, rad."""
    robot_outline: Annotated[Floats, Shape("c 2")] = field(default_factory=lambda: np.empty((0, 2)))
    """Corners of the robot, m; empty: only the disc is known."""

    def robot_discs(self) -> Floats:
        """Discs (k, 3), (x, y, radius), m: a row along the robot that covers its outline.

        There are as many as its length has widths, rounded up; without an outline the one disc.
        """
        if len(self.robot_outline) == 0:
            return np.array([[*self.robot_position, self.robot_radius]])
        corners = transform([0.0, 0.0, -self.robot_heading], self.robot_outline)
        low, size = corners.min(axis=0), np.ptp(corners, axis=0)
        count = math.ceil(size[0] / size[1] - 1e-9)
        x = low[0] + size[0] * (np.arange(count) + 0.5) / count
        centres = np.column_stack([x, np.full(count, low[1] + size[1] / 2.0)])
        radius = np.full(count, math.hypot(size[0] / count, size[1]) / 2.0)
        return np.column_stack([transform([0.0, 0.0, self.robot_heading], centres), radius])


class PedestrianModel(Protocol):
    """Entry point of ``cohelm.pedestrian_models``; see ``docs/own-pedestrians.md``.

    A model may also have ``enter(crowd) -> Crowd``, which is called with the people at time 0: it
    may add people, give them a memory, or make them blind to the robot. ``step`` must accept a
    crowd for which it was not called.
    """

    def step(self, crowd: Crowd, scene: CrowdScene, dt: float, rng: np.random.Generator) -> Crowd:
        """Return the crowd ``dt`` later; called once in a control step, before the robot moves.

        While the robot moves, people go straight from the old to the new positions. Nobody else
        changes a crowd, so the model

        - moves ``position`` and sets ``velocity``, over the floor;
        - turns ``heading`` (:func:`cohelm.simulation.turned_towards`);
        - advances ``target`` for each way-point within 0.5 m, the last one within 0.2 m; after the
          last it is 0 again for a ``loop``, else the number of way-points, and the person stays
          (:func:`cohelm.simulation.advance_targets`);
        - leaves absent people (``crowd.there``) where they are, and keeps them from affecting
          others; ignores the robot for those who do not ``sees_robot``;
        - keeps radius, preferred speed, way-points, loop, sees_robot and group.

        It is a pure function of its arguments: what it must remember is ``crowd.memory``, and all
        randomness comes from ``rng``. Equal arguments give equal bits. A person who joins the ride
        later has NaN as memory.

        Args:
            crowd: people now.
            scene: walls, robot and time now.
            dt: s.
            rng: of the people alone.
        """
        ...


@value
class RiderView:
    """Perception of a simulated rider: motion, destination and surroundings; no internal state.

    n people are in sight; b viewing directions go from right to left. Surroundings are in the
    chair's frame.
    """

    time: float
    pose: Annotated[Floats, Shape("3")]
    twist: Annotated[Floats, Shape("3")]
    goal: Annotated[Floats, Shape("2")]
    route: Annotated[Floats, Shape("k 2")]
    """Desired route, m."""
    people: Annotated[Floats, Shape("n 5")] = field(default_factory=lambda: np.empty((0, 5)))
    """People in sight: (x, y, v_x, v_y, radius), velocity over the floor, in the chair's frame."""
    bearings: Annotated[Floats, Shape("b")] = field(default_factory=lambda: np.empty(0))
    """Viewing directions in the chair's frame, rad."""
    free: Annotated[Floats, Shape("b")] = field(default_factory=lambda: np.empty(0))
    """Free distance in each direction, m; +inf: as far as the rider sees."""
    outline: Annotated[Floats, Shape("c 2")] = field(default_factory=lambda: np.empty((0, 2)))
    """Corners of the chair in its own frame, m; empty: unknown."""


@value
class RiderAct:
    """Input of a rider, and the rider's state."""

    command: RiderCommand | None
    """Message of the rider's device; None: there is no device."""
    memory: Any | None = None
    """Private state of the rider, for the next call."""


class Rider(Protocol):
    """Entry point of ``cohelm.riders``, with ``Parameters``; called 20 times a second.

    A class with ``needs_view = False`` gets neither people nor obstacles, which saves computing
    them.
    """

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """Return the input of the rider now.

        A pure function of its arguments: the rider itself holds nothing that changes.

        Args:
            view: perception of the rider.
            memory: of the last call; None at first.
            rng: source of all randomness.
        """
        ...
