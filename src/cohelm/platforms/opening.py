"""Platform of a scenario, opened for one ride."""

from __future__ import annotations

from typing import cast

from cohelm import plugins
from cohelm.errors import ScenarioError
from cohelm.platforms.api import Platform, PlatformPlugin, SimulatedWorld
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
