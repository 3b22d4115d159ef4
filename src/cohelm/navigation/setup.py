"""Setup of a navigator: map, robot and parts."""

from __future__ import annotations

from cohelm.arrays import value
from cohelm.control import LocalPlanner
from cohelm.health import HealthParameters
from cohelm.maps import CostmapFilter, OccupancyGrid, Places
from cohelm.messages import Crowding, Request
from cohelm.navigation.destination_inference import DestinationParameters
from cohelm.navigation.recovery.parameters import RecoveryParameters
from cohelm.navigation.recovery.progress_checker import ProgressParameters
from cohelm.navigation.replanning.replanner import ReplanningParameters
from cohelm.navigation.zones import ZoneParameters
from cohelm.perception import (
    ChangeDetectionParameters,
    CloudDetector,
    Detector,
    GroundParameters,
    GroupDetector,
    ObstacleLayerParameters,
    PerceptionParts,
    Predictor,
    Tracker,
)
from cohelm.planning import ComfortLimits, GlobalPlanner
from cohelm.robots import Robot
from cohelm.robots.clearance import Clearance
from cohelm.safety import GateParameters
from cohelm.sharing import AuthorityParameters, SteeringParameters, YieldingParameters
from cohelm.social import SocialModel

_CLEARANCE = Clearance()


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
    places: Places = Places()
    """Named places, which are offered to a rider without a destination."""
    heat: Crowding | None = None
    """Heat map of usual crowding."""
    zones: ZoneParameters = ZoneParameters()
    change_detection: ChangeDetectionParameters = ChangeDetectionParameters()
    obstacle_layer: ObstacleLayerParameters = ObstacleLayerParameters()
    ground: GroundParameters = GroundParameters()
    authority: AuthorityParameters = AuthorityParameters()
    steering: SteeringParameters = SteeringParameters()
    yielding: YieldingParameters = YieldingParameters()
    destinations: DestinationParameters = DestinationParameters()
    replanning: ReplanningParameters = ReplanningParameters()
    progress: ProgressParameters = ProgressParameters()
    recovery: RecoveryParameters = RecoveryParameters()
    gate: GateParameters = GateParameters()
    health: HealthParameters = HealthParameters()
    comfort: ComfortLimits = ComfortLimits()
    """Speeds and accelerations along a path."""
    goal_tolerance: float = 0.12
    """Distance at which the chair has arrived, m."""
    goal_slow_tolerance: float = 0.16
    """Distance at which a chair slower than ``goal_slow_speed`` has arrived, m."""
    goal_slow_speed: float = 0.1
    """m/s."""
    window: float = 8.0
    """Half the side of the local planner's window of walls, m."""

    @property
    def perception(self) -> PerceptionParts:
        """Parts of the perception pipeline."""
        return PerceptionParts(
            detector=self.detector,
            cloud_detector=self.cloud_detector,
            tracker=self.tracker,
            group_detector=self.group_detector,
            change_detection=self.change_detection,
            outline=self.robot.outline,
        )

    @property
    def clearance(self) -> Clearance:
        """Clearance from people, for the gate too: the local planner's ``clearance``, if any."""
        return getattr(self.local_planner, "clearance", _CLEARANCE)

    def speed_limit(self, request: Request) -> float:
        """Minimum of the limits of robot, request and rider, m/s."""
        return min(self.robot.max_speed, request.speed_limit, request.profile.preferred_speed)
