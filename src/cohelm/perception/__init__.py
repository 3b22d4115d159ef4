"""Perception: scans and clouds → detections → people → groups and predictions; live obstacles."""

from cohelm.perception.api import (
    CloudDetector,
    Detections,
    Detector,
    GroupDetector,
    Predictor,
    Tracker,
)
from cohelm.perception.change_detection.past_scans import ChangeDetectionParameters
from cohelm.perception.cloud_detection.cloud_clusters import CloudClusters
from cohelm.perception.groups.affinity import Affinity, NoGroups
from cohelm.perception.laser_odometry.ego_motion import (
    EgoMotion,
    EgoMotionParameters,
    MatchStatus,
    update_ego_motion,
)
from cohelm.perception.laser_odometry.scan_features import ScanFeatures, extract_features
from cohelm.perception.obstacles.obstacle_layer import (
    ObstacleLayerParameters,
    ObstacleLayerState,
    update_obstacle_layer,
)
from cohelm.perception.perceive import (
    PerceptionMemory,
    PerceptionParts,
    PerceptionResult,
    perceive,
    pose_at,
)
from cohelm.perception.prediction.constant_velocity import ConstantVelocity
from cohelm.perception.prediction.hypotheses import (
    HYPOTHESES,
    Hypotheses,
)
from cohelm.perception.preprocessing.scan_returns import ScanReturns, scan_returns
from cohelm.perception.scan_detection.scan_clusters import ScanClusters
from cohelm.perception.tracking.given_people import GivenPeople
from cohelm.perception.tracking.kalman_tracker import KalmanTracker

__all__ = [
    "HYPOTHESES",
    "Affinity",
    "ChangeDetectionParameters",
    "CloudClusters",
    "CloudDetector",
    "ConstantVelocity",
    "Detections",
    "Detector",
    "EgoMotion",
    "EgoMotionParameters",
    "GivenPeople",
    "GroupDetector",
    "Hypotheses",
    "KalmanTracker",
    "MatchStatus",
    "NoGroups",
    "ObstacleLayerParameters",
    "ObstacleLayerState",
    "PerceptionMemory",
    "PerceptionParts",
    "PerceptionResult",
    "Predictor",
    "ScanClusters",
    "ScanFeatures",
    "ScanReturns",
    "Tracker",
    "extract_features",
    "perceive",
    "pose_at",
    "scan_returns",
    "update_ego_motion",
    "update_obstacle_layer",
]
