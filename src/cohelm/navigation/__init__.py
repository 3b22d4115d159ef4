"""The navigator: the package in which all stages meet."""

from cohelm.navigation.crowding import CrowdingParameters
from cohelm.navigation.destination_inference import DestinationInference, DestinationParameters
from cohelm.navigation.navigator import Navigator
from cohelm.navigation.path_and_reference import planning_reason
from cohelm.navigation.recovery.parameters import RecoveryParameters
from cohelm.navigation.recovery.progress_checker import ProgressParameters
from cohelm.navigation.recovery.stages import (
    RecoveryAction,
    RecoveryStage,
)
from cohelm.navigation.replanning.replanner import ReplanningParameters
from cohelm.navigation.replanning.route_query import PlanReason
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.tick import Memory, Tick

__all__ = [
    "CrowdingParameters",
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
