"""Link to the driver: the page that drives, its last heartbeat, and the action required of it.

A page's heartbeats carry two facts: that it is alive, and its stick position. All functions here
are pure: state, event and time in, new state out. Times are seconds of one monotonic clock; delays
of heartbeats are milliseconds, as ``Heartbeat.sent`` is.

    no_driver ── take control ──► no_heartbeat ── heartbeat ──► state by the required action

    required action   stick deflected                       stick centred
    CENTRE            centre_stick                          ready
    CONFIRM           stick_held                            confirm ── resume ──► ready

    event                                               required action from then on
    control taken                                       CENTRE; CONFIRM if the chair is under way
    no heartbeat for HEARTBEAT_TIMEOUT                  CENTRE; until a heartbeat, no_heartbeat
    … for CONFIRM_AFTER_SILENCE, or the page hidden     CONFIRM; until a heartbeat, no_heartbeat
    the chair's own stick silent for the same times     the same
    STOP, collision, navigator lost or silent           CONFIRM

The chair moves only while the link is ``ready``.

A stick of the chair itself (:class:`ChairStick`) is one more device of the page that drives. A
device that repeats its last event for ever looks alive; the page's heartbeat tells that the rider
is there, so that the stick moves the chair only under a page that drives, and one deflection for
at most MAX_CONSTANT_STICK.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from types import MappingProxyType
from typing import NamedTuple

from cohelm.live.messages import Device, Heartbeat, LinkStatus
from cohelm.reasons import Reason

HEARTBEAT_TIMEOUT = 0.3
"""Time without a heartbeat after which the link is lost, s."""
CONFIRM_AFTER_SILENCE = 2.0
"""Silence after which the driver must confirm as well as centre the stick, s."""
MAX_DELAY_MS = 300.0
"""Maximum delay of a heartbeat beyond the minimum of its connection, ms; a later one is dropped."""
MAX_CONSTANT_STICK = 15.0
"""Time after which a deflected stick of the chair that has not changed must be centred, s; assumed.
A hand can hold the coarse position of such a stick bit for bit, as that of a switched one."""
CLOCK_DRIFT_MS_PER_S = 0.2
"""Assumed drift between the clocks of page and chair: the minimum delay rises at this rate."""


class RequiredAction(IntEnum):
    """Action that the driver must take before the chair may move, in increasing order."""

    NOTHING = 0
    CENTRE = 1
    """Release the stick."""
    CONFIRM = 2
    """Release the stick, and then confirm."""


@dataclass(frozen=True, slots=True, kw_only=True)
class HeartbeatTiming:
    """Timing of one connection's heartbeats."""

    seq: int
    """``Heartbeat.seq`` of the newest one, dropped or not."""
    min_delay: float
    """Minimum time from ``sent`` to arrival, ms, with the unknown offset of the two clocks."""
    updated_at: float
    """Arrival time of the newest one, s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ChairStick:
    """Newest position of the chair's own stick."""

    deflection: tuple[float, float]
    """(forward, left), each −1…1."""
    at: float
    """Time of the device's last message, s."""
    changed_at: float
    """Time of the newest message that was centred or differed from the one before, s."""
    centred: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkState:
    """All connections, and the one that drives."""

    timings: Mapping[str, HeartbeatTiming] = field(default_factory=lambda: MappingProxyType({}))
    driver: str | None = None
    required: RequiredAction = RequiredAction.CENTRE
    cause: Reason | None = None
    """Reason for the required action; None if the drive has just begun."""
    heartbeat: Heartbeat | None = None
    """Newest valid heartbeat of the driver since they took control."""
    heartbeat_at: float = -math.inf
    """Its arrival time, s."""
    centred: bool = False
    """True if its stick is centred."""
    chair_stick: ChairStick | None = None
    """Stick of the chair; None: it has none."""
    epoch: int = 0
    """Grows with every stop and every take-over; older decisions move nothing any more."""


def status(state: LinkState, now: float) -> LinkStatus:
    """Return the state of the link; the chair may move in ``ready`` only."""
    if state.driver is None:
        return "no_driver"
    if not _page_present(state, now) or _chair_stick_silent(state, now):
        return "no_heartbeat"
    if state.required is RequiredAction.NOTHING:
        return "ready"
    if state.centred and _chair_stick_centred(state):
        return "confirm"
    return "stick_held" if state.required is RequiredAction.CONFIRM else "centre_stick"


