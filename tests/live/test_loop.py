"""The chair's loop with all other work left out: what is said in time, and what has to wait."""

import threading
import time
from types import SimpleNamespace

import pytest

from cohelm.errors import PlatformError
from cohelm.live.control import world_factory
from cohelm.live.control.cycle_state import CycleState
from cohelm.live.control.driver_link import LinkState, RequiredAction
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.mission import Mission
from cohelm.live.control.step_timing import STEP
from cohelm.live.control_loop import MAX_SLOW_CALLS, ControlLoop
from cohelm.live.messages import Destination
from cohelm.reasons import Reason
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Rig

SLOW = 0.02
"""What an errand takes, s."""


class Stand:
    """A chair that only listens."""

    def __init__(self):
        self.preparing, self.load_routes, self.world, self.behind = None, False, None, False
        self.state, self.begun, self.awaited = CycleState(answered_mission=1), [], []

    def await_world(self, *, on):
        self.awaited.append(on)

    def pause(self, *, on):
        pass

    def step(self, due, attend):
        self.begun.append(time.monotonic())
        attend()


def made_loop(cycle, driver, send=lambda *_: None, world_factory=None):
    navigator = SimpleNamespace(
        ready=False, routes=True, starts=1, lost="", unanswered=None, gave_up=False,
        supervise=lambda now, routes: False, close=lambda: None,
    )  # fmt: skip
    route_preview = SimpleNamespace(
        ready_or_failed=True, start=lambda: None, poll=lambda: None, close=lambda: None
    )
    world_factory = world_factory or SimpleNamespace(
        start=lambda seed, when: None, finished=lambda: None, busy=False
    )
    rides = SimpleNamespace(
        navigator_lost=lambda: None,
        retry=lambda: None,
        end=lambda outcome: None,
        waits_for_log=False,
    )
    services = SimpleNamespace(
        navigator=navigator, route_preview=route_preview, world_factory=world_factory, rides=rides
    )
    log_event = lambda *_, **__: None  # noqa: E731
    return ControlLoop(cycle, driver, services, seed=0, cold=False, send=send, log_event=log_event)


@pytest.fixture
def loop():
    driver = DriverState(mission=Mission().with_goal(Destination(name="", x=1.0, y=2.0)))
    loop = made_loop(Stand(), driver)
    loop.start()
    yield loop
    loop.close()


def until(holds, patience=5.0):
    end = time.monotonic() + patience
    while not holds():
        assert time.monotonic() < end, "it never came"
        time.sleep(0.01)


def test_errands_leave_the_chair_its_time_and_make_nobody_wait(loop):
    """However many come: a step is late by one of them at most, and STOP by no more than that."""
    done = []

    def mission():
        time.sleep(SLOW)
        done.append(time.monotonic())

    taken = [loop.submit(mission) for _ in range(3 * MAX_SLOW_CALLS)]
    assert not all(taken)
    assert sum(taken) <= MAX_SLOW_CALLS + 1
    asked, heard = time.monotonic(), threading.Event()
    loop.call(heard.set)
    assert heard.wait(5.0)
    assert time.monotonic() - asked < SLOW + STEP + 0.15  # what a busy machine may add
    began = len(loop.cycle.begun)
    time.sleep(20 * STEP)
    assert len(loop.cycle.begun) - began >= 12
    assert 1 <= len(done) <= 20 * STEP / (5.0 * SLOW)


def test_a_fault_of_the_loop_stops_the_chair_and_pages_still_get_its_state(caplog):
    """The navigator's answer raises while the chair drives at more than 0.1 m/s."""
    rig = Rig(build_scenario(load_scenario("empty"), 0))
    rig.drive()
    assert rig.steps(14, 0.8)[-1].speed > 0.1
    rig.navigator.answer = lambda timeout, now: 1 / 0
    loop = made_loop(rig.cycle, rig.driver, rig.send)
    rig.told.clear()
    loop.start()
    try:
        until(lambda: len(rig.of("state")) > 20)
        heard = threading.Event()
        loop.call(heard.set)
        assert heard.wait(5.0)
    finally:
        loop.close()
    states = rig.of("state")
    assert all(state.command == (0.0, 0.0) for state in states)
    assert states[-1].reason.code == "program_failed"
    assert not rig.world.truth.twist.any()
    assert [notice.code for notice in rig.of("notice")] == ["loop_failed"]
    assert "failed" in loop.error
    assert caplog.text.count("Traceback") == 1


def test_pages_hear_of_a_chair_that_takes_no_command():
    rig = Rig(build_scenario(load_scenario("empty"), 0))
    rig.drive()
    rig.steps(2, 0.8)

    def lost(decision):
        raise PlatformError("the chair is gone")

    loop = made_loop(rig.cycle, rig.driver, rig.send)
    rig.cycle.world.apply = lost
    rig.told.clear()
    loop.start()
    try:
        until(lambda: any(s.reason and s.reason.code == "program_failed" for s in rig.of("state")))
    finally:
        loop.close()


def test_a_world_that_cannot_be_built_leaves_the_drive_in_the_old_one(monkeypatch, caplog):
    def fault(*_):
        raise ValueError("no such thing")

    monkeypatch.setattr(world_factory, "build_scenario", fault)
    told, chair = [], Stand()
    chair.world = SimpleNamespace(close=lambda: None, wait=None)
    factory = world_factory.WorldFactory(None)
    driver = DriverState(link=LinkState(required=RequiredAction.NOTHING))
    loop = made_loop(chair, driver, lambda message, _: told.append(message.code), factory)
    loop.error = "The navigator does not start."
    loop._thread.start()
    try:
        loop.call(lambda: loop.restart_world(7))
        until(lambda: told)
        steps = len(chair.begun)
        until(lambda: len(chair.begun) > steps + 2)
        assert chair.awaited == [True, False]
    finally:
        loop.close()
    assert told == ["world_failed"]
    assert loop.error == "The navigator does not start."  # as before
    assert driver.link.required is RequiredAction.CENTRE
    assert "ValueError: no such thing" in caplog.text
    assert loop._seed == 0


def test_an_errand_that_fails_ends_nothing(loop):
    heard = threading.Event()
    assert loop.submit(lambda: 1 / 0)
    assert loop.submit(heard.set)
    assert heard.wait(5.0)
    assert loop.error == ""


@pytest.mark.parametrize("answered", [1, 0])
def test_what_a_navigator_was_lost_over_is_not_asked_of_the_next_one(loop, answered):
    """The errand has version 1: kept where it was answered before, dropped where it never was."""
    heard = threading.Event()
    loop.cycle.state = CycleState(answered_mission=answered)
    loop._navigator.unanswered = SimpleNamespace(mission_version=1)
    loop._navigator.lost = "no answer"
    until(lambda: loop._driver.link.cause is Reason.NAVIGATOR_TIMEOUT)
    loop.call(heard.set)
    assert heard.wait(5.0)
    assert (loop._driver.mission.goal is not None) == bool(answered)
