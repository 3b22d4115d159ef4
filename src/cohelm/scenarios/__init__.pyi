from .build import RideSetup, build_scenario
from .crowd import make_crowd
from .scenario import Scenario, load_scenario, scenario_names

__all__ = [
    "RideSetup",
    "Scenario",
    "build_scenario",
    "load_scenario",
    "make_crowd",
    "scenario_names",
]
