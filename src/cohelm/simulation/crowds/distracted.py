"""People who do not see the chair and turn back beside it, as Xu et al. have them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Floats, Integers
from cohelm.config import Model
from cohelm.simulation.api import Crowd, Scene
from cohelm.simulation.crowds.moods import (
    WALKERS,
    Only,
    Walk,
    chosen,
    entered,
    gap_to_robot,
    remembered,
    walking,
    with_own,
    without_own,
)


class Distracted:
    """Who turns once, back to the way-point they come from, and then goes on again.

    How fast they turn is the other model's: with ``orca`` its agility, 1.1 m/s about in 0.37 s. The
    record is the time of the turn, s.
    """

    class Parameters(Model):
        """When people turn."""

        walk: Walk = WALKERS
        """The pedestrian model with which they walk."""
        only: Only = ()
        """Who is distracted; empty: everybody."""
        distance: float = Field(1.5, ge=0.0, le=50.0)
        """From the body to the disc about the chair, at which they turn, m (assumed; nothing is
        harder than a turn right beside the chair)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._walk = walking(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """The people at time 0: those meant are blind to the robot, and nobody has turned."""
        crowd = entered(self._walk, crowd)
        blind = crowd.sees_robot & ~chosen(crowd, self.parameters.only)
        return with_own(replace(crowd, sees_robot=blind), np.full(len(crowd.radius), np.nan))

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        who = chosen(crowd, self.parameters.only)
        turned, target = self._turned(crowd, scene)
        inner = replace(without_own(crowd), sees_robot=crowd.sees_robot & ~who, target=target)
        after = self._walk.step(inner, scene, dt, rng)
        return with_own(replace(after, sees_robot=crowd.sees_robot), turned)

    def _turned(self, crowd: Crowd, scene: Scene) -> tuple[Floats, Integers]:
        """When each (n,) turned, s, NaN: not yet; and their targets (n,)."""
        before = remembered(crowd)
        near = gap_to_robot(crowd, scene) <= self.parameters.distance
        now = np.isnan(before) & near & chosen(crowd, self.parameters.only) & (crowd.target > 0)
        return np.where(now, scene.time, before), np.where(now, crowd.target - 1, crowd.target)
