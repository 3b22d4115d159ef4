"""Who drives, whether they are there, and what must happen before the chair may move.

A page's beats say two different things: that it is alive, and where its stick is. Everything here
is a pure function of a state, an event and the time; times are seconds of one steady clock.

    nobody ── take ──► silent ── beat ──► centre ── stick let go ──► ready
                         ▲                  ▲           │              │
       300 ms, hidden ───┴──────────────────┼───────────┼──────────────┤
       STOP, longer silence, a restart ─────┴─► … ──► confirm ── resume┘

Whatever else the chair is told, it moves only while the link is ``ready``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from types import MappingProxyType

from cohelm.driving.messages import Beat, Device, Link
from cohelm.reasons import Reason

SILENCE = 0.3
"""A page that has said nothing for longer is silent, s."""
SHORT = 2.0
"""After a silence no longer than this a centred stick suffices, s; after a longer one, or a page
that was hidden, the driver confirms as well."""
LATE = 300.0
"""A beat that took so much longer than the quickest one is dropped, ms."""
DRIFT = 0.2
"""By how much two clocks may drift apart, ms a second: the quickest beat is forgotten as slowly."""


class Need(IntEnum):
    """What the driver must do before the chair may move, least first."""

    NOTHING = 0
    CENTRE = 1
    """Let the stick go."""
    CONFIRM = 2
    """Let it go, and then say to go on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Pulse:
    """What is known of one connection's beats."""

    seq: int
    """Of the newest one, dropped or not."""
    quickest: float
    """Least time from ``sent`` to arrival, ms; both clocks begin anywhere."""
    measured: float
    """When that was found, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkState:
    """All connections, and the one that drives."""

    pulses: Mapping[str, Pulse] = field(default_factory=lambda: MappingProxyType({}))
    driver: str | None = None
    need: Need = Need.CENTRE
    cause: Reason | None = None
    """Why something is needed, where it is more than that a drive begins."""
    beat: Beat | None = None
    """The newest that counts, of who drives, since they took the stick."""
    at: float = -math.inf
    """When it came, s."""
    centred: bool = False
    """Whether its stick is in the middle."""
    turn: int = 0
    """Grows whenever the chair has to stand or somebody else takes the stick: what was decided
    before that moves nothing any more."""


def status(state: LinkState, now: float) -> Link:
    """How things stand; ``ready`` is the only one in which the chair may move."""
    if state.driver is None:
        return "nobody"
    if state.beat is None or not state.beat.visible or not now - state.at <= SILENCE:
        return "silent"
    if state.need is Need.NOTHING:
        return "ready"
    if state.centred:
        return "confirm"
    return "stopped" if state.cause is Reason.RIDER_STOP else "centre"


def deflection(state: LinkState, now: float) -> tuple[float, float]:
    """(forward, left) that counts now; (0, 0) unless the link is ready."""
    if state.beat is None or status(state, now) != "ready":
        return 0.0, 0.0
    return state.beat.forward, state.beat.left


def heard(state: LinkState, now: float) -> tuple[int, Device]:
    """Number and device of the beat that counts now; −1 and none while there is none."""
    if state.beat is None or status(state, now) in {"nobody", "silent"}:
        return -1, "none"
    return state.beat.seq, state.beat.device


def why(state: LinkState, now: float) -> Reason | None:
    """Why the link lets nothing move; None while it is ready."""
    found = status(state, now)
    if found == "ready":
        return None
    if found == "nobody":
        return Reason.NOBODY_DRIVES
    if found == "silent":
        return Reason.PAGE_SILENT
    return state.cause or asks(found)


def asks(status: Link) -> Reason | None:
    """What the driver has to do now; None: nothing."""
    if status == "confirm":
        return Reason.CONFIRM
    return Reason.LET_GO if status in {"centre", "stopped"} else None


def took(state: LinkState, client: str, *, under_way: bool) -> LinkState:
    """``client`` drives from now on, once a beat of theirs shows the stick in the middle.

    Args:
        state: until now.
        client: who takes the stick.
        under_way: the chair has somewhere to go by itself; who takes it over confirms that.
    """
    if client == state.driver:
        return state
    latched = state.need if state.need is Need.CONFIRM else Need.CENTRE
    return replace(
        state,
        driver=client,
        need=Need.CONFIRM if under_way else latched,
        beat=None,
        at=-math.inf,
        centred=False,
        turn=state.turn + 1,
    )


def released(state: LinkState, client: str) -> LinkState:
    """``client`` drives no more; what must be confirmed must still be by whoever comes next."""
    if client != state.driver:
        return state
    need = max(state.need, Need.CENTRE)
    gone = replace(state, driver=None, need=need, beat=None, at=-math.inf, centred=False)
    return replace(gone, turn=state.turn + 1)


def left(state: LinkState, client: str) -> LinkState:
    """A connection is gone."""
    pulses = {name: pulse for name, pulse in state.pulses.items() if name != client}
    return replace(released(state, client), pulses=MappingProxyType(pulses))


def held(state: LinkState, cause: Reason) -> LinkState:
    """Stand until the driver confirms: STOP, a collision, a navigator that had to begin anew."""
    return replace(state, need=Need.CONFIRM, cause=cause, turn=state.turn + 1)


def confirming(state: LinkState) -> LinkState:
    """Stand until the driver confirms, for no other reason than that nobody has yet."""
    return replace(state, need=Need.CONFIRM, turn=state.turn + 1)


def recentred(state: LinkState) -> LinkState:
    """The stick must be let go once before it counts again."""
    if state.need is not Need.NOTHING or (state.centred and state.beat is not None):
        return state
    return replace(state, need=Need.CENTRE, turn=state.turn + 1)


def resumed(state: LinkState, client: str, now: float) -> LinkState:
    """The driver confirms; heeded only where nothing but that is missing."""
    if client != state.driver or status(state, now) != "confirm":
        return state
    return replace(state, need=Need.NOTHING, cause=None)


def beaten(state: LinkState, client: str, beat: Beat, now: float, *, dead_zone: float) -> LinkState:
    """A beat has come; a repeated, reordered or late one changes nothing but what is known of it.

    Args:
        state: until now.
        client: whose.
        beat: what it says.
        now: when it came, s.
        dead_zone: deflection up to which a stick counts as centred.
    """
    pulse = state.pulses.get(client)
    if pulse is not None and beat.seq <= pulse.seq:
        return state
    taken = 1000.0 * now - beat.sent
    quickest = taken
    if pulse is not None:
        quickest = min(taken, pulse.quickest + DRIFT * max(now - pulse.measured, 0.0))
    known = Pulse(seq=beat.seq, quickest=quickest, measured=now)
    state = replace(state, pulses=MappingProxyType({**state.pulses, client: known}))
    if client != state.driver or taken - quickest > LATE:
        return state
    return _followed(state, beat, now, math.hypot(beat.forward, beat.left) <= dead_zone)


def _followed(state: LinkState, beat: Beat, now: float, centred: bool) -> LinkState:
    """The driver's newest beat, and what it asks of them after whatever was before it."""
    need, cause = state.need, state.cause
    silent_for = now - state.at if state.beat is not None else 0.0
    turn = state.turn + (not beat.visible or silent_for > SILENCE)
    if not beat.visible or silent_for > SHORT:
        need, cause = Need.CONFIRM, cause or Reason.PAGE_SILENT
    elif silent_for > SILENCE:
        need = max(need, Need.CENTRE)
    if need is Need.CENTRE and centred and beat.visible:
        need = Need.NOTHING
    if need is Need.NOTHING:
        cause = None
    return replace(state, need=need, cause=cause, beat=beat, at=now, centred=centred, turn=turn)
