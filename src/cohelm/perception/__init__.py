"""Perception: scans and clouds → clusters → people → groups and predictions; live obstacles."""

from cohelm.perception.alone import Alone
from cohelm.perception.api import (
    CloudDetector,
    Detections,
    Detector,
    GroupDetector,
    Predictor,
    Tracker,
)
from cohelm.perception.cloud_clusters import CloudClusters
from cohelm.perception.ego_motion import EgoMotionParameters, Matching, Way, follow
from cohelm.perception.given_people import GivenPeople, GivenState
from cohelm.perception.groups import Affinity, AffinityState
from cohelm.perception.hypotheses import HYPOTHESES, Change, Going, Hypotheses
from cohelm.perception.kalman_tracker import KalmanTracker
from cohelm.perception.modes import ModeState
from cohelm.perception.novelty import NoveltyParameters
from cohelm.perception.obstacle_layer import (
    ObstacleLayerParameters,
    ObstacleLayerState,
    update_obstacle_layer,
)
from cohelm.perception.outlines import Outline, outline_of
from cohelm.perception.perceive import (
    Perceived,
    PerceptionMemory,
    PerceptionParts,
    perceive,
    pose_at,
)
from cohelm.perception.prediction import ConstantVelocity
from cohelm.perception.scan import Returns, returns
from cohelm.perception.scan_clusters import ScanClusters
from cohelm.perception.tracks import TrackerState

__all__ = [
    "HYPOTHESES",
    "Affinity",
    "AffinityState",
    "Alone",
    "Change",
    "CloudClusters",
    "CloudDetector",
    "ConstantVelocity",
    "Detections",
    "Detector",
    "EgoMotionParameters",
    "GivenPeople",
    "GivenState",
    "Going",
    "GroupDetector",
    "Hypotheses",
    "KalmanTracker",
    "Matching",
    "ModeState",
    "NoveltyParameters",
    "ObstacleLayerParameters",
    "ObstacleLayerState",
    "Outline",
    "Perceived",
    "PerceptionMemory",
    "PerceptionParts",
    "Predictor",
    "Returns",
    "ScanClusters",
    "Tracker",
    "TrackerState",
    "Way",
    "follow",
    "outline_of",
    "perceive",
    "pose_at",
    "returns",
    "update_obstacle_layer",
]
