"""Rides: scenarios, episodes, and what they measure; and what perception makes of recordings.

What draws has to be asked for by name: ``cohelm.evaluation.filming``.
"""

from cohelm.evaluation.episode import Episode, run
from cohelm.evaluation.metrics import measure, pedestrian_delay, pedestrian_deviation, timing
from cohelm.evaluation.people import make_crowd
from cohelm.evaluation.perceived_crowds import CrowdScores, crowd_scores
from cohelm.evaluation.ride import Outcome, Replan, Ride, Stop
from cohelm.evaluation.scenario import Scenario, load_scenario, scenario_names
from cohelm.evaluation.staging import Stage, set_stage
from cohelm.evaluation.watching import Seen, Tracks, parts_of, perception_of, told, watch

__all__ = [
    "CrowdScores",
    "Episode",
    "Outcome",
    "Replan",
    "Ride",
    "Scenario",
    "Seen",
    "Stage",
    "Stop",
    "Tracks",
    "crowd_scores",
    "load_scenario",
    "make_crowd",
    "measure",
    "parts_of",
    "pedestrian_delay",
    "pedestrian_deviation",
    "perception_of",
    "run",
    "scenario_names",
    "set_stage",
    "timing",
    "told",
    "watch",
]
