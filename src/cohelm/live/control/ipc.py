"""Values that cross the pipes between the control loop and its processes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cohelm.live.messages import RideOutcome
from cohelm.live.sessions.records import RideLog
from cohelm.messages import Decision, Observation, Request
from cohelm.scenarios import Scenario
from cohelm.simulation import GroundTruth

Points = tuple[tuple[float, float], ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessSetup:
    """Arguments of a new process."""

    scenario: Scenario
    seed: int
    record: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRequest:
    """Request for one step of the navigator."""

    number: int
    """Number of the step; the answer carries the same one."""
    mission: int
    """``Mission.version`` that the request belongs to."""
    observation: Observation
    request: Request
    truth: GroundTruth
    """Ground truth, for log and recorder only."""
    heartbeat: int
    """Number of the heartbeat in the observation; −1: none."""
    extra_clearance: float = 0.0
    """Additional distance from people that the therapist requires, m."""
    restart: bool = False
    """Forget all memory: the world has restarted."""
    begin: tuple[str, Path] | None = None
    """A ride begins with this step: its id, and the file for its rows."""
    end: RideOutcome | None = None
    """The ride has ended before this step."""
    planning_context: bool = False
    """Return the planning context, for a route preview."""
    paused: bool = False
    """The simulation is paused: return the planning context only, without a decision."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteView:
    """Route as the page draws it."""

    points: Points
    without_wishes: Points
    length: float
    """m."""
    extra_length: float
    """m."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepAnswer:
    """Result of one step: the decision, and values for the page."""

    number: int
    mission: int
    heartbeat: int
    decision: Decision
    rider_authority: float = 0.0
    arrived: bool = False
    remaining: float | None = None
    """Distance along the route, m."""
    route_error: str = ""
    """Reason why there is no route, where there should be one."""
    route: RouteView | None = None
    """None: the same route as before."""
    plan: tuple[tuple[float, float, float], ...] = ()
    people: tuple[tuple[float, ...], ...] = ()
    """(id, x, y, v_x, v_y, radius, axis, front, side, rear, group) of each person."""
    groups: tuple[Points, ...] = ()
    log: RideLog | None = None
    """Log of the ride that ended with an earlier request."""
    paused: bool = False
    """No decision was made; see ``StepRequest.paused``."""
    planning_context: bytes | None = None
    """Pickled ``PlanningContext``, empty without a destination; None: not requested. The control
    loop passes it on without opening it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessReady:
    """Progress of a new process; ``done`` once it takes requests."""

    done: bool
    progress: str = ""
