"""Platforms: a chair as a ride sees it, simulated or real.

    observation = platform.observe()      # inputs that arrived since the last call
    platform.apply(decision)              # twist to the wheels, for one control step

A ride, the page, the recorder and the watchdog know only :class:`Platform`. A chair of your own is
one class with these four members and a plugin that opens it: ``docs/your-robot.md``.
"""

from cohelm.errors import PlatformError
from cohelm.platforms.api import (
    Capabilities,
    Platform,
    PlatformPlugin,
    SimulatedWorld,
)
from cohelm.platforms.measured import MeasuredTruth
from cohelm.platforms.planar import Planar, PlanarPlatform
from cohelm.platforms.readings import LeadingReadings
from cohelm.platforms.stick_device import (
    StickPlatform,
    WithStick,
    is_simulated,
    open_platform,
    open_simulation,
)

__all__ = [
    "Capabilities",
    "LeadingReadings",
    "MeasuredTruth",
    "Planar",
    "PlanarPlatform",
    "Platform",
    "PlatformError",
    "PlatformPlugin",
    "SimulatedWorld",
    "StickPlatform",
    "WithStick",
    "is_simulated",
    "open_platform",
    "open_simulation",
]
