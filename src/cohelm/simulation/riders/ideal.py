"""Skilled rider: pure pursuit of the desired route, with avoidance of obstacles and people."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.geometry import arc_length, nearest_on_polyline
from cohelm.simulation.api import RiderAct, RiderView
from cohelm.simulation.riders.path_choice import (
    NO_OBSTACLES,
    PathOffset,
    RememberedObstacles,
    SteeringLaw,
    best_offset,
    desired_path,
    steering_of,
    update_obstacles,
)
from cohelm.simulation.riders.rider_input import deflected

_SPEED_RISE = 0.1
"""Maximum increase of the speed share from one call to the next."""
_DEFAULT_OUTLINE = np.array([[0.65, 0.305], [-0.46, 0.305], [-0.46, -0.305], [0.65, -0.305]])
"""Outline of a common powered wheelchair, used if the view has none, m."""


class Ideal:
    """Pure pursuit of the desired route (Coulter 1992), with the stick as a steering wheel.

    The rider knows the size of the chair and steers round obstacles and people where there is
    space, slowly where there is little, and otherwise waits.
    """

    class Parameters(Model):
        """Steering behaviour; assumed."""

        lookahead: float = Field(1.0, gt=0.0, le=5.0)
        """Distance along the route to the point steered for, m."""
        forward: float = Field(0.7, gt=0.0, le=1.0)
        """Forward deflection on a straight route, share of full (the chair's maximum speed)."""
        turn_gain: float = Field(1.2, gt=0.0, le=10.0)
        """Lateral deflection per radian of bearing, 1/rad."""
        slowing_distance: float = Field(1.0, gt=0.0, le=5.0)
        """Distance from the goal at which the rider begins to slow down, m."""
        goal_tolerance: float = Field(0.15, gt=0.0, le=1.0)
        """Distance from the goal at which the stick is released, m."""
        avoids_obstacles: bool = True
        """Steer round obstacles and people."""
        full_speed: float = Field(0.8, gt=0.0, le=5.0)
        """Speed that the rider expects at full forward deflection, m/s …"""
        full_turn_rate: float = Field(1.2, gt=0.0, le=10.0)
        """… and turn rate at full lateral deflection, rad/s."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()

    def act(self, view: RiderView, memory: Any | None, rng: np.random.Generator) -> RiderAct:
        """See :meth:`cohelm.simulation.api.Rider.act`."""
        p = self.parameters
        x, y, heading = view.pose
        distance = math.hypot(view.goal[0] - x, view.goal[1] - y)
        if distance <= p.goal_tolerance:
            return deflected(view, (0.0, 0.0))
        last: _Memory | None = memory
        obstacles = _obstacles(view, last) if p.avoids_obstacles else NO_OBSTACLES
        slowing = min(distance / p.slowing_distance, 1.0)
        if p.avoids_obstacles and (len(obstacles.points) or len(view.people)):
            return self._avoid(view, obstacles, slowing, last)
        aim = lookahead_point(view.route, x, y, p.lookahead) if len(view.route) else view.goal
        bearing = math.remainder(math.atan2(aim[1] - y, aim[0] - x) - heading, 2.0 * math.pi)
        kept = _Memory(time=view.time, twist=view.twist, obstacles=obstacles, speed_share=1.0)
        return self._steer(view, bearing, slowing, kept)

    def _avoid(
        self,
        view: RiderView,
        obstacles: RememberedObstacles,
        slowing: float,
        last: _Memory | None,
    ) -> RiderAct:
        """Choose a path beside the desired one, and steer for it."""
        p, path = self.parameters, desired_path(view)
        choice = best_offset(
            view,
            path,
            obstacles,
            law=SteeringLaw(
                forward=p.forward,
                turn_gain=p.turn_gain,
                lookahead=p.lookahead,
                full=np.array([p.full_speed, p.full_turn_rate]),
            ),
            outline=view.outline if len(view.outline) else _DEFAULT_OUTLINE,
            previous=last.choice if last else None,
            call=last.calls if last else 0,
        )
        bearing, share = steering_of(path, choice, p.lookahead) if choice else (0.0, 0.0)
        share = min(share, last.speed_share + _SPEED_RISE if last else 1.0)
        kept = _Memory(
            time=view.time,
            twist=view.twist,
            obstacles=obstacles,
            speed_share=share,
            choice=choice or (last.choice if last else None),
            calls=last.calls + 1 if last else 1,
        )
        return self._steer(view, bearing, share * slowing, kept)

    def _steer(self, view: RiderView, bearing: float, share: float, kept: _Memory) -> RiderAct:
        p = self.parameters
        forward = p.forward * share * max(math.cos(bearing), 0.0)
        return deflected(view, (forward, min(max(p.turn_gain * bearing, -1.0), 1.0)), kept)


@value
class _Memory:
    time: float
    """Time of the last call, s."""
    twist: Annotated[Floats, Shape("3")]
    obstacles: RememberedObstacles
    speed_share: float
    """Share of the forward deflection."""
    choice: PathOffset | None = None
    """Path chosen last."""
    calls: int = 0
    """Number of choices so far."""


def _obstacles(view: RiderView, last: _Memory | None) -> RememberedObstacles:
    """Obstacles in sight and in memory, moved by the felt motion since the last call."""
    if last is None:
        return update_obstacles(view, NO_OBSTACLES, np.zeros(3))
    motion = 0.5 * (last.twist + view.twist) * (view.time - last.time)
    half = motion[2] / 2.0
    x = motion[0] * math.cos(half) - motion[1] * math.sin(half)
    y = motion[0] * math.sin(half) + motion[1] * math.cos(half)
    return update_obstacles(view, last.obstacles, np.array([x, y, motion[2]]))


def lookahead_point(route: Floats, x: float, y: float, lookahead: float) -> Floats:
    """Point (2,) of a route (k, 2) that lies ``lookahead`` beyond the point nearest to (x, y)."""
    s = arc_length(route)
    at, _ = nearest_on_polyline(route, x, y)
    at += lookahead
    return np.array([np.interp(at, s, route[:, 0]), np.interp(at, s, route[:, 1])])
