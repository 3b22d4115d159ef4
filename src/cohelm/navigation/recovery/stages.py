"""Recovery stages of a ride that makes no progress, one after the other, each with its reason.

    wait      until people step aside
    re-plan   around people who stand, as if they were obstacles
    back up   a little, if the space behind is known to be free
    creep     pass slowly and more closely
    ask       the rider, and keep trying

The names are those of Nav2's behaviours where it has them (wait, back up). At every stage the chair
drives on as soon as it can. A rider who deflects the stick ends the waiting, and the side of the
deflection is the side to pass on. Recovery ends when the ride makes progress again or the chair is
clear of the place where it got stuck.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import StrEnum

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.messages import Side
from cohelm.navigation.recovery.parameters import RecoveryParameters
from cohelm.navigation.recovery.progress_checker import ProgressParameters
from cohelm.reasons import Reason

_ROUNDING = 1e-9  # s; times are sums of float steps
_BACKED_UP = 0.03
"""Backing up is complete at this distance from its end, m."""


class RecoveryStage(StrEnum):
    """Stage of the recovery."""

    WAIT = "wait"
    REPLAN = "replan"
    BACK_UP = "back_up"
    CREEP = "creep"
    ASK = "ask"
    REVERSE = "reverse"
    """Back up along the driven track; see ``reversing``."""
    WAIT_AT_GOAL = "wait_at_goal"
    """Wait for a person at the goal; see ``context.waiting_place``."""


class PeopleNearby(StrEnum):
    """People near enough to wait for."""

    NONE = "none"
    STANDING = "standing"
    WALKING = "walking"


_REASONS = {
    RecoveryStage.WAIT: Reason.WAITING,
    RecoveryStage.REPLAN: Reason.REPLANNING,
    RecoveryStage.BACK_UP: Reason.BACKING_UP,
    RecoveryStage.CREEP: Reason.CREEPING,
    RecoveryStage.ASK: Reason.ASK_RIDER,
    RecoveryStage.WAIT_AT_GOAL: Reason.GOAL_OCCUPIED,
}


_EARLY = frozenset({RecoveryStage.WAIT, RecoveryStage.REPLAN, RecoveryStage.WAIT_AT_GOAL})
"""Stages in which the chair drives as usual if it can."""


@value
class RecoveryContext:
    """Facts on which the stage machine decides."""

    time: float
    """s."""
    position: Annotated[Floats, Shape("2")]
    """m."""
    stands: bool
    """The chair neither moves nor turns."""
    stalled_for: float
    """Time without progress, s."""
    progress_at: float = -np.inf
    """Time of the last progress, s; without any, the time at which the path was planned."""
    planned_at: float = -np.inf
    """Time at which the path was planned, s."""
    searched_at: float = -np.inf
    """Time of the last attempt to plan a path, s."""
    requested_at: float = -np.inf
    """Time of the last path that the rider's request caused, s."""
    people: PeopleNearby = PeopleNearby.NONE
    deflection: Annotated[Floats, Shape("2")]
    """(forward, left) of the rider's stick, shares of full."""
    rear_clearance: float = 0.0
    """Distance that the chair could back up, as far as observed, m."""
    curvature: float = 0.0
    """Curvature of backing up, rad/m."""
    goal_behind: float = np.inf
    """Distance to back up until the goal is abreast, m; ∞: it is not close behind."""


@value
class RecoveryAction:
    """Output of the stage machine; no action if ``stage`` is None."""

    stage: RecoveryStage | None = None
    replans: bool = False
    """Plan another path now, around people who stand."""
    creeps: bool = False
    """Drive slowly, and closer to people than otherwise."""
    takes_over: bool = False
    """The chair drives alone: with the rider's input the ride made no progress."""
    reverses: bool = False
    """The chair may drive backwards."""
    back_up_distance: float = 0.0
    """Remaining distance to back up, m."""
    curvature: float = 0.0
    """Curvature of backing up, rad/m."""
    way_back: Annotated[Floats, Shape("k 3")] | None = None
    """Poses to back up through along the driven track; None: an arc."""
    turns: bool = False
    """The chair backs up because it cannot turn here."""
    stop_at: float = np.inf
    """Arc length on the path at which to wait, m."""
    side: Side = "none"
    """Passing side that the rider selected."""

    def reason(self, *, stands: bool) -> Reason | None:
        """Return the reason to display; at an early stage only if the chair stands."""
        early = self.stage in _EARLY
        if self.stage is RecoveryStage.REVERSE:
            moving = Reason.REVERSING if self.turns else Reason.BACKING_UP
            return moving if self.reverses or not stands else Reason.WAITING
        return None if self.stage is None or (early and not stands) else _REASONS[self.stage]


