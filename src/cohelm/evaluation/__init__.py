"""Rides and their measures, and scores of perception on recordings.

Drawing is not imported here; see ``cohelm.evaluation.perception.film``.
"""

from cohelm.evaluation.episode.episode import Episode, run
from cohelm.evaluation.episode.ride import Outcome, Replan, Ride, StopEvent
from cohelm.evaluation.metrics import measure, pedestrian_delay, pedestrian_deviation, timing
from cohelm.evaluation.perception.crowd_scores import CrowdScores, crowd_scores
from cohelm.evaluation.perception.recording_view import (
    PerceivedFrame,
    RecordingSummary,
    frame_record,
    parts_of,
    perceive_frames,
    perception_of,
)

__all__ = [
    "CrowdScores",
    "Episode",
    "Outcome",
    "PerceivedFrame",
    "RecordingSummary",
    "Replan",
    "Ride",
    "StopEvent",
    "crowd_scores",
    "frame_record",
    "measure",
    "parts_of",
    "pedestrian_delay",
    "pedestrian_deviation",
    "perceive_frames",
    "perception_of",
    "run",
    "timing",
]
