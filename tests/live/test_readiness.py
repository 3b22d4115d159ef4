"""What the driver's confirmation cannot end: the chair says so before they try."""

from types import SimpleNamespace

import pytest

from cohelm.live.control.readiness import FAULTS, KEPT, not_ready
from cohelm.live.control.watchdog import CONFIRM_AFTER, Watchdog
from cohelm.live.messages import ResumeCommand, SetMode, StopCommand
from cohelm.messages import Mode
from cohelm.reasons import Reason
from cohelm.safety import stop
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig


@pytest.fixture
def rig():
    rig = Rig(build_scenario(load_scenario("empty"), 0))
    rig.drive()
    return rig


def found(reason=None, decided=None, mode=Mode.SHARED, ready=True, gave_up=False, now=1.0):
    watchdog = Watchdog(decision=stop(decided) if decided else stop(Reason.WAITING), at=1.0)
    navigator = SimpleNamespace(ready=ready, gave_up=gave_up)
    return not_ready(reason, navigator, watchdog, now, mode=mode, simulated=True)


def test_a_stop_of_the_driver_s_own_needs_no_more_than_their_word():
    assert found(Reason.RIDER_STOP) is None
    assert found(Reason.CONFIRM, decided=Reason.NO_PATH) is None


def test_a_navigator_that_decides_nothing_is_waited_for():
    assert found(ready=False) is Reason.NAVIGATOR_RESTARTS
    assert found(ready=False, gave_up=True) is Reason.NAVIGATOR_FAILED
    assert found(now=1.0 + CONFIRM_AFTER + 0.1) is Reason.NAVIGATOR_TIMEOUT
    for reason in (Reason.STARTING, Reason.PAUSED, Reason.PROGRAM_FAILED):
        assert found(reason, ready=False) is reason


def test_a_fault_is_told_until_the_navigator_finds_it_gone():
    assert {found(Reason.RIDER_STOP, decided=each) for each in FAULTS} == FAULTS
    assert found(decided=Reason.POSE_DOUBTFUL) is None  # it only slows down


def test_a_fault_that_manual_mode_does_not_heed_does_not_hold_it():
    assert found(decided=Reason.LOST) is Reason.LOST
    assert found(decided=Reason.LOST, mode=Mode.MANUAL) is None
    assert found(decided=Reason.DRIVE_FAULT, mode=Mode.MANUAL) is Reason.DRIVE_FAULT


def test_pages_hear_of_it_while_the_chair_waits_for_the_driver(rig):
    rig.say(StopCommand())
    rig.steps(3)
    assert rig.state.link == "confirm"
    assert rig.state.not_ready is None
    assert rig.state.can_plan
    rig.navigator.ready = False
    rig.steps(1)
    assert rig.state.not_ready.code == "navigator_restarts"
    assert not rig.state.can_plan
    rig.navigator.ready = True
    rig.steps(1)
    assert rig.state.not_ready is None


def after_odometry_fault(duration):
    """Five seconds of a stick held forward, with odometry of the wrong sign from 1 s on."""
    fault = f"faults=[{{kind: twist_scaled, at: 1.0, duration: {duration}, magnitude: -1.0}}]"
    rig = Rig(build_scenario(load_scenario("empty", [fault]), 0))
    rig.drive()
    rig.say(SetMode(mode=Mode.ASSISTED))
    rig.steps(100, forward=0.5)
    return rig


def test_a_fault_that_is_kept_ends_with_the_driver_s_word():
    """Odometry of the wrong sign for 2 s: the wheels are sound again, and the chair must know."""
    rig = after_odometry_fault(2.0)
    assert rig.world.truth.time > 4.0
    assert rig.state.reason.code in KEPT
    assert rig.state.command == (0.0, 0.0)
    assert rig.state.link == "stick_held"  # the stick alone does not go on
    rig.steps(5, forward=0.0)
    assert rig.state.reason.code in KEPT
    assert rig.state.link == "confirm"
    assert rig.state.not_ready is None
    rig.say(ResumeCommand())
    rig.steps(20, forward=0.5)
    assert rig.state.reason is None
    assert rig.state.speed > 0.1


def test_a_fault_that_lasts_is_found_again():
    rig = after_odometry_fault(99.0)
    rig.steps(5, forward=0.0)
    assert rig.state.reason.code in KEPT
    rig.say(ResumeCommand())
    assert any(abs(state.command[0]) > 0.05 for state in rig.steps(80, forward=0.5))
    assert rig.state.reason.code in KEPT
    assert rig.state.link == "stick_held"
