"""What the replaceable parts of the simulator are."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
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
    """An entry point of ``cohelm.pedestrian_models``."""

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """The crowd ``dt`` later."""
        ...


@value
class RiderView:
    """What a simulated rider can see and feel: own state, own wishes; no internals of the chair."""

    time: float
    pose: Annotated[Floats, Shape("3")]
    twist: Annotated[Floats, Shape("3")]
    goal: Annotated[Floats, Shape("2")]
    route: Annotated[Floats, Shape("k 2")]
    """The way the rider wants to go, m."""


class Rider(Protocol):
    """An entry point of ``cohelm.riders``, with ``Parameters``; called 20 times a second."""

    def command(self, view: RiderView, rng: np.random.Generator) -> RiderCommand | None:
        """What the rider's device sends now; None: there is no device.

        A pure function of the view and the generator; what must be remembered depends on time.
        """
        ...
