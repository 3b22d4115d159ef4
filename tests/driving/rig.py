"""A chair without threads, processes or clocks: the navigator answers when a test says so."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from cohelm.driving.chair import STEP, Chair
from cohelm.driving.crew import Crew
from cohelm.driving.hearing import Hearing
from cohelm.driving.limits import InForce
from cohelm.driving.messages import Beat, Resume, Take
from cohelm.driving.navigating import Mind
from cohelm.driving.outings import Outings
from cohelm.driving.playing import Play
from cohelm.simulation import World

EPOCH = 1000.0


class Clock:
    """Time that passes when a test says so, s."""

    def __init__(self):
        self.now = EPOCH

    def __call__(self):
        return self.now


class Inline:
    """A navigator in the same thread that takes ``takes`` s for each answer."""

    def __init__(self, mind, clock):
        self.mind, self.clock = mind, clock
        self.takes, self.frozen = 0.012, False
        self.asked, self.ready, self.begun, self.lost, self.pid = None, True, 1, "", None
        self.answers, self.asks = [], []
        self._due = self.asked_at = 0.0

    @property
    def free(self):
        return self.ready and self.asked is None

    def ask(self, ask, now):
        if self.free:
            self.asked, self.asked_at, self._due = ask, now, now + self.takes
            self.asks.append(ask)

    def answer(self, timeout, now):
        if self.asked is None or not self.ready:
            return None
        if self.frozen or self._due > now + timeout:
            self.clock.now = now + timeout
            return None
        self.clock.now = max(now, self._due)
        answer, self.asked = self.mind.answer(self.asked), None
        self.answers.append(answer)
        return answer


class Kept:
    """Sessions that are only remembered."""

    def __init__(self):
        self.kept, self.count = [], 0

    def begin(self, stage):
        return SimpleNamespace(id="session")

    def begin_ride(self):
        self.count += 1
        return f"session-r{self.count}", Path("rows")

    def keep(self, record, log, stage):
        self.kept.append((record, log))


class Rig:
    """A chair on a stage, with a page called ``a`` whose beats come every tenth of a second."""

    def __init__(self, stage, **limits):
        self.clock, self.told, self.inbox = Clock(), [], []
        self.stage, self.due, self.seq = stage, EPOCH, 0
        self.thinking = Inline(Mind(stage), self.clock)
        in_force = InForce(None, stage.robot, stage.scenario.profile)
        in_force.set_limits(in_force.limits.model_copy(update=limits), lambda: True)
        self.sessions = Kept()
        outings = Outings(self.sessions, in_force, self.tell, STEP)
        pricing = SimpleNamespace(wanted=False, surrounded=lambda _: None)
        crew = Crew(thinking=self.thinking, pricing=pricing, playing=None, outings=outings)
        effects = SimpleNamespace(simulate=None, preview=None, rate=None)
        note = lambda *_, **__: None  # noqa: E731
        self.hearing = Hearing(stage.places, in_force, self.tell, note, effects)
        self.chair = Chair(
            self.hearing, in_force, stage.scenario.profile, crew, tell=self.tell, clock=self.clock
        )
        self.chair.put(self.play())

    def play(self):
        world = World(self.stage.world, self.stage.seed)
        return Play(self.stage, world, None, np.random.default_rng(0))

    def tell(self, message, client):
        self.told.append(message)

    def of(self, kind):
        return [message for message in self.told if message.type == kind]

    @property
    def state(self):
        return self.of("state")[-1]

    @property
    def world(self):
        return self.chair.play.world

    def say(self, message, client="a"):
        self.inbox.append((client, message))

    def beat(self, forward=0.0, left=0.0, client="a", **given):
        self.seq += 1
        sent = 1000.0 * self.clock.now
        self.say(
            Beat(seq=self.seq, sent=sent, forward=forward, left=left, device="keys", **given),
            client,
        )

    def attend(self):
        inbox, self.inbox = self.inbox, []
        for client, message in inbox:
            self.hearing.heard(client, message, self.clock.now)

    def step(self):
        self.clock.now = max(self.clock.now, self.due)
        self.chair.step(self.due, self.attend)
        self.due += STEP
        return self.state

    def steps(self, count, forward=None, left=0.0):
        """So many steps; with a stick, a beat every other one."""
        states = []
        for k in range(count):
            if forward is not None and k % 2 == 0:
                self.beat(forward, left)
            states.append(self.step())
        return states

    def drive(self):
        """Take the stick, let it go, and confirm where that is needed."""
        self.say(Take())
        self.steps(2, 0.0)
        if self.state.link == "confirm":
            self.say(Resume())
        self.steps(2, 0.0)
        assert self.state.link == "ready"
