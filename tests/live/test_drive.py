"""The whole drive with its threads and processes, on a real clock."""

import os
import signal
import threading
import time

import pytest

from cohelm.errors import StoreError
from cohelm.live import Drive, DriveSetup, LimitsLoosened
from cohelm.live.control.limits import ChairMoves
from cohelm.live.messages import (
    ChangeSimulation,
    Echo,
    Heartbeat,
    PlanTrip,
    ReleaseControl,
    ResumeCommand,
    RiderSettings,
    RouteWish,
    SetGoal,
    TakeControl,
)
from cohelm.scenarios import load_scenario

pytestmark = pytest.mark.slow

BUSY = 0.15
"""What a machine that does much else may add to a time, s."""


class Page:
    """A page that beats ten times a second as long as it lives."""

    def __init__(self, drive, client):
        self.drive, self.client = drive, client
        self.told, self.states = [], []
        self.stick, self.beats = (0.0, 0.0), True
        self._seq, self._ends = 0, threading.Event()
        drive.listen(self._hear)
        drive.connect(client, "driver")
        self._thread = threading.Thread(target=self._beat, daemon=True)
        self._thread.start()

    def _hear(self, message, client):
        if client not in {None, self.client}:
            return
        if message.type == "state":
            self.states.append((time.monotonic(), message))
        else:
            self.told.append(message)

    def _beat(self):
        while not self._ends.wait(0.1):
            if self.beats:
                self.beat()

    def beat(self):
        self._seq += 1
        forward, left = self.stick
        now = time.monotonic()
        self.say(
            Heartbeat(seq=self._seq, sent=1000.0 * now, forward=forward, left=left, device="keys")
        )

    def say(self, message):
        self.drive.receive(self.client, message, time.monotonic())

    def of(self, kind):
        return [message for message in self.told if message.type == kind]

    @property
    def state(self):
        return self.states[-1][1]

    def until(self, holds, patience=15.0):
        """Wait for a state in which something holds; when it came, s, and the state."""
        seen, end = len(self.states), time.monotonic() + patience
        while time.monotonic() < end:
            for when, state in self.states[seen:]:
                seen += 1
                if holds(state):
                    return when, state
            time.sleep(0.005)
        raise AssertionError(f"it never came; now {self.state}")

    def drives(self):
        self.stick = (0.0, 0.0)
        self.say(TakeControl())
        _, state = self.until(lambda s: s.link in {"ready", "confirm"})
        if state.link == "confirm":
            self.say(ResumeCommand())
            self.until(lambda s: s.link == "ready")

    def goes_on(self):
        """Confirm, as often as it takes: not before the navigator answers again does it count."""
        self.stick = (0.0, 0.0)
        for _ in range(20):
            _, state = self.until(lambda s: s.link in {"confirm", "ready"} and stands(s))
            if state.link == "ready" and state.reason is None:
                return
            self.say(ResumeCommand())
            time.sleep(0.3)
        raise AssertionError(f"it does not go on; now {self.state}")

    def moves(self):
        self.stick = (0.7, 0.0)
        self.until(lambda s: s.speed > 0.15)

    def rests(self):
        self.stick = (0.0, 0.0)
        self.until(lambda s: abs(s.speed) < 0.02 and s.link in {"ready", "confirm"})
        self.goes_on()  # on a machine that is busy elsewhere the navigator may have been silent

    def close(self):
        self._ends.set()
        self._thread.join()


@pytest.fixture(scope="module")
def drive(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sessions")
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=folder))
    drive.start()
    end = time.monotonic() + 240.0
    while not drive.health.ready and time.monotonic() < end:
        time.sleep(0.05)
    yield drive
    drive.close()
    drive.close()


@pytest.fixture
def page(drive, request):
    page = Page(drive, request.node.name)
    page.drives()
    yield page
    page.stick = (0.0, 0.0)
    page.say(ReleaseControl())
    page.until(lambda s: s.driver is None and abs(s.speed) < 0.02)
    page.close()
    drive.disconnect(page.client)


def stands(state):
    return state.command == (0.0, 0.0)


def test_the_first_word_is_welcome_and_the_next_the_route(drive):
    page = Page(drive, "new")
    assert [message.type for message in page.told[:2]] == ["welcome", "route"]
    assert page.told[0].scene == drive.scene()
    page.say(Echo(id=5))
    assert page.told[-1] == Echo(id=5)
    page.close()


def test_it_drives_and_stands_again(page):
    page.moves()
    page.rests()
    assert page.state.ride


def test_the_state_comes_twenty_times_a_second(page):
    begin = len(page.states)
    time.sleep(2.0)
    states = page.states[begin:]
    assert 36 <= len(states) <= 42
    numbers = [state.seq for _, state in states]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))


def test_a_silent_page_stops_the_chair(page):
    page.moves()
    page.beats, since = False, time.monotonic()
    when, state = page.until(stands)
    assert when - since <= 0.3 + 0.1 + 0.05 + BUSY
    assert state.reason.code == "connection_lost"
    page.beats = True
    page.rests()


