"""Reasons for a stop: what the link holds, and what the driver's confirmation cannot end."""

from __future__ import annotations

from cohelm.health.evidence import RULES
from cohelm.live.control import driver_link
from cohelm.live.control.driver_link import LinkState, RequiredAction
from cohelm.live.control.navigator_client import NavigatorClient
from cohelm.live.control.watchdog import INPUT_FAULTS, Watchdog
from cohelm.messages import Mode
from cohelm.reasons import Reason

FAULTS = INPUT_FAULTS | {reason for reason, rule in RULES.items() if rule.stops}
"""Stops of the safety gate and the health monitor; the chair stands for as long as they last."""
KEPT = frozenset(reason for reason, rule in RULES.items() if rule.stops and rule.latched)
"""Those that a standing chair cannot disprove: the driver decides whether it goes on."""
_ACKNOWLEDGING = KEPT | {Reason.RIDER_STOP, Reason.THERAPIST_STOP, Reason.STOP_PRESSED}
"""Causes of a stop after which the chair waits for the driver's word."""
FAULTS_IN_MANUAL = INPUT_FAULTS | {Reason.DRIVE_FAULT, Reason.STICK_STUCK}
"""Those that stop a chair in ``Mode.MANUAL`` as well."""


def held_by(link: LinkState, watchdog: Watchdog, now: float, *, starting: bool) -> Reason | None:
    """Return the reason for a stop whatever the navigator decides; None: there is none.

    Args:
        link: Link to the driver.
        watchdog: Last decision.
        now: s.
        starting: The navigator has decided nothing in this world, or loads its code of routes.
    """
    if starting:
        return Reason.STARTING
    found = driver_link.hold_reason(link, now)
    if found is None and watchdog.epoch != link.epoch:
        # The decision is older than the last stop or take-over: wait for the next one.
        return Reason.RELEASE_STICK
    return found


def acknowledges(link: LinkState, watchdog: Watchdog, requested: int) -> bool:
    """Check that kept findings end with the next step: the chair waits for its driver.

    Not for as long as it waits: a step with it neither perceives nor plans.

    Args:
        link: Link to the driver.
        watchdog: Last decision.
        requested: ``LinkState.epoch`` at the last request.
    """
    if link.required is RequiredAction.NOTHING or link.cause not in _ACKNOWLEDGING:
        return False
    found = watchdog.decision is not None and watchdog.decision.reason in KEPT
    return found or link.epoch != requested


def not_ready(
    reason: Reason | None,
    navigator: NavigatorClient,
    watchdog: Watchdog,
    now: float,
    *,
    mode: Mode,
    simulated: bool,
) -> Reason | None:
    """Return what the driver's confirmation cannot end; None: it is enough.

    Args:
        reason: Reason of the command at the wheels.
        navigator: Its process.
        watchdog: Last decision.
        now: s.
        mode: Mode in which the chair would drive. A navigator that must not move decides as in
            shared control, so that its reason may be a fault which this mode does not heed.
        simulated: The chair is simulated.
    """
    if reason in {Reason.PROGRAM_FAILED, Reason.PAUSED, Reason.STARTING}:
        return reason
    if not navigator.ready:
        return Reason.NAVIGATOR_FAILED if navigator.gave_up else Reason.NAVIGATOR_RESTARTS
    if watchdog.decision is None or watchdog.silent(now, simulated=simulated):
        return Reason.NAVIGATOR_TIMEOUT
    fault = watchdog.decision.reason
    return fault if fault in (FAULTS_IN_MANUAL if mode is Mode.MANUAL else FAULTS) else None
