"""Scenario files, and everything that a ride needs built from one."""

from cohelm.scenarios.build import RideSetup, build_scenario
from cohelm.scenarios.crowd import make_crowd
from cohelm.scenarios.scenario import Scenario, load_scenario, scenario_names

__all__ = [
    "RideSetup",
    "Scenario",
    "build_scenario",
    "load_scenario",
    "make_crowd",
    "scenario_names",
]
