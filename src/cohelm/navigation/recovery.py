"""What is done about a ride that does not get on, one thing after the other, each with its reason.

    wait      for whoever may step aside
    re-plan   round those who stand, as if they were things
    back up   a little, where the space behind has been seen to be free
    creep     squeeze past slowly
    ask       the rider, and go on trying

The names are those of Nav2's behaviours where it has them (wait, back up). The chair goes on as
soon as it can at every stage; a rider who pushes the stick ends waiting, and the side pushed to is
taken. It is over when the ride has got on, or the chair is clear of where it stuck.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from enum import StrEnum

import numpy as np
from pydantic import Field

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import Model
from cohelm.messages import Side
from cohelm.navigation.progress import ProgressParameters
from cohelm.reasons import Reason

_ROUNDING = 1e-9  # s; times are sums of float steps
_DONE = 0.03
"""So far from the end of backing up it is done, m."""


class Stage(StrEnum):
    """What is being done about it."""

    WAIT = "wait"
    REPLAN = "replan"
    BACK_UP = "back_up"
    CREEP = "creep"
    ASK = "ask"


class Company(StrEnum):
    """Who is near enough to be waited for."""

    NOBODY = "nobody"
    STANDING = "standing"
    WALKING = "walking"


_WORDS = {
    Stage.WAIT: Reason.WAITING,
    Stage.REPLAN: Reason.REPLANNING,
    Stage.BACK_UP: Reason.BACKING_UP,
    Stage.CREEP: Reason.CREEPING,
    Stage.ASK: Reason.ASK_RIDER,
}


class RecoveryParameters(Model):
    """How long each stage lasts; assumed. ``ProgressParameters.patience`` says when it begins."""

    wait: float = Field(1.0, ge=0.0, le=120.0)
    """How long to wait where nobody is near, s."""
    wait_for_people: float = Field(2.0, ge=0.0, le=120.0)
    """The same where somebody stands near, s."""
    wait_for_walkers: float = Field(8.0, ge=0.0, le=120.0)
    """The same while somebody walks near, who will be gone soon, s."""
    near: float = Field(3.0, ge=0.0, le=20.0)
    """People within this of the chair are waited for, m."""
    walking: float = Field(0.3, ge=0.0, le=3.0)
    """From which speed somebody walks, m/s."""
    settle: float = Field(0.5, ge=0.0, le=10.0)
    """A chair that stands for so long on a new path does not get on there either, s."""
    another_way: float = Field(6.0, ge=0.0, le=120.0)
    """How long a new path is given while the chair moves, s."""
    back_up: float = Field(0.4, ge=0.0, le=0.5)
    """How far the chair backs up at most, m; 0: never."""
    least: float = Field(0.1, gt=0.0, le=0.5)
    """Less room behind than this is none, m."""
    back_up_speed: float = Field(0.2, gt=0.0, le=1.0)
    """m/s; at most ``progress.creep``."""
    back_up_time: float = Field(4.0, ge=0.0, le=30.0)
    """How long backing up may take, s."""
    recent: float = Field(8.0, ge=0.0, le=120.0)
    """Where the chair itself was within this time is taken to be free as if it had been seen, s."""
    creep: float = Field(8.0, ge=0.0, le=120.0)
    """How long to creep before the rider is asked, s."""
    look_again: float = Field(5.0, gt=0.0, le=120.0)
    """How often another way is looked for while the rider is asked, s."""
    clear: float = Field(1.0, gt=0.0, le=10.0)
    """So far from where it got stuck the chair has left the place, m."""
    push: float = Field(1.0, ge=0.0, le=30.0)
    """A rider who pushes is followed at once where the chair has stood without getting on for so
    long, s."""
    push_aside: float = Field(0.2, ge=0.0, le=1.0)
    """Deflection from which a push has a side, share of full."""


@value
class Situation:
    """What there is to judge by."""

    time: float
    """s."""
    position: Annotated[Floats, Shape("2")]
    """m."""
    stands: bool
    """The chair neither moves nor turns."""
    stalled_for: float
    """How long the way left has not become shorter, s."""
    got_on_at: float = -np.inf
    """When it last did, s; when the path was planned where it never did since."""
    planned_at: float = -np.inf
    """When the path was planned, s."""
    looked_at: float = -np.inf
    """When a path was last looked for, s."""
    wanted_at: float = -np.inf
    """When a path was planned because the rider wanted another one, s."""
    company: Company = Company.NOBODY
    deflection: Annotated[Floats, Shape("2")]
    """(forward, left) of the rider's stick, shares of full."""
    room_behind: float = 0.0
    """How far the chair could go back, as has been seen, m."""
    bend: float = 0.0
    """By how much it would turn on the way back, rad/m."""
    goal_behind: float = np.inf
    """How far back the goal is abreast of the chair, m; ∞: it does not lie close behind."""


