"""Platform in the MuJoCo twin: a chair with wheels, casters and motors in an extruded building."""

from __future__ import annotations

from typing import Any

from cohelm.config import Model
from cohelm.errors import PlatformError
from cohelm.messages import Decision, Observation
from cohelm.platforms.api import Capabilities
from cohelm.platforms.twin.twin_chair import TwinChair
from cohelm.scenarios import RideSetup
from cohelm.simulation import World


class Twin:
    """MuJoCo twin of a scenario; needs the extra ``twin``."""

    simulated = True

    class Parameters(Model):
        """No parameters: the scenario and the robot's chassis define the world."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def open(self, setup: RideSetup) -> TwinPlatform:
        """Return the chair at the start of the scenario; equal setups give equal rides.

        Raises:
            PlatformError: MuJoCo is not installed, or the robot has no two driven wheels.
        """
        robot = setup.robot
        if robot.chassis is None:
            raise PlatformError(
                f"robot {robot.name!r} has no chassis for the twin: add 'chassis: {{}}' to its "
                "file, with wheels, casters and masses where they differ"
            )
        if robot.kinematics != "unicycle":
            raise PlatformError(
                f"the twin has two driven wheels, but robot {robot.name!r} is {robot.kinematics}"
            )
        return TwinPlatform(load_mujoco(), setup)


class TwinPlatform:
    """Chair in a world whose mechanics MuJoCo computes.

    Args:
        mujoco: the module.
        setup: built scenario.
    """

    def __init__(self, mujoco: Any, setup: RideSetup) -> None:
        self.chair = TwinChair(mujoco, setup.world)
        """Chair with its model and state, for films and checks; never for the navigator."""
        self._world = World(setup.world, setup.seed, lambda _: self.chair)
        self._capabilities = Capabilities(name="MuJoCo twin", world=self._world)

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


def load_mujoco() -> Any:
    """Import MuJoCo.

    Raises:
        PlatformError: It is not installed, or does not load.
    """
    try:
        import mujoco  # noqa: PLC0415  # an extra, needed here alone
    except ImportError as cause:
        missing = isinstance(cause, ModuleNotFoundError) and cause.name == "mujoco"
        why = "MuJoCo is not installed" if missing else f"MuJoCo does not load ({cause})"
        raise PlatformError(f"{why}: pip install 'cohelm[twin]'") from None
    return mujoco
