from .destination_inference import DestinationInference, DestinationParameters
from .navigator import Navigator
from .path_and_reference import planning_reason
from .recovery.parameters import RecoveryParameters
from .recovery.progress_checker import ProgressParameters
from .recovery.stages import (
    RecoveryAction,
    RecoveryStage,
)
from .replanning.replanner import ReplanningParameters
from .replanning.route_query import PlanReason
from .setup import NavigatorSetup
from .tick import Memory, Tick

__all__ = [
    "DestinationInference",
    "DestinationParameters",
    "Memory",
    "Navigator",
    "NavigatorSetup",
    "PlanReason",
    "ProgressParameters",
    "RecoveryAction",
    "RecoveryParameters",
    "RecoveryStage",
    "ReplanningParameters",
    "Tick",
    "planning_reason",
]