def deflection(state: LinkState, now: float) -> tuple[float, float]:
    """Return the valid deflection (forward, left); (0, 0) unless the link is ready."""
    if state.heartbeat is None or status(state, now) != "ready":
        return 0.0, 0.0
    if state.chair_stick is not None and state.centred:
        return state.chair_stick.deflection
    return state.heartbeat.forward, state.heartbeat.left


class CurrentHeartbeat(NamedTuple):
    """Valid heartbeat of the driver."""

    seq: int
    """``Heartbeat.seq``; −1: there is none."""
    device: Device


def current_heartbeat(state: LinkState, now: float) -> CurrentHeartbeat:
    """Return the valid heartbeat; −1 and ``none`` without one."""
    if state.heartbeat is None or status(state, now) in {"no_driver", "no_heartbeat"}:
        return CurrentHeartbeat(-1, "none")
    device = state.heartbeat.device
    if state.centred and not _chair_stick_centred(state):
        device = "joystick"
    return CurrentHeartbeat(state.heartbeat.seq, device)


def hold_reason(state: LinkState, now: float) -> Reason | None:
    """Return the reason why the link holds the chair; None while it is ready."""
    found = status(state, now)
    if found == "ready":
        return None
    if found == "no_driver":
        return Reason.NO_DRIVER
    if found == "no_heartbeat":
        present = _page_present(state, now)
        return Reason.STALE_RIDER_COMMAND if present else Reason.CONNECTION_LOST
    return state.cause or required_reason(found)


def required_reason(status: LinkStatus) -> Reason | None:
    """Return the action that the driver must take now; None: nothing."""
    if status == "confirm":
        return Reason.CONFIRM
    return Reason.RELEASE_STICK if status in {"centre_stick", "stick_held"} else None


def take_control(
    state: LinkState, client: str, *, under_way: bool, confirmed: bool = False
) -> LinkState:
    """Make ``client`` the driver; it drives after a heartbeat with a centred stick.

    Args:
        state: Previous state.
        client: Connection that takes control.
        under_way: True if the chair would drive by itself; then the new driver must confirm.
        confirmed: True if they have; ignored while another client drives.
    """
    if client == state.driver:
        return state
    confirm, centre = RequiredAction.CONFIRM, RequiredAction.CENTRE
    confirmed = confirmed and state.driver is None
    waits = not confirmed and (under_way or state.required is confirm)
    return replace(
        state,
        driver=client,
        required=confirm if waits else centre,
        cause=None if confirmed else state.cause,
        heartbeat=None,
        heartbeat_at=-math.inf,
        centred=False,
        epoch=state.epoch + 1,
    )


def release_control(state: LinkState, client: str) -> LinkState:
    """Remove ``client`` as driver; a required confirmation is left to the next driver."""
    if client != state.driver:
        return state
    return replace(
        state,
        driver=None,
        required=max(state.required, RequiredAction.CENTRE),
        heartbeat=None,
        heartbeat_at=-math.inf,
        centred=False,
        epoch=state.epoch + 1,
    )


def disconnect(state: LinkState, client: str) -> LinkState:
    """Remove a connection."""
    timings = {name: timing for name, timing in state.timings.items() if name != client}
    return replace(release_control(state, client), timings=MappingProxyType(timings))


def stop_until_confirmed(state: LinkState, cause: Reason) -> LinkState:
    """Stop until the driver confirms: after STOP, a collision, a restart of the navigator."""
    return replace(state, required=RequiredAction.CONFIRM, cause=cause, epoch=state.epoch + 1)


def require_confirmation(state: LinkState) -> LinkState:
    """Stop until the driver confirms, without another reason."""
    return replace(state, required=RequiredAction.CONFIRM, epoch=state.epoch + 1)


def require_centring(state: LinkState) -> LinkState:
    """Ignore the stick until it has been centred once."""
    centred = state.centred and state.heartbeat is not None and _chair_stick_centred(state)
    if state.required is not RequiredAction.NOTHING or centred:
        return state
    return replace(state, required=RequiredAction.CENTRE, epoch=state.epoch + 1)


def resume(state: LinkState, client: str, now: float) -> LinkState:
    """Accept the driver's confirmation if nothing else is required."""
    if client != state.driver or status(state, now) != "confirm":
        return state
    return replace(state, required=RequiredAction.NOTHING, cause=None)


