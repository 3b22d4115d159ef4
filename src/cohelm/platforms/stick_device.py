"""Stick at this computer as the rider's device of any platform: USB, Bluetooth.

Linux tells changes only (``/dev/input/js0``): the last position holds until the next event, also
if the stick's battery is empty. Therefore it moves a chair only under a page that drives; see
``live.control.driver_link``.

``open_platform`` opens the platform of a scenario for one ride, with a stick where one is named.
"""

from __future__ import annotations

import os
import struct
import threading
from typing import cast

import numpy as np
from pydantic import Field

from cohelm import plugins
from cohelm.arrays import replace
from cohelm.config import Model
from cohelm.errors import PlatformError, ScenarioError
from cohelm.messages import Decision, Observation, RiderCommand
from cohelm.platforms.api import Capabilities, Platform, PlatformPlugin, SimulatedWorld
from cohelm.plugins import Spec
from cohelm.scenarios import RideSetup, Scenario
from cohelm.scenarios.scenario import PLATFORM


def is_simulated(scenario: Scenario) -> bool:
    """Check that the scenario's platform is a simulation, without opening it.

    Raises:
        PluginError: There is no such platform, or it does not import.
    """
    name = str(scenario.platform.get("use", PLATFORM))
    return bool(getattr(plugins.load("platforms", name), "simulated", False))


def open_platform(setup: RideSetup) -> Platform:
    """Open the platform that the scenario names.

    Raises:
        PluginError: There is no such platform, or it does not import.
        ScenarioError: Its parameters do not fit.
        PlatformError: It does not answer.
    """
    return open_spec(setup.scenario.platform, setup)


def open_spec(spec: plugins.Spec, setup: RideSetup) -> Platform:
    """Open the platform of a specification; see :func:`open_platform`."""
    built = plugins.build(
        "platforms", spec, file=setup.scenario.file, key="platform", error=ScenarioError
    )
    return cast(PlatformPlugin, built).open(setup)


def open_simulation(setup: RideSetup) -> tuple[Platform, SimulatedWorld]:
    """Open the platform of a ride that is evaluated, with its ground truth.

    Raises:
        ScenarioError: The platform is no simulation.
        PluginError, PlatformError: See :func:`open_platform`.
    """
    platform = open_platform(setup)
    world = platform.capabilities.world
    if world is None:
        platform.close()
        problem = f"{platform.capabilities.name} is no simulation: use 'cohelm drive'"
        raise ScenarioError(problem, file=setup.scenario.file, key="platform")
    return platform, world


NEVER = -10.0
"""Time of the last message of a stick that is gone, s: older than every limit."""
_EVENT = struct.Struct("IhBB")
"""Time, ms; value; type; number (linux/joystick.h)."""
_AXIS, _INITIAL = 0x02, 0x80
_FULL = 32767
"""Value at full deflection."""


class StickDevice:
    """Stick read in a thread of its own.

    Args:
        path: As ``/dev/input/js0``.
        forward_axis: Number of the axis that is negative when pushed forward.
        left_axis: Number of the axis that is negative when pushed to the left.

    Raises:
        PlatformError: It cannot be read.
    """

    def __init__(self, path: str, forward_axis: int, left_axis: int) -> None:
        try:
            self._file = os.open(path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as cause:
            raise PlatformError(f"stick {path}: {cause.strerror}") from None
        os.set_blocking(self._file, True)
        self._axes = {forward_axis: 0, left_axis: 1}
        self._position = [0.0, 0.0]
        self.gone = False
        """True if the device cannot be read any more."""
        threading.Thread(target=self._read, name="stick", daemon=True).start()

    @property
    def deflection(self) -> tuple[float, float]:
        """Newest position (forward, left), each −1…1."""
        forward, left = self._position
        return forward, left

    def close(self) -> None:
        """Let the device go; the thread ends with its next event."""
        self.gone = True

    def _read(self) -> None:
        try:
            while not self.gone:
                event = os.read(self._file, _EVENT.size)
                if len(event) < _EVENT.size:
                    break
                _, value, kind, number = _EVENT.unpack(event)
                if kind & ~_INITIAL == _AXIS and number in self._axes:
                    self._position[self._axes[number]] = -min(max(value / _FULL, -1.0), 1.0)
        except OSError:  # unplugged, or out of range for longer than the driver waits
            pass
        finally:
            self.gone = True
            os.close(self._file)


class WithStick:
    """Platform with a stick at this computer."""

    simulated = False

    class Parameters(Model):
        """Stick and platform."""

        platform: Spec = Field(default_factory=lambda: {"use": "ros2"})
        """Platform that is driven."""
        device: str = Field("/dev/input/js0", min_length=1)
        forward_axis: int = Field(1, ge=0, le=63)
        """Axis that is negative when pushed forward."""
        left_axis: int = Field(0, ge=0, le=63)
        """Axis that is negative when pushed to the left."""

    def __init__(self, parameters: Parameters) -> None:
        self.parameters = parameters

    def open(self, setup: RideSetup) -> StickPlatform:
        """Open stick and platform.

        Raises:
            PlatformError: One of them does not answer, or the platform is a simulation.
        """
        p = self.parameters
        stick = StickDevice(p.device, p.forward_axis, p.left_axis)
        try:
            platform = open_spec(p.platform, setup)
        except BaseException:
            stick.close()
            raise
        if platform.capabilities.simulation:
            stick.close()
            platform.close()
            raise PlatformError("a simulation takes the page's stick, not one at this computer")
        return StickPlatform(platform, stick)


class StickPlatform:
    """Platform whose observations have the position of a stick.

    Args:
        platform: Chair.
        stick: Its rider's device; both are closed with the platform.
    """

    def __init__(self, platform: Platform, stick: StickDevice) -> None:
        self._platform, self._stick = platform, stick

    @property
    def capabilities(self) -> Capabilities:
        """Abilities of the chair."""
        return self._platform.capabilities

    def observe(self) -> Observation:
        """Return the chair's observation with the stick, whose time is now unless it is gone."""
        seen, stick = self._platform.observe(), self._stick
        heartbeat = NEVER if stick.gone else seen.time
        rider = RiderCommand(heartbeat=heartbeat, deflection=np.array(stick.deflection))
        return replace(seen, rider=rider)

    def apply(self, decision: Decision) -> None:
        """Send a command to the chair."""
        self._platform.apply(decision)

    def close(self) -> None:
        """Stop the chair, and release both."""
        self._stick.close()
        self._platform.close()