@value
class RecoveryState:
    """State of the stage machine."""

    stage: RecoveryStage
    since: float
    """Start of the stage, s."""
    began: float
    """Start of the recovery, s."""
    position: Annotated[Floats, Shape("2")]
    """Place where the chair got stuck, m."""
    stood_since: float = np.inf
    """Start of the current standstill within this stage, s; ∞: the chair moves."""
    search_from: float = -np.inf
    """A path planned before this time is not new enough, s."""
    back_up_distance: float = 0.0
    """Distance to back up when the stage began, m."""
    curvature: float = 0.0
    """Curvature of backing up, rad/m."""
    back_up_from: Annotated[Floats, Shape("2")] | None = None
    """Position when backing up began, m."""
    side: Side = "none"
    has_waited_at_goal: bool = False
    """A person stayed at the goal longer than the chair waits."""


def after_waiting_at_goal(state: RecoveryState, time: float) -> RecoveryState:
    """The stage after a wait at the goal that did not help: look for another way, then creep."""
    return replace(
        state,
        stage=RecoveryStage.REPLAN,
        since=time,
        began=time,
        search_from=time,
        has_waited_at_goal=True,
    )


def recovery_step(
    now: RecoveryContext,
    memory: RecoveryState | None,
    parameters: RecoveryParameters,
    progress: ProgressParameters,
) -> tuple[RecoveryAction, RecoveryState | None]:
    """Advance the stage machine by one tick.

    Args:
        now: facts of this tick.
        memory: of the last call; None at first and while the ride makes progress.
        parameters: of the stages.
        progress: definition of progress, and the time without it after which recovery begins.
    """
    p, deflected = parameters, bool(now.deflection.any())
    if memory is not None and _has_recovered(now, memory, p, progress):
        memory = None
    if memory is None:
        released = deflected and now.stands and now.stalled_for >= p.input_delay - _ROUNDING
        if not released and now.stalled_for < progress.time_allowance - _ROUNDING:
            return RecoveryAction(), None
        memory = RecoveryState(
            stage=RecoveryStage.WAIT,
            since=now.time,
            began=now.time,
            position=now.position.copy(),
        )
    state = _with_standstill(now, memory)
    state = _follow_rider(now, state, p) if deflected else _TRANSITIONS[state.stage](now, state, p)
    return _action(now, state, p), state


def _has_recovered(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters, progress: ProgressParameters
) -> bool:
    """Check for progress; a chair that crept or backed up must get clear of the place.

    Beside people who stand it takes twice the distance: a chair that changes the side has moved,
    but has not yet passed them.
    """
    distance = float(np.hypot(*(now.position - state.position)))
    passes = state.stage is RecoveryStage.CREEP and now.people is PeopleNearby.STANDING
    clear = p.clear_distance * (2.0 if passes else 1.0)
    if distance >= clear or now.requested_at > state.began:
        return True
    progressed = now.progress_at > max(state.began, now.planned_at)
    early = state.stage in {RecoveryStage.WAIT, RecoveryStage.REPLAN}
    return early and progressed and distance >= progress.min_progress


def _with_standstill(now: RecoveryContext, state: RecoveryState) -> RecoveryState:
    since = min(state.stood_since, now.time) if now.stands else np.inf
    return state if since == state.stood_since else replace(state, stood_since=since)


def _follow_rider(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters
) -> RecoveryState:
    """Creep at once; a new side also requires a new path."""
    lateral = float(now.deflection[1])
    side: Side = state.side
    if abs(lateral) >= p.side_deflection:
        side = "left" if lateral > 0.0 else "right"
    search_from = now.time if side != state.side else state.search_from
    return replace(_enter(state, RecoveryStage.CREEP, now), side=side, search_from=search_from)


