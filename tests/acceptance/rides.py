"""Small rides, tick by tick: what was decided, and how things truly were."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import compose, transform
from cohelm.maps import OccupancyGrid
from cohelm.messages import Reason, Request
from cohelm.navigation import Navigator, Tick
from cohelm.scenarios import RideSetup, build_scenario, load_scenario
from cohelm.simulation import GroundTruth, Nudge, World


@dataclass(frozen=True)
class Log:
    """k ticks."""

    ticks: list[Tick]
    truths: list[GroundTruth]

    @property
    def time(self) -> Floats:
        """True time, (k,), s."""
        return np.array([truth.time for truth in self.truths])

    @property
    def twist(self) -> Floats:
        """What the wheels truly do, (k, 3)."""
        return np.array([truth.twist for truth in self.truths])

    @property
    def pose(self) -> Floats:
        """(k, 3)."""
        return np.array([truth.pose for truth in self.truths])

    @property
    def command(self) -> Floats:
        """What was decided, (k, 3)."""
        return np.array([tick.decision.twist for tick in self.ticks])

    @property
    def reasons(self) -> list[Reason | None]:
        """Of each decision."""
        return [tick.decision.reason for tick in self.ticks]


def stage(name: str, *settings: str, seed: int = 0) -> RideSetup:
    """A scenario that comes with cohelm, with ``dotted.key=value`` settings."""
    return build_scenario(load_scenario(name, settings), seed)


def follow(
    made: RideSetup,
    duration: float,
    asked: Callable[[float], Request] | None = None,
) -> Log:
    """Ride for a while, whatever happens; ``asked`` says what is wanted at a time."""
    world, navigator = World(made.world, made.seed), Navigator(made.navigator)
    log = Log([], [])
    last = None
    while not log.truths or log.truths[-1].time < duration - 1e-9:
        if last is not None:
            world.advance(last.decision)
        request = made.request if asked is None else asked(world.truth.time)
        last = navigator.step(world.observe(), request, last)
        log.ticks.append(last)
        log.truths.append(world.truth)
    return log


def moved(made: RideSetup, X: Floats) -> RideSetup:
    """The same stage in another map frame, whose old axes lie at ``X`` (3,)."""
    turn = np.array([0.0, 0.0, X[2]])
    world, crowd = made.world, made.world.crowd

    def grid(old: OccupancyGrid) -> OccupancyGrid:
        return replace(old, X_MG=compose(X, old.X_MG))

    rider = world.rider
    if isinstance(rider, Nudge) and rider.parameters.near is not None:
        near = tuple(transform(X, np.array(rider.parameters.near)).tolist())
        rider = Nudge(rider.parameters.model_copy(update={"near": near}))
    floor = grid(made.grid)
    return replace(
        made,
        grid=floor,
        start=compose(X, made.start),
        request=replace(made.request, goal=transform(X, made.request.goal)),
        navigator=replace(made.navigator, grid=floor),
        world=replace(
            world,
            grid=grid(world.grid),
            start=compose(X, world.start),
            crowd=replace(
                crowd,
                position=transform(X, crowd.position),
                velocity=transform(turn, crowd.velocity),
                heading=crowd.heading + X[2],
                waypoints=transform(X, crowd.waypoints),
            ),
            rider=rider,
            rider_goal=transform(X, world.rider_goal),
            rider_route=transform(X, world.rider_route),
        ),
    )
