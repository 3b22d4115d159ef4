"""The chair's loop with all other work left out: what is said in time, and what has to wait."""

import threading
import time
from types import SimpleNamespace

import pytest

from cohelm.live.control.mission import Mission
from cohelm.live.control_cycle import STEP
from cohelm.live.loop import MAX_WAITING, LiveLoop
from cohelm.live.messages import Destination

SLOW = 0.02
"""What an errand takes, s."""


class Stand:
    """A chair that only listens."""

    def __init__(self):
        self.starting_text, self.world, self.waits = "", None, False
        self.begun, self.held, self.answered_mission = [], threading.Event(), 1

    def hold(self, cause):
        self.held.set()

    def step(self, due, attend):
        self.begun.append(time.monotonic())
        attend()


@pytest.fixture
def loop():
    chair = Stand()
    navigator = SimpleNamespace(
        ready=False, starts=1, lost="", unanswered=None, gave_up=False,
        supervise=lambda now: False, close=lambda: None,
    )  # fmt: skip
    route_preview = SimpleNamespace(
        settled=True, start=lambda: None, poll=lambda: None, close=lambda: None
    )
    world_factory = SimpleNamespace(
        start=lambda seed, when: None, finished=lambda: None, busy=False
    )
    rides = SimpleNamespace(
        navigator_lost=lambda: None, end=lambda outcome: None, waits_for_log=False
    )
    services = SimpleNamespace(
        navigator=navigator, route_preview=route_preview, world_factory=world_factory, rides=rides
    )
    nobody = lambda *_, **__: None  # noqa: E731
    commands = SimpleNamespace(mission=Mission().with_goal(Destination(name="", x=1.0, y=2.0)))
    loop = LiveLoop(chair, commands, services, seed=0, cold=False, send=nobody, log_event=nobody)
    loop.start()
    yield loop
    loop.close()


def test_errands_leave_the_chair_its_time_and_make_nobody_wait(loop):
    """However many come: a step is late by one of them at most, and STOP by no more than that."""
    done = []

    def mission(_):
        time.sleep(SLOW)
        done.append(time.monotonic())

    taken = [loop.submit(mission) for _ in range(3 * MAX_WAITING)]
    assert not all(taken)
    assert sum(taken) <= MAX_WAITING + 1
    asked, heard = time.monotonic(), threading.Event()
    loop.call(lambda _: heard.set())
    assert heard.wait(5.0)
    assert time.monotonic() - asked < SLOW + STEP + 0.15  # what a busy machine may add
    began = len(loop.cycle.begun)
    time.sleep(20 * STEP)
    assert len(loop.cycle.begun) - began >= 12
    assert 1 <= len(done) <= 20 * STEP / (5.0 * SLOW)


def test_a_loop_that_fails_leaves_nothing_at_the_wheels(loop, caplog):
    loop.cycle.order = None
    loop.cycle.step = lambda due, attend: 1 / 0
    end = time.monotonic() + 5.0
    while not loop.error and time.monotonic() < end:
        time.sleep(0.01)
    assert "failed" in loop.error
    assert not loop.cycle.order.twist.any()


def test_an_errand_that_fails_ends_nothing(loop):
    heard = threading.Event()
    assert loop.submit(lambda _: 1 / 0)
    assert loop.submit(lambda _: heard.set())
    assert heard.wait(5.0)
    assert loop.error == ""


@pytest.mark.parametrize("answered", [1, 0])
def test_what_a_navigator_was_lost_over_is_not_asked_of_the_next_one(loop, answered):
    """The errand has version 1: kept where it was answered before, dropped where it never was."""
    heard = threading.Event()
    loop.cycle.answered_mission = answered
    loop._navigator.unanswered = SimpleNamespace(mission=1)
    loop._navigator.lost = "no answer"
    assert loop.cycle.held.wait(5.0)
    loop.call(lambda _: heard.set())
    assert heard.wait(5.0)
    assert (loop._commands.mission.goal is not None) == bool(answered)
