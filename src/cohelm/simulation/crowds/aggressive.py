"""People who ignore the chair, as Xu et al. have them; others may walk among them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.config import Model
from cohelm.simulation.api import Crowd, Scene
from cohelm.simulation.crowds.moods import WALKERS, Only, Walk, chosen, entered, walking


class Aggressive:
    """Who walks as if the chair were not there."""

    class Parameters(Model):
        """Nothing is to be set but who, and how they walk otherwise."""

        walk: Walk = WALKERS
        """The pedestrian model among people and walls."""
        only: Only = ()
        """Who is aggressive; empty: everybody."""

    def __init__(self, parameters: Parameters | None = None) -> None:
        self.parameters = parameters or self.Parameters()
        self._walk = walking(self.parameters.walk)

    def enter(self, crowd: Crowd) -> Crowd:
        """The people at time 0, those meant blind to the robot."""
        return self._blind(entered(self._walk, crowd))

    def step(self, crowd: Crowd, scene: Scene, dt: float, rng: np.random.Generator) -> Crowd:
        """See :meth:`cohelm.simulation.api.PedestrianModel.step`."""
        after = self._walk.step(self._blind(crowd), scene, dt, rng)
        return replace(after, sees_robot=crowd.sees_robot)

    def _blind(self, crowd: Crowd) -> Crowd:
        return replace(crowd, sees_robot=crowd.sees_robot & ~chosen(crowd, self.parameters.only))
