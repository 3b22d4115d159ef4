"""The navigator: where the stages meet."""

from cohelm.navigation.course import reason_of
from cohelm.navigation.crowding import CrowdingParameters
from cohelm.navigation.navigator import Navigator
from cohelm.navigation.progress import ProgressParameters
from cohelm.navigation.question import Why
from cohelm.navigation.recovery import Recovery, RecoveryParameters, Stage
from cohelm.navigation.replanning import ReplanningParameters
from cohelm.navigation.setup import NavigatorSetup
from cohelm.navigation.tick import Memory, Tick

__all__ = [
    "CrowdingParameters",
    "Memory",
    "Navigator",
    "NavigatorSetup",
    "ProgressParameters",
    "Recovery",
    "RecoveryParameters",
    "ReplanningParameters",
    "Stage",
    "Tick",
    "Why",
    "reason_of",
]