def on_heartbeat(
    state: LinkState, client: str, beat: Heartbeat, now: float, *, dead_zone: float
) -> LinkState:
    """Process a heartbeat; a repeated, reordered or late one changes the timing only.

    Args:
        state: Previous state.
        client: Connection that sent it.
        beat: Heartbeat.
        now: Arrival time, s.
        dead_zone: Deflection up to which a stick counts as centred.
    """
    timing = state.timings.get(client)
    if timing is not None and beat.seq <= timing.seq:
        return state
    delay = 1000.0 * now - beat.sent
    min_delay = delay
    if timing is not None:
        min_delay = min(
            delay, timing.min_delay + CLOCK_DRIFT_MS_PER_S * max(now - timing.updated_at, 0.0)
        )
    timing = HeartbeatTiming(seq=beat.seq, min_delay=min_delay, updated_at=now)
    state = replace(state, timings=MappingProxyType({**state.timings, client: timing}))
    if client != state.driver or delay - min_delay > MAX_DELAY_MS:
        return state
    return _drivers_heartbeat(state, beat, now, math.hypot(beat.forward, beat.left) <= dead_zone)


def on_chair_stick(
    state: LinkState, deflection: tuple[float, float], at: float, *, dead_zone: float
) -> LinkState:
    """Process the position of the chair's own stick: a gap before it requires an action.

    One that is constant for too long must be centred.

    Args:
        state: Previous state.
        deflection: (forward, left), each −1…1.
        at: Time of the device's last message, s.
        dead_zone: Deflection up to which a stick counts as centred.
    """
    last, required, cause = state.chair_stick, state.required, state.cause
    centred = math.hypot(*deflection) <= dead_zone
    gap = at - last.at if last is not None else 0.0
    if last is None:  # it may be held already
        required = max(required, RequiredAction.CENTRE)
    elif gap > CONFIRM_AFTER_SILENCE:
        required, cause = RequiredAction.CONFIRM, cause or Reason.STALE_RIDER_COMMAND
    elif gap > HEARTBEAT_TIMEOUT:
        required = max(required, RequiredAction.CENTRE)
    changed_at = at
    if last is not None and not centred and deflection == last.deflection:
        changed_at = last.changed_at
    if at - changed_at > MAX_CONSTANT_STICK and required is RequiredAction.NOTHING:
        required, cause = RequiredAction.CENTRE, Reason.STICK_STUCK
    stick = ChairStick(deflection=deflection, at=at, changed_at=changed_at, centred=centred)
    stops = gap > HEARTBEAT_TIMEOUT or required is not state.required
    epoch = state.epoch + (last is not None and stops)
    return replace(state, required=required, cause=cause, chair_stick=stick, epoch=epoch)


def _page_present(state: LinkState, now: float) -> bool:
    beat = state.heartbeat
    recent = now - state.heartbeat_at <= HEARTBEAT_TIMEOUT
    return beat is not None and beat.visible and recent


def _chair_stick_silent(state: LinkState, now: float) -> bool:
    return state.chair_stick is not None and not now - state.chair_stick.at <= HEARTBEAT_TIMEOUT


def _chair_stick_centred(state: LinkState) -> bool:
    return state.chair_stick is None or state.chair_stick.centred


def _drivers_heartbeat(state: LinkState, beat: Heartbeat, now: float, centred: bool) -> LinkState:
    """Process a valid heartbeat of the driver: a gap before it requires an action."""
    required, cause = state.required, state.cause
    gap = now - state.heartbeat_at if state.heartbeat is not None else 0.0
    epoch = state.epoch + (not beat.visible or gap > HEARTBEAT_TIMEOUT)
    if not beat.visible or gap > CONFIRM_AFTER_SILENCE:
        required, cause = RequiredAction.CONFIRM, cause or Reason.CONNECTION_LOST
    elif gap > HEARTBEAT_TIMEOUT:
        required = max(required, RequiredAction.CENTRE)
    if required is RequiredAction.CENTRE and centred and beat.visible:
        required = RequiredAction.NOTHING if _chair_stick_centred(state) else required
    if required is RequiredAction.NOTHING:
        cause = None
    return replace(
        state,
        required=required,
        cause=cause,
        heartbeat=beat,
        heartbeat_at=now,
        centred=centred,
        epoch=epoch,
    )