@value
class Recovery:
    """What to do now; nothing where ``stage`` is None."""

    stage: Stage | None = None
    replans: bool = False
    """Another way is to be looked for now, round those who stand."""
    squeezes: bool = False
    """Slowly, and closer to people than otherwise."""
    leads: bool = False
    """The chair finds its way out alone: where the hand led the ride does not get on."""
    reverses: bool = False
    """The chair may drive backwards."""
    back: float = 0.0
    """How far to go back from here, m."""
    bend: float = 0.0
    """By how much to turn on the way back, rad/m."""
    side: Side = "none"
    """On which the rider wants to pass."""

    def reason(self, *, stands: bool) -> Reason | None:
        """What the rider is told; a chair that goes on at an early stage needs no excuse."""
        if self.stage is None or (self.stage in {Stage.WAIT, Stage.REPLAN} and not stands):
            return None
        return _WORDS[self.stage]


@value
class RecoveryState:
    """What recovery remembers."""

    stage: Stage
    since: float
    """When the stage began, s."""
    began: float
    """When it all began, s."""
    at: Annotated[Floats, Shape("2")]
    """Where the chair got stuck, m."""
    stood_since: float = np.inf
    """Since when the chair stands, within this stage, s; ∞: it does not."""
    look_from: float = -np.inf
    """A path looked for before this is not new enough, s."""
    back: float = 0.0
    """How far the chair was to go back, m."""
    bend: float = 0.0
    """By how much it was to turn on the way, rad/m."""
    back_from: Annotated[Floats, Shape("2")] | None = None
    """From where, m."""
    side: Side = "none"


def recovery(
    now: Situation,
    memory: RecoveryState | None,
    parameters: RecoveryParameters,
    pace: ProgressParameters,
) -> tuple[Recovery, RecoveryState | None]:
    """What to do about a ride that does not get on, and what to remember of it.

    Args:
        now: what there is to judge by.
        memory: of the last call; None at first and while the ride gets on.
        parameters: of the stages.
        pace: what getting on is, and how long without it until this begins.
    """
    p, pushes = parameters, bool(now.deflection.any())
    if memory is not None and _over(now, memory, p, pace):
        memory = None
    if memory is None:
        tie = pushes and now.stands and now.stalled_for >= p.push - _ROUNDING
        if not tie and now.stalled_for < pace.patience - _ROUNDING:
            return Recovery(), None
        memory = RecoveryState(
            stage=Stage.WAIT, since=now.time, began=now.time, at=now.position.copy()
        )
    state = _stood(now, memory)
    state = _pushed(now, state, p) if pushes else _next(now, state, p)
    return _done(now, state, p), state


