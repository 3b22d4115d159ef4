from .api import (
    CloudDetector,
    Detections,
    Detector,
    GroupDetector,
    Predictor,
    Tracker,
)
from .change_detection.past_scans import ChangeDetectionParameters
from .cloud_detection.cloud_clusters import CloudClusters
from .ground.ground_map import FloorEdges, GroundMap, GroundParameters
from .groups.affinity import Affinity, NoGroups
from .obstacles.obstacle_layer import (
    ObstacleLayerParameters,
    ObstacleLayerState,
    update_obstacle_layer,
)
from .pipeline import (
    PerceptionMemory,
    PerceptionParts,
    PerceptionResult,
    perceive,
    pose_at,
)
from .prediction.constant_velocity import ConstantVelocity
from .preprocessing.scan_returns import ScanReturns, scan_returns
from .scan_detection.scan_clusters import ScanClusters
from .tracking.given_people import GivenPeople
from .tracking.kalman_tracker import KalmanTracker

__all__ = [
    "Affinity",
    "ChangeDetectionParameters",
    "CloudClusters",
    "CloudDetector",
    "ConstantVelocity",
    "Detections",
    "Detector",
    "FloorEdges",
    "GivenPeople",
    "GroundMap",
    "GroundParameters",
    "GroupDetector",
    "KalmanTracker",
    "NoGroups",
    "ObstacleLayerParameters",
    "ObstacleLayerState",
    "PerceptionMemory",
    "PerceptionParts",
    "PerceptionResult",
    "Predictor",
    "ScanClusters",
    "ScanReturns",
    "Tracker",
    "perceive",
    "pose_at",
    "scan_returns",
    "update_obstacle_layer",
]
