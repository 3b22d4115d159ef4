"""The chair's loop with all other work left out: what is said in time, and what has to wait."""

import threading
import time
from types import SimpleNamespace

import pytest

from cohelm.driving.chair import STEP
from cohelm.driving.loop import MOST_ERRANDS, Loop

SLOW = 0.02
"""What an errand takes, s."""


class Stand:
    """A chair that only listens."""

    def __init__(self):
        self.preparing, self.play, self.waits = "", None, False
        self.begun = []

    def step(self, due, attend):
        self.begun.append(time.monotonic())
        attend()


@pytest.fixture
def loop():
    chair = Stand()
    thinking = SimpleNamespace(
        ready=False, begun=1, lost="", attend=lambda now: False, close=lambda: None
    )
    pricing = SimpleNamespace(
        settled=True, begin=lambda: None, attend=lambda: None, close=lambda: None
    )
    playing = SimpleNamespace(make=lambda seed, when: None, made=lambda: None, busy=False)
    outings = SimpleNamespace(lost=lambda: None)
    crew = SimpleNamespace(thinking=thinking, pricing=pricing, playing=playing, outings=outings)
    nobody = lambda *_, **__: None  # noqa: E731
    loop = Loop(chair, None, crew, seed=0, tell=nobody, note=nobody)
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


def test_an_errand_that_fails_ends_nothing(loop):
    heard = threading.Event()
    assert loop.bid(lambda _: 1 / 0)
    assert loop.bid(lambda _: heard.set())
    assert heard.wait(5.0)
    assert loop.trouble == ""
