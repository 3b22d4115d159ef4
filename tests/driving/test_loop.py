"""The chair's loop with all other work left out: what is said in time, and what has to wait."""

import threading
import time
from types import SimpleNamespace

import pytest

from cohelm.driving.chair import STEP
from cohelm.driving.loop import MOST_ERRANDS, Loop
from cohelm.driving.messages import Goal
from cohelm.driving.wanted import Errand

SLOW = 0.02
"""What an errand takes, s."""


class Stand:
    """A chair that only listens."""

    def __init__(self):
        self.preparing, self.play, self.waits = "", None, False
        self.begun, self.held, self.answered = [], threading.Event(), 1

    def hold(self, cause):
        self.held.set()

    def step(self, due, attend):
        self.begun.append(time.monotonic())
        attend()


@pytest.fixture
def loop():
    chair = Stand()
    thinking = SimpleNamespace(
        ready=False, begun=1, lost="", owed=None, hopeless=False,
        attend=lambda now: False, close=lambda: None,
    )  # fmt: skip
    pricing = SimpleNamespace(
        settled=True, begin=lambda: None, attend=lambda: None, close=lambda: None
    )
    playing = SimpleNamespace(make=lambda seed, when: None, made=lambda: None, busy=False)
    outings = SimpleNamespace(lost=lambda: None, end=lambda outcome: None, owing=False)
    crew = SimpleNamespace(thinking=thinking, pricing=pricing, playing=playing, outings=outings)
    nobody = lambda *_, **__: None  # noqa: E731
    hearing = SimpleNamespace(errand=Errand().to(Goal(name="", x=1.0, y=2.0)))
    loop = Loop(chair, hearing, crew, seed=0, cold=False, tell=nobody, note=nobody)
    loop.start()
    yield loop
    loop.close()


def test_errands_leave_the_chair_its_time_and_make_nobody_wait(loop):
    """However many come: a step is late by one of them at most, and STOP by no more than that."""
    done = []

    def errand(_):
        time.sleep(SLOW)
        done.append(time.monotonic())

    taken = [loop.bid(errand) for _ in range(3 * MOST_ERRANDS)]
    assert not all(taken)
    assert sum(taken) <= MOST_ERRANDS + 1
    asked, heard = time.monotonic(), threading.Event()
    loop.say(lambda _: heard.set())
    assert heard.wait(5.0)
    assert time.monotonic() - asked < SLOW + STEP + 0.15  # what a busy machine may add
    began = len(loop.chair.begun)
    time.sleep(20 * STEP)
    assert len(loop.chair.begun) - began >= 12
    assert 1 <= len(done) <= 20 * STEP / (5.0 * SLOW)


def test_a_loop_that_fails_leaves_nothing_at_the_wheels(loop, caplog):
    loop.chair.order = None
    loop.chair.step = lambda due, attend: 1 / 0
    end = time.monotonic() + 5.0
    while not loop.trouble and time.monotonic() < end:
        time.sleep(0.01)
    assert "failed" in loop.trouble
    assert not loop.chair.order.twist.any()


def test_an_errand_that_fails_ends_nothing(loop):
    heard = threading.Event()
    assert loop.bid(lambda _: 1 / 0)
    assert loop.bid(lambda _: heard.set())
    assert heard.wait(5.0)
    assert loop.trouble == ""


@pytest.mark.parametrize("answered", [1, 0])
def test_what_a_navigator_was_lost_over_is_not_asked_of_the_next_one(loop, answered):
    """The errand has version 1: kept where it was answered before, dropped where it never was."""
    heard = threading.Event()
    loop.chair.answered = answered
    loop._thinking.owed = SimpleNamespace(errand=1)
    loop._thinking.lost = "no answer"
    assert loop.chair.held.wait(5.0)
    loop.say(lambda _: heard.set())
    assert heard.wait(5.0)
    assert (loop._hearing.errand.goal is not None) == bool(answered)