def _over(
    now: Situation, state: RecoveryState, p: RecoveryParameters, pace: ProgressParameters
) -> bool:
    """A chair that squeezes past, or has backed up, must get clear of the place."""
    away = float(np.hypot(*(now.position - state.at)))
    if away >= p.clear or now.wanted_at > state.began:
        return True
    got_on = now.got_on_at > max(state.began, now.planned_at)
    return state.stage in {Stage.WAIT, Stage.REPLAN} and got_on and away >= pace.least


def _stood(now: Situation, state: RecoveryState) -> RecoveryState:
    since = min(state.stood_since, now.time) if now.stands else np.inf
    return state if since == state.stood_since else replace(state, stood_since=since)


def _pushed(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    aside = float(now.deflection[1])
    side: Side = state.side
    if abs(aside) >= p.push_aside:
        side = "left" if aside > 0.0 else "right"
    look = now.time if side != state.side else state.look_from
    return replace(_entered(state, Stage.CREEP, now), side=side, look_from=look)


def _next(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    """The same stage, or the one after it; one a tick."""
    return _STEPS[state.stage](now, state, p)


def _lasted(now: Situation, state: RecoveryState) -> float:
    return now.time - state.since + _ROUNDING


def _waited(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    waits = {
        Company.NOBODY: p.wait,
        Company.STANDING: max(p.wait, p.wait_for_people),
        Company.WALKING: max(p.wait, p.wait_for_people, p.wait_for_walkers),
    }
    if _lasted(now, state) < waits[now.company]:
        return state
    return replace(_entered(state, Stage.REPLAN, now), look_from=now.time)


def _replanned(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    stood = now.time - max(state.stood_since, state.since) + _ROUNDING
    if stood < p.settle and _lasted(now, state) < p.another_way:
        return state
    wanted = min(p.back_up, now.room_behind, now.goal_behind)
    if stood < p.settle or wanted < p.least:
        return _entered(state, Stage.CREEP, now)
    begun = _entered(state, Stage.BACK_UP, now)
    return replace(begun, back=wanted, bend=now.bend, back_from=now.position.copy())


def _backed_up(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    if _back_left(now, state) >= _DONE and _lasted(now, state) < p.back_up_time:
        return state
    return replace(_entered(state, Stage.CREEP, now), look_from=now.time)


def _crept(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    if _lasted(now, state) < p.creep:
        return state
    return replace(_entered(state, Stage.ASK, now), look_from=now.time)


def _asked(now: Situation, state: RecoveryState, p: RecoveryParameters) -> RecoveryState:
    if now.time - state.look_from + _ROUNDING < p.look_again:
        return state
    return replace(state, look_from=now.time)


_STEPS: Mapping[Stage, Callable[[Situation, RecoveryState, RecoveryParameters], RecoveryState]] = {
    Stage.WAIT: _waited,
    Stage.REPLAN: _replanned,
    Stage.BACK_UP: _backed_up,
    Stage.CREEP: _crept,
    Stage.ASK: _asked,
}


def _entered(state: RecoveryState, stage: Stage, now: Situation) -> RecoveryState:
    return replace(state, stage=stage, since=now.time)


def _back_left(now: Situation, state: RecoveryState) -> float:
    """How far to go back yet, as far as it is seen to be free, m."""
    if state.back_from is None:
        return 0.0
    gone = float(np.hypot(*(now.position - state.back_from)))
    return min(state.back - gone, now.room_behind)


def _done(now: Situation, state: RecoveryState, p: RecoveryParameters) -> Recovery:
    stage = state.stage
    backs = stage is Stage.BACK_UP
    squeezes = stage in {Stage.BACK_UP, Stage.CREEP, Stage.ASK}
    return Recovery(
        stage=stage,
        replans=now.looked_at < state.look_from,
        squeezes=squeezes,
        leads=stage in {Stage.BACK_UP, Stage.CREEP},
        reverses=squeezes and now.room_behind >= (_DONE if backs else p.least),
        back=max(_back_left(now, state), 0.0) if backs else 0.0,
        bend=state.bend if backs else 0.0,
        side=state.side,
    )
