from .episode.episode import Episode, run
from .episode.ride import Outcome, Replan, Ride, StopEvent
from .metrics import measure, pedestrian_delay, pedestrian_deviation, timing
from .perception.crowd_scores import CrowdScores, crowd_scores
from .perception.recording_view import (
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
