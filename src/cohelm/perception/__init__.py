"""Perception: scan → clusters → people → predictions, and the live obstacle layer."""

from cohelm.perception.api import Detections, Detector, Predictor, Tracker
from cohelm.perception.given_people import GivenPeople, GivenState
from cohelm.perception.kalman_tracker import KalmanTracker
from cohelm.perception.obstacle_layer import (
    ObstacleLayerParameters,
    ObstacleLayerState,
    update_obstacle_layer,
)
from cohelm.perception.prediction import ConstantVelocity
from cohelm.perception.scan import Returns, returns
from cohelm.perception.scan_clusters import ScanClusters
from cohelm.perception.tracks import TrackerState

__all__ = [
    "ConstantVelocity",
    "Detections",
    "Detector",
    "GivenPeople",
    "GivenState",
    "KalmanTracker",
    "ObstacleLayerParameters",
    "ObstacleLayerState",
    "Predictor",
    "Returns",
    "ScanClusters",
    "Tracker",
    "TrackerState",
    "returns",
    "update_obstacle_layer",
]
