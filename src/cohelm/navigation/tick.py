"""One step of the navigator, whole: what came in, every value between, what went to the wheels.

It binds the values of ``messages`` and each stage's memory, and therefore lives with the
navigator, the only place that knows all stages.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import field
from types import MappingProxyType
from typing import Any

from cohelm.arrays import value
from cohelm.messages import (
    Authority,
    Decision,
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
from cohelm.navigation.behind import Behind
from cohelm.navigation.beyond import Beyond
from cohelm.navigation.crowding import CrowdingState
from cohelm.navigation.progress import ProgressState
from cohelm.navigation.question import Refusal
from cohelm.navigation.recovery import Recovery, RecoveryState
from cohelm.navigation.replanning import RouteState
from cohelm.perception import ObstacleLayerState, PerceptionMemory
from cohelm.safety import GateState
from cohelm.sharing import AuthorityState


@value
class Memory:
    """What each stage needs of the past, under its name."""

    gate: GateState
    perception: PerceptionMemory | None = None
    predictor: Any | None = None
    """The predictor's own record."""
    obstacles: ObstacleLayerState | None = None
    beyond: Beyond | None = None
    crowding: CrowdingState | None = None
    route: RouteState | None = None
    refusal: Refusal | None = None
    progress: ProgressState | None = None
    behind: Behind | None = None
    recovery: RecoveryState | None = None
    authority: AuthorityState | None = None


@value
class Tick:
    """One step; ``last`` of the next one. A stage that did not run left None."""

    observation: Observation
    request: Request
    decision: Decision
    memory: Memory
    people: People
    sensing: Sensing = Sensing.SILENT
    groups: Groups | None = None
    predictions: Predictions | None = None
    spaces: SocialSpaces | None = None
    path: Path | None = None
    reference: Reference | None = None
    """Along the path."""
    authority: Authority | None = None
    recovery: Recovery | None = None
    """What is done about a ride that does not get on; its stage is None while it does."""
    shared: Reference | None = None
    """The path's reference and the rider's hand, blended."""
    plan: LocalPlan | None = None
    trouble: str = ""
    """Why there is no path, in words, with places and widths; empty where there is one."""
    arrived: bool = False
    """At the goal, and standing still is what is wanted."""
    durations: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Thread CPU time by stage, s; the one thing that two equal rides may differ in."""
