"""People who see the chair late: only when it is near, and then only after a while."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from pydantic import Field

from cohelm.arrays import Booleans, Floats
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


class Inattentive:
    """Who notices the chair within a distance, and avoids it a reaction time later.

    Whoever has noticed it once does not forget it. The record is the time of noticing, s.
    """

    class Parameters(Model):
        """When people come to themselves."""

        walk: Walk = WALKERS
        """The pedestrian model with which they walk, and then avoid."""
        only: Only = ()
        """Who is inattentive; empty: everybody."""
        distance: float = Field(1.5, ge=0.0, le=50.0)
        """From the body to the disc about the chair, within which it is noticed, m (assumed: the
        far end of Hall's personal distance, 1.2 m, and a step)."""
        reaction_time: float = Field(0.5, ge=0.0, le=10.0)
        """From noticing to avoiding, s (assumed: a choice of way takes 0.4 to 0.6 s)."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._walk = walking(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """The people at time 0, who have noticed nothing."""
        return with_own(entered(self._walk, crowd), np.full(len(crowd.radius), np.nan))

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        noticed = self._noticed(crowd, scene)
        inner = replace(without_own(crowd), sees_robot=self._sees(crowd, noticed, scene.time))
        after = self._walk.step(inner, scene, dt, rng)
        return with_own(replace(after, sees_robot=crowd.sees_robot), noticed)

    def _noticed(self, crowd: Crowd, scene: Scene) -> Floats:
        """When each (n,) noticed the chair, s; NaN: not yet."""
        before = remembered(crowd)
        near = crowd.sees_robot & (gap_to_robot(crowd, scene) <= self.parameters.distance)
        return np.where(np.isnan(before) & near, scene.time, before)

    def _sees(self, crowd: Crowd, noticed: Floats, time: float) -> Booleans:
        p = self.parameters
        awake = np.nan_to_num(noticed, nan=np.inf) + p.reaction_time <= time + 1e-9
        return crowd.sees_robot & (awake | ~chosen(crowd, p.only))
