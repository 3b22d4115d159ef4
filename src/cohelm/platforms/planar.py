"""Platform in the planar simulation: time passes with every decision."""

from __future__ import annotations

from cohelm.config import Model
from cohelm.messages import Decision, Observation
from cohelm.platforms.api import Capabilities
from cohelm.scenarios import RideSetup
from cohelm.simulation import World


class Planar:
    """Planar simulation of a scenario: walls, people, sensors and rider."""

    simulated = True

    class Parameters(Model):
        """No parameters: the scenario defines the world."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def open(self, setup: RideSetup) -> PlanarPlatform:
        """Return the chair at the start of the scenario; equal setups give equal rides."""
        return PlanarPlatform(World(setup.world, setup.seed))


class PlanarPlatform:
    """Chair in a simulated world.

    Args:
        world: World at any time; the platform advances it.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._capabilities = Capabilities(name="simulation", world=world)

    @property
    def capabilities(self) -> Capabilities:
        """Ground truth, people and doors."""
        return self._capabilities

    def observe(self) -> Observation:
        """Return the observation of this step."""
        return self._world.observe()

    def apply(self, decision: Decision) -> None:
        """Simulate one control step."""
        self._world.advance(decision)

    def close(self) -> None:
        """Do nothing: a simulation holds no device."""
