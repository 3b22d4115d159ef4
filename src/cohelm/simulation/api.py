"""What the replaceable parts of the simulator are."""

from __future__ import annotations

from dataclasses import field
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, read_only, value
from cohelm.maps import OccupancyGrid
from cohelm.messages import RiderCommand


@value
class Crowd:
    """The true state of the pedestrians; n of them, at most w way-points each."""

    position: Annotated[Floats, Shape("n 2")]
    velocity: Annotated[Floats, Shape("n 2")]
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad."""
    radius: Annotated[Floats, Shape("n")]
    preferred_speed: Annotated[Floats, Shape("n")]
    waypoints: Annotated[Floats, Shape("n w 2")]
    """Where each walks, in order; NaN beyond a person's last."""
    target: Annotated[Integers, Shape("n")]
    """Index of the way-point each is walking to; the number of way-points when done."""
    loop: Annotated[Booleans, Shape("n")]
    """Starts again at the first way-point after the last."""
    sees_robot: Annotated[Booleans, Shape("n")]
    """Avoids the robot."""
    group: Annotated[Integers, Shape("n")] | None = None
    """Who belongs together, by number; −1: nobody's. None: all are alone."""
    present: Annotated[Booleans, Shape("n")] | None = None
    """Who is there; the rest, not there yet or any more, is far away. None: everybody."""
    memory: Annotated[Floats, Shape("n m")] | None = None
    """A pedestrian model's own record."""

    @property
    def there(self) -> Booleans:
        """Who is there, (n,)."""
        return _everybody(len(self.radius)) if self.present is None else self.present


@lru_cache(maxsize=64)
def _everybody(count: int) -> Booleans:
    """(count,) True, which nobody can write to."""
    return read_only(np.ones(count, dtype=np.bool_))


@value
class Scene:
    """What surrounds the pedestrians in one step."""

    grid: OccupancyGrid
    """Everything that truly stands there."""
    robot_position: Annotated[Floats, Shape("2")]
    robot_velocity: Annotated[Floats, Shape("2")]
    """Map frame, m/s."""
    robot_radius: float
    time: float


class PedestrianModel(Protocol):
    """An entry point of ``cohelm.pedestrian_models``.

    One that also has ``enter(crowd) -> Crowd`` is given the people at time 0 by whoever sets the
    stage: it may bring people of its own, give them a memory, or make them blind to the robot.
    Without it, or where it was not called, ``step`` takes people as they are.
    """

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """The crowd ``dt`` later."""
        ...


@value
class RiderView:
    """What a simulated rider can see and feel: own state, own wishes; no internals of the chair.

    n people are in sight; b glances go round from right to left. What lies about the chair is as
    the rider has it before them: in the chair's own frame.
    """

    time: float
    pose: Annotated[Floats, Shape("3")]
    twist: Annotated[Floats, Shape("3")]
    goal: Annotated[Floats, Shape("2")]
    route: Annotated[Floats, Shape("k 2")]
    """The way the rider wants to go, m."""
    people: Annotated[Floats, Shape("n 5")] = field(default_factory=lambda: np.empty((0, 5)))
    """Who is in sight: (x, y, v_x, v_y, radius), over the floor, in the chair's frame."""
    bearings: Annotated[Floats, Shape("b")] = field(default_factory=lambda: np.empty(0))
    """Directions of the glances, in the chair's frame, rad."""
    free: Annotated[Floats, Shape("b")] = field(default_factory=lambda: np.empty(0))
    """How far the floor is free of walls and things there, m; +inf: as far as one sees."""
    outline: Annotated[Floats, Shape("c 2")] = field(default_factory=lambda: np.empty((0, 2)))
    """Corners of the chair, which the rider knows, in its own frame, m; none: nothing is said."""


@value
class RiderAct:
    """What a rider does now, and what they must remember of it."""

    command: RiderCommand | None
    """What the rider's device sends now; None: there is no device."""
    memory: Any | None = None
    """The rider's own record, for the next call; nobody else reads it."""


class Rider(Protocol):
    """An entry point of ``cohelm.riders``, with ``Parameters``; called 20 times a second.

    One whose class says ``looks = False`` never looks about: it is told neither of people nor of
    what stands there, and finding that out is saved.
    """

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """What the rider does now.

        A pure function of view, memory and generator: the rider itself holds nothing that changes.

        Args:
            view: what the rider sees and feels.
            memory: what the last call gave; None at first.
            rng: all chance.
        """
        ...
