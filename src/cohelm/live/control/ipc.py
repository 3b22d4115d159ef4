"""Values that cross the pipes between the control loop and its processes."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from cohelm.health import NO_CHANGES, MapChanges
from cohelm.live.messages import MapDifference, RideOutcome, RouteCause
from cohelm.live.sessions.records import RideLog
from cohelm.messages import Decision, Observation, Request
from cohelm.scenarios import Scenario
from cohelm.simulation import GroundTruth

Points = tuple[tuple[float, float], ...]
"""Points of a line in the map frame, m."""
Poses = tuple[tuple[float, float, float], ...]
"""Poses (x, y, heading) in the map frame, m and rad."""


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


class RideBegin(NamedTuple):
    """Beginning of a ride."""

    ride: str
    """Id of the ride."""
    rows: Path
    """File for its rows."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepRequest:
    """Request for one step of the navigator."""

    step_id: int
    """``ControlCycle.ticks`` of the step; the answer carries the same one."""
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
    end: RideOutcome | None = None
    """The ride has ended before this step."""
    begin: RideBegin | None = None
    """A ride begins with this step."""
    planning_context: bool = False
    """Return the planning context, for a route preview."""
    paused: bool = False
    """The simulation is paused: return the planning context only, without a decision."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteView:
    """Route as the page draws it."""

    points: Points
    """About 0.1 m apart; empty: there is no route."""
    without_wishes: Points
    """Route without the wishes; empty: there is no route."""
    length: float
    """m."""
    extra_length: float
    """Difference from the route without wishes, m."""
    cause: RouteCause = "first"


class PersonRow(NamedTuple):
    """Tracked person as the page draws them: map frame, m, m/s, rad."""

    id: float
    x: float
    y: float
    vx: float
    vy: float
    radius: float
    axis: float
    """Direction of the largest extent of the social space, rad."""
    front: float
    """Extent of the social space ahead along the axis, m; next aside and behind."""
    side: float
    rear: float
    group: float
    """Id of the person's group; −1: none."""
    seen: float
    """1: a scanner sees them now; 0: remembered."""


class OfferRow(NamedTuple):
    """Destination that the rider may choose by one press."""

    name: str
    slot: int
    """Position among the offers, 0…2."""
    highlighted: bool
    why: str
    """Why it is believed, in the rider's words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StepAnswer:
    """Result of one step: the decision, and values for the page."""

    step_id: int
    """See ``StepRequest``, as the next two."""
    mission_version: int
    heartbeat_seq: int
    decision: Decision
    rider_authority: float = 0.0
    """Rider's share of control, 0…1."""
    arrived: bool = False
    remaining: float | None = None
    """Distance along the route, m; None: there is no route."""
    route_error: str = ""
    """Reason why there is no route, if there should be one."""
    route: RouteView | None = None
    """None: the same route as before."""
    plan: Poses = ()
    """Poses of the next two seconds."""
    people: tuple[PersonRow, ...] = ()
    groups: tuple[Points, ...] = ()
    """Outlines of the groups' spaces."""
    offers: tuple[OfferRow, ...] = ()
    """Destinations that the rider may want; empty with a destination."""
    free: tuple[float, ...] = ()
    """Free distance in each direction, see :mod:`.surroundings`."""
    differences: tuple[MapDifference, ...] | None = None
    """Places where the building differs from the map; None: the same as before."""
    log: RideLog | None = None
    """Log of the ride that ended with an earlier request."""
    unstored: str = ""
    """Reason why rows or recording are not stored; empty if they are."""
    paused: bool = False
    """No decision was made; see ``StepRequest.paused``."""
    planning_context: bytes | None = None
    """Pickled ``PlanningContext``, empty before the first tick; None: not requested. The control
    loop passes it on without opening it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessReady:
    """Progress of a new process."""

    done: bool
    """True once it accepts requests."""
    progress: str = ""
    """Name of the next case of the warm-up."""
