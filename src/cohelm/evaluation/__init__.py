"""Rides: scenarios, episodes, and what they measure."""

from cohelm.evaluation.episode import Episode, run
from cohelm.evaluation.metrics import measure, pedestrian_delay, pedestrian_deviation, timing
from cohelm.evaluation.people import make_crowd
from cohelm.evaluation.ride import Outcome, Replan, Ride, Stop
from cohelm.evaluation.scenario import Scenario, load_scenario, scenario_names
from cohelm.evaluation.staging import Stage, set_stage

__all__ = [
    "Episode",
    "Outcome",
    "Replan",
    "Ride",
    "Scenario",
    "Stage",
    "Stop",
    "load_scenario",
    "make_crowd",
    "measure",
    "pedestrian_delay",
    "pedestrian_deviation",
    "run",
    "scenario_names",
    "set_stage",
    "timing",
]