def test_a_navigator_that_is_killed_stops_the_chair_and_is_begun_anew(drive, page):
    page.moves()
    before, since = drive.navigator_pid, time.monotonic()
    os.kill(before, signal.SIGKILL)
    when, state = page.until(stands)
    assert when - since <= 0.15 + 0.05 + BUSY
    assert state.reason.code == "navigator_timeout"
    page.until(lambda s: s.link in {"centre_stick", "stick_held", "confirm"})
    assert page.of("notice")[-1].code == "navigator_lost"
    page.stick = (0.0, 0.0)
    end = time.monotonic() + 120.0
    while not drive.health.ready and time.monotonic() < end:
        time.sleep(0.05)
    assert drive.navigator_pid not in {None, before}
    assert page.of("notice")[-1].code == "navigator_ready"
    assert stands(page.state)
    page.goes_on()
    page.moves()
    page.rests()


def test_a_navigator_that_is_stopped_stops_the_chair(drive, page):
    page.moves()
    pid, since = drive.navigator_pid, time.monotonic()
    os.kill(pid, signal.SIGSTOP)
    try:
        when, state = page.until(stands)
        assert when - since <= 0.15 + 0.05 + BUSY
        assert state.reason.code == "navigator_timeout"
        time.sleep(1.5)
        assert all(stands(state) for at, state in page.states if at > when)
    finally:
        os.kill(pid, signal.SIGCONT)
    page.goes_on()
    page.moves()
    page.rests()


def test_a_preview_says_what_a_wish_costs_and_changes_nothing(page):
    page.say(PlanTrip(id=1))
    page.until(lambda s: bool(page.of("rejected")))
    assert page.of("rejected")[-1].code == "no_destination"
    page.say(SetGoal(id=2, point=(11.0, 7.0)))
    page.until(lambda s: s.remaining is not None)
    wish = RouteWish(kind="attract", points=((6.0, 10.0),))
    page.say(PlanTrip(id=3, point=(11.0, 7.0), wishes=(wish,)))
    page.until(lambda s: bool(page.of("trip_plans")))
    plans = page.of("trip_plans")[-1]
    assert plans.id == 3
    assert plans.extra_length > 0.5
    assert page.of("route")[-1].wishes == ()
    page.say(SetGoal(id=4))
    page.rests()


def test_limits_are_told_kept_and_never_loosened_while_the_chair_moves(drive, page):
    first = drive.limits
    page.moves()
    slower = first.model_copy(update={"max_speed": 0.3})
    drive.set_limits(slower, "therapist")
    page.until(lambda s: s.command[0] <= 0.3)
    with pytest.raises(LimitsLoosened):
        drive.set_limits(first, "therapist")
    assert drive.limits == slower
    page.rests()
    drive.set_limits(first, "therapist")
    drive.set_rider(RiderSettings(dead_zone=0.2), "therapist")
    assert page.of("settings_changed")[-1].rider.dead_zone == 0.2
    noted = [entry.event for entry in drive.audit.entries(10)]
    assert {"limits_changed", "limits_rejected", "rider_settings_changed"} <= set(noted)


def test_edges_are_allowed_while_the_chair_stands_and_the_log_says_so(drive, page):
    page.moves()
    with pytest.raises(ChairMoves):
        drive.allow_edges("therapist", time.monotonic())
    page.rests()
    drive.allow_edges("therapist", time.monotonic())
    assert page.of("notice")[-1].code == "edges_allowed"
    assert "edges_allowed" in {entry.event for entry in drive.audit.entries(10)}


def test_the_world_begins_anew_with_another_seed(page):
    page.moves()
    page.stick = (0.0, 0.0)
    page.say(ChangeSimulation(id=9, action="restart", seed=4))
    page.until(lambda s: any(m.code == "simulation_restarted" for m in page.of("notice")), 60.0)
    _, state = page.until(lambda s: s.time < 1.0)
    assert stands(state)
    page.until(lambda s: s.link in {"confirm", "ready"})


def test_somebody_can_be_let_in(page):
    before = len(page.state.true_people)
    page.say(ChangeSimulation(id=3, action="person"))
    page.until(lambda s: len(s.true_people) == before + 1)


def test_a_ride_that_goes_on_when_it_is_closed_is_kept_whole(tmp_path):
    """And nobody else uses the folder meanwhile."""
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path))
    with pytest.raises(StoreError, match="in use"):
        Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path))
    drive.start()
    end = time.monotonic() + 240.0
    while not drive.health.ready and time.monotonic() < end:
        time.sleep(0.05)
    page = Page(drive, "last")
    page.drives()
    page.moves()
    page.close()
    drive.close()
    (session,) = drive.sessions.list()
    (ride,) = session.rides
    assert ride.outcome == "cancelled"
    assert not ride.error
    Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path)).close()


def test_nothing_is_left_when_it_is_closed(tmp_path):
    drive = Drive(DriveSetup(scenario=load_scenario("empty"), folder=tmp_path))
    drive.start()
    end = time.monotonic() + 60.0
    while drive.navigator_pid is None and time.monotonic() < end:
        time.sleep(0.02)
    pid = drive.navigator_pid
    drive.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)
    assert [entry.event for entry in drive.audit.entries()] == ["drive_closed", "drive_started"]
