"""One navigator step: its input, every intermediate value, and the memory of each stage.

It binds the values of ``messages``, and lives with the navigator because only the navigator knows
all stages.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.health import Health, HealthState
from cohelm.messages import (
    Authority,
    Decision,
    DestinationBelief,
    Groups,
    LocalPlan,
    Observation,
    Path,
    People,
    Predictions,
    Reference,
    Request,
    Sensing,
    SocialSpaces,
)
from cohelm.navigation.destination_inference import DestinationState
from cohelm.navigation.map_openings import MapOpenings
from cohelm.navigation.recovery.progress_checker import ProgressState
from cohelm.navigation.recovery.rear_clearance import RearMemory
from cohelm.navigation.recovery.reversing import ReversingState
from cohelm.navigation.recovery.stages import RecoveryAction, RecoveryState
from cohelm.navigation.replanning.replanner import RouteState
from cohelm.navigation.replanning.route_query import PlanningFailure
from cohelm.navigation.setup import NavigatorSetup
from cohelm.perception import GroundMap, ObstacleLayerState, PerceptionMemory
from cohelm.safety import GateState
from cohelm.sharing import AuthorityState, SteeringState, YieldingState


@value
class Memory:
    """State that each stage passes to its next call; None before the first one."""

    gate: GateState | None = None
    health: HealthState | None = None
    perception: PerceptionMemory | None = None
    predictor: Any | None = None
    """The predictor's own record."""
    obstacles: ObstacleLayerState | None = None
    floor: GroundMap | None = None
    openings: MapOpenings | None = None
    route: RouteState | None = None
    planning_failure: PlanningFailure | None = None
    progress: ProgressState | None = None
    rear: RearMemory | None = None
    track: Annotated[Floats, Shape("k 3")] | None = None
    """Poses of the last metres that the chair drove forward."""
    reversing: ReversingState | None = None
    recovery: RecoveryState | None = None
    authority: AuthorityState | None = None
    steering: SteeringState | None = None
    yielding: YieldingState | None = None
    destinations: DestinationState | None = None
    last_contact: float = -math.inf
    """Time when a walking person last touched the chair, s."""


@value
class Tick:
    """Result of one step, and ``last`` of the next one. A stage that did not run left None."""

    observation: Observation
    request: Request
    decision: Decision
    memory: Memory
    people: People
    health: Health = Health()
    """Judgement of the health monitor."""
    sensing: Sensing = Sensing.SILENT
    groups: Groups | None = None
    predictions: Predictions | None = None
    spaces: SocialSpaces | None = None
    path: Path | None = None
    reference: Reference | None = None
    """Along the path."""
    authority: Authority | None = None
    recovery: RecoveryAction | None = None
    """Recovery action; its stage is None while the ride makes progress."""
    shared: Reference | None = None
    """Reference along the path, blended with the rider's input."""
    plan: LocalPlan | None = None
    planning_error: str = ""
    """Text of the planning error, with places and widths; empty if there is a path."""
    destinations: DestinationBelief | None = None
    """Inferred destinations; None with a chosen destination, and on a map without places."""
    arrived: bool = False
    """At the goal, where the chair should stand still."""
    durations: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Thread CPU time by stage, s; the only field in which two equal rides may differ."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepInput:
    """Input of every stage in one step."""

    setup: NavigatorSetup
    observation: Observation
    """Checked, see ``safety.check_input``."""
    request: Request
    """With the speed limits of the map."""
    memory: Memory
    """Memory of the previous step."""
    commanded: Floats | None = None
    """Twist (3,) that the wheels were sent last."""
