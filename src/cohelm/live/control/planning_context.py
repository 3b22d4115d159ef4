"""Inputs of route planning besides the map, passed from the navigator to a route preview."""

from __future__ import annotations

import pickle
from dataclasses import dataclass

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import LiveObstacles, Request, Wish
from cohelm.navigation import Tick
from cohelm.scenarios import RideSetup


@dataclass(frozen=True, slots=True, kw_only=True)
class PlanningContext:
    """Pose, profile and live obstacles of the chair."""

    pose: Floats
    """(3,), X_MR."""
    clearance: float
    """m."""
    speed: float
    """Preferred speed, m/s."""
    live: LiveObstacles | None


def planning_context_of(tick: Tick, request: Request) -> bytes:
    """Return the pickled context of a tick.

    Args:
        tick: Last tick.
        request: Current request; it differs from the tick's after a pause only.
    """
    memory = tick.memory
    context = PlanningContext(
        pose=tick.observation.pose,
        clearance=request.profile.clearance,
        speed=request.profile.preferred_speed,
        live=memory.obstacles.obstacles if memory.obstacles is not None else None,
    )
    return pickle.dumps(context, protocol=5)


def warm_up_wishes(ride_setup: RideSetup) -> tuple[Wish, ...]:
    """Return one wish of each kind, so that their code is compiled before a rider waits for it."""
    middle = ride_setup.route.points[len(ride_setup.route.points) // 2]
    aside = middle + np.array([0.5, 0.5])
    return (
        Wish(points=aside[None]),  # a point on the route would cost nothing
        Wish(kind="stroke", points=np.array([middle, aside])),
        Wish(kind="avoid", points=middle[None], radius=0.5),
    )
