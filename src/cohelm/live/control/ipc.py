"""Values that cross the pipes between the control loop and its processes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.messages import EdgeCells, MapDifferences, NavigatorState, RouteUpdate
from cohelm.live.sessions.records import RideBegin, RideLog
from cohelm.messages import Decision, Observation, Request
from cohelm.scenarios import Scenario
from cohelm.simulation import GroundTruth


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessSetup:
    """Arguments of a new process."""

    scenario: Scenario
    seed: int
    folder: Path | None = None
    """Folder with the sessions; None: none are stored."""
    record: Path | None = None
    """MCAP file of the drive; None: not recorded."""
    changes: MapChanges = NO_CHANGES
    """Contradictions to the map that earlier rides have seen."""
    routes: bool = True
    """False: the code that only routes need is still being compiled."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRequest:
    """Request for one step of the navigator."""

    step_id: int
    """``CycleState.ticks`` of the step; the answer carries the same one."""
    mission_version: int
    """``Mission.version`` that the request belongs to."""
    observation: Observation
    request: Request
    truth: GroundTruth | None
    """Ground truth, for log and recorder only; None: the chair is real."""
    heartbeat_seq: int
    """``Heartbeat.seq`` of the stick position in the observation; −1: none."""
    restart: bool = False
    """Forget all memory: the world has restarted."""
    end: str = ""
    """Final summary of the ride that has ended before this step, JSON; empty: none has."""
    begin: RideBegin | None = None
    """A ride begins with this step."""
    summary: str = ""
    """Summary so far of the ride that goes on, JSON, once a second; empty: not now."""
    planning_context: bool = False
    """Return the planning context, for a route preview."""
    paused: bool = False
    """The simulation is paused: return the planning context only, without a decision."""
    load_routes: bool = False
    """First load the code that only routes need; it takes seconds, and the chair stands."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepAnswer:
    """Result of one step: the decision, and values for the page."""

    step_id: int
    """See ``StepRequest``, as the next two."""
    mission_version: int
    heartbeat_seq: int
    decision: Decision
    arrived: bool = False
    state: NavigatorState | None = None
    """None: the simulation is paused, and no decision was made."""
    route: RouteUpdate | None = None
    """None: the same route as before."""
    differences: MapDifferences | None = None
    """Places where the building differs from the map; None: the same as before."""
    edges: EdgeCells | None = None
    """Edges of the floor; None: the same as before."""
    log: RideLog | None = None
    """The log of this ride, which ended with an earlier request, is complete."""
    unstored: str = ""
    """Reason why the log of the ride or the recording is not stored; empty if they are."""
    planning_context: bytes | None = None
    """Pickled ``PlanningContext``, empty before the first tick; None: not requested. The control
    loop passes it on without opening it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CompileStatus:
    """Progress of the process that compiles."""

    share: float = 0.0
    """What is there, 0…1."""
    left: float | None = None
    """Time left, s; None: not known yet."""
    steerable: bool = False
    """True once a chair without a destination finds all that it needs."""
    done: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessReady:
    """Progress of a new process."""

    done: bool
    """True once it accepts requests."""
    progress: str = ""
    """Name of the next case of the warm-up."""