# --- transitions: the same stage, or the one after it; one a tick -----------------------------


def _after_wait(now: RecoveryContext, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    durations = {
        PeopleNearby.NONE: p.wait,
        PeopleNearby.STANDING: max(p.wait, p.wait_for_people),
        PeopleNearby.WALKING: max(p.wait, p.wait_for_people, p.wait_for_walking_people),
    }
    progressed = now.progress_at > now.planned_at  # a new path is no progress
    since = max(state.since, now.progress_at) if progressed else state.since
    if now.time - since + _ROUNDING < durations[now.people]:
        return state
    return replace(_enter(state, RecoveryStage.REPLAN, now), search_from=now.time)


def _after_replan(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters
) -> RecoveryState:
    stood = now.time - max(state.stood_since, state.since) + _ROUNDING
    if stood < p.standstill and _lasted(now, state) < p.new_path_time:
        return state
    distance = min(p.back_up, now.rear_clearance, now.goal_behind)
    if stood < p.standstill or distance < p.min_back_up:
        return _enter(state, RecoveryStage.CREEP, now)
    return replace(
        _enter(state, RecoveryStage.BACK_UP, now),
        back_up_distance=distance,
        curvature=now.curvature,
        back_up_from=now.position.copy(),
    )


def _after_back_up(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters
) -> RecoveryState:
    if _remaining_back_up(now, state) >= _BACKED_UP and _lasted(now, state) < p.back_up_time:
        return state
    return replace(_enter(state, RecoveryStage.CREEP, now), search_from=now.time)


def _after_creep(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters
) -> RecoveryState:
    if _lasted(now, state) < p.creep:
        return state
    return replace(_enter(state, RecoveryStage.ASK, now), search_from=now.time)


def _while_asking(
    now: RecoveryContext, state: RecoveryState, p: RecoveryParameters
) -> RecoveryState:
    if now.time - state.search_from + _ROUNDING < p.replan_interval:
        return state
    return replace(state, search_from=now.time)


_Transition = Callable[[RecoveryContext, RecoveryState, RecoveryParameters], RecoveryState]
# ``REVERSE`` and ``WAIT_AT_GOAL`` are left before this table is asked.
_TRANSITIONS: Mapping[RecoveryStage, _Transition] = {
    RecoveryStage.WAIT: _after_wait,
    RecoveryStage.REPLAN: _after_replan,
    RecoveryStage.BACK_UP: _after_back_up,
    RecoveryStage.CREEP: _after_creep,
    RecoveryStage.ASK: _while_asking,
}


def _lasted(now: RecoveryContext, state: RecoveryState) -> float:
    return now.time - state.since + _ROUNDING


def _enter(state: RecoveryState, stage: RecoveryStage, now: RecoveryContext) -> RecoveryState:
    return replace(state, stage=stage, since=now.time)


def _remaining_back_up(now: RecoveryContext, state: RecoveryState) -> float:
    """Remaining distance to back up, limited by the rear clearance, m."""
    if state.back_up_from is None:
        return 0.0
    travelled = float(np.hypot(*(now.position - state.back_up_from)))
    return min(state.back_up_distance - travelled, now.rear_clearance)


def _action(now: RecoveryContext, state: RecoveryState, p: RecoveryParameters) -> RecoveryAction:
    stage = state.stage
    backs = stage is RecoveryStage.BACK_UP
    creeps = stage in {RecoveryStage.BACK_UP, RecoveryStage.CREEP, RecoveryStage.ASK}
    return RecoveryAction(
        stage=stage,
        replans=now.searched_at < state.search_from,
        creeps=creeps,
        takes_over=stage in {RecoveryStage.BACK_UP, RecoveryStage.CREEP},
        reverses=creeps and now.rear_clearance >= (_BACKED_UP if backs else p.min_back_up),
        back_up_distance=max(_remaining_back_up(now, state), 0.0) if backs else 0.0,
        curvature=state.curvature if backs else 0.0,
        side=state.side,
    )
