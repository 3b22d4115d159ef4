"""What a navigator is made of."""

from __future__ import annotations

from cohelm.arrays import value
from cohelm.control import LocalPlanner
from cohelm.maps import CostmapFilter, OccupancyGrid
from cohelm.messages import Crowding, Request
from cohelm.navigation.crowding import CrowdingParameters
from cohelm.navigation.progress import ProgressParameters
from cohelm.navigation.recovery import RecoveryParameters
from cohelm.navigation.replanning import ReplanningParameters
from cohelm.navigation.zones import ZoneParameters
from cohelm.perception import (
    CloudDetector,
    Detector,
    GroupDetector,
    NoveltyParameters,
    ObstacleLayerParameters,
    PerceptionParts,
    Predictor,
    Tracker,
)
from cohelm.planning import Comfort, GlobalPlanner
from cohelm.robots import Robot
from cohelm.safety import GateParameters
from cohelm.sharing import AuthorityParameters
from cohelm.social import SocialModel


@value
class NavigatorSetup:
    """A map, a robot and the parts."""

    grid: OccupancyGrid
    robot: Robot
    global_planner: GlobalPlanner
    local_planner: LocalPlanner
    detector: Detector
    cloud_detector: CloudDetector
    tracker: Tracker
    group_detector: GroupDetector
    predictor: Predictor
    social_model: SocialModel
    filters: tuple[CostmapFilter, ...] = ()
    """Masks over the map: keepout zones and speed limits."""
    heat: Crowding | None = None
    """Where people are known to be."""
    crowding: CrowdingParameters = CrowdingParameters()
    zones: ZoneParameters = ZoneParameters()
    novelty: NoveltyParameters = NoveltyParameters()
    obstacle_layer: ObstacleLayerParameters = ObstacleLayerParameters()
    authority: AuthorityParameters = AuthorityParameters()
    replanning: ReplanningParameters = ReplanningParameters()
    progress: ProgressParameters = ProgressParameters()
    recovery: RecoveryParameters = RecoveryParameters()
    gate: GateParameters = GateParameters()
    comfort: Comfort = Comfort()
    """How a path is driven."""
    goal_tolerance: float = 0.12
    """Distance at which the goal is reached and the chair stays, m."""
    goal_reach: float = 0.16
    """The same for a chair that has become slower than ``goal_crawl``, m."""
    goal_crawl: float = 0.1
    """m/s."""
    window: float = 8.0
    """Half the side of the window in which walls matter to the local planner, m."""

    @property
    def perception(self) -> PerceptionParts:
        """The parts that find people."""
        return PerceptionParts(
            detector=self.detector,
            cloud_detector=self.cloud_detector,
            tracker=self.tracker,
            group_detector=self.group_detector,
            novelty=self.novelty,
        )

    def speed_limit(self, request: Request) -> float:
        """Of robot, request and rider together, m/s."""
        return min(self.robot.max_speed, request.speed_limit, request.profile.preferred_speed)
