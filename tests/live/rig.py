"""A chair without threads, processes or clocks: the navigator answers when a test says so."""

from __future__ import annotations

import tempfile
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from cohelm.arrays import replace
from cohelm.live.commands import CommandHandler
from cohelm.live.control.driver_state import DriverState
from cohelm.live.control.limits import ActiveSettings
from cohelm.live.control.navigator_process import NavigatorServer
from cohelm.live.control.step_timing import STEP
from cohelm.live.control.world_factory import LiveWorld
from cohelm.live.control_cycle import ControlCycle
from cohelm.live.messages import FloorInfo, Heartbeat, Notice, ResumeCommand, TakeControl
from cohelm.live.ride_tracker import RideTracker
from cohelm.live.services import Services
from cohelm.live.sessions.records import unknown_session
from cohelm.maps import OCCUPIED
from cohelm.platforms import Capabilities, PlanarPlatform
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
        self.takes, self.frozen, self.gave_up, self.routes = 0.012, False, False, True
        self.pending, self.ready, self.starts, self.lost, self.pid = None, True, 1, "", None
        self.answers, self.requests = [], []
        self._due = self.requested_at = 0.0

    @property
    def free(self):
        return self.ready and self.pending is None

    def request(self, step, now):
        if self.free:
            self.pending, self.requested_at, self._due = step, now, now + self.takes
            self.requests.append(step)

    def answer(self, timeout, now):
        if self.pending is None or not self.ready:
            return None
        if self.frozen or self._due > now + timeout:
            self.clock.now = now + timeout
            return None
        self.clock.now = max(now, self._due)
        answer, self.pending = self.mind.answer(self.pending), None
        self.answers.append(answer)
        return answer


class Kept:
    """Sessions that are only remembered."""

    def __init__(self):
        self.kept, self.count = [], 0
        self.folder = Path(tempfile.mkdtemp(prefix="cohelm-"))

    def begin(self, ride_setup, rider=""):
        self.session = unknown_session("20260131-142530", "empty")

    def begin_ride(self):
        self.count += 1
        ride = f"{self.session.id}-r{self.count}"
        return ride, self.session, self.folder / f"{ride}.mcap"

    error = ""

    def retry(self, further=None):
        pass

    def keep(self, record, log, ride_setup):
        self.kept.append((record, log))


class Hidden(PlanarPlatform):
    """A simulated chair of which the loop sees no more than of a real one."""

    capabilities = Capabilities(name="a chair")


class Rig:
    """A chair on a stage, with a page called ``a`` whose beats come every tenth of a second."""

    def __init__(self, ride_setup, platform=PlanarPlatform, **limits):
        self.platform = platform
        self.clock, self.told, self.inbox = Clock(), [], []
        self.ride_setup, self.due, self.seq = ride_setup, EPOCH, 0
        self.navigator = Inline(NavigatorServer(ride_setup), self.clock)
        settings = ActiveSettings(None, ride_setup.robot, ride_setup.scenario.profile)
        settings.set_limits(settings.limits.model_copy(update=limits), lambda: True)
        self.sessions = Kept()
        rides = RideTracker(self.sessions, settings, self.send)
        route_preview = SimpleNamespace(
            needs_context=False, ready=True, set_planning_context=lambda _: None
        )
        services = Services(
            navigator=self.navigator, route_preview=route_preview, world_factory=None, rides=rides
        )
        log_event = lambda *_, **__: None  # noqa: E731
        self.driver = DriverState()
        bounds = FloorInfo(image="", width=200, height=200, resolution=0.1, x=0.0, y=0.0)
        grid, robot = ride_setup.grid, ride_setup.robot
        shut = replace(grid, data=np.full_like(grid.data, OCCUPIED))
        storeys = {"Level 1": grid, "Level 2": grid, "Roof": shut}
        floor = SimpleNamespace(
            places=ride_setup.places,
            grid=grid,
            robot=robot,
            scene=SimpleNamespace(floor=bounds, storey="Level 1"),
            storeys=[SimpleNamespace(name=name, grid=each) for name, each in storeys.items()],
        )
        loop = SimpleNamespace(
            preparing=False,
            announce=lambda code, text: self.send(Notice(code=code, text=text), None),
        )
        self.commands = CommandHandler(
            self.driver,
            floor,
            settings,
            loop,
            services,
            send=self.send,
            log_event=log_event,
        )
        self.cycle = ControlCycle(
            self.driver,
            settings,
            ride_setup.scenario.profile,
            services,
            send=self.send,
            clock=self.clock,
        )
        loop.cycle = self.cycle
        self.cycle.enter(self.new_world())

    def new_world(self):
        self.simulation = World(self.ride_setup.world, self.ride_setup.seed)
        platform = self.platform(self.simulation)
        return LiveWorld(self.ride_setup, platform, None, np.random.default_rng(0))

    def send(self, message, client):
        self.told.append(message)

    def of(self, kind):
        return [message for message in self.told if message.type == kind]

    @property
    def state(self):
        return self.of("state")[-1]

    @property
    def world(self):
        return self.simulation

    def say(self, message, client="a"):
        self.inbox.append((client, message))

    def beat(self, forward=0.0, left=0.0, client="a", **given):
        self.seq += 1
        sent = 1000.0 * self.clock.now
        self.say(
            Heartbeat(seq=self.seq, sent=sent, forward=forward, left=left, device="keys", **given),
            client,
        )

    def attend(self):
        inbox, self.inbox = self.inbox, []
        for client, message in inbox:
            self.commands.receive(client, message, self.clock.now)

    def step(self):
        self.clock.now = max(self.clock.now, self.due)
        self.cycle.step(self.due, self.attend)
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
        self.say(TakeControl())
        self.steps(2, 0.0)
        if self.state.link == "confirm":
            self.say(ResumeCommand())
        self.steps(2, 0.0)
        assert self.state.link == "ready"
