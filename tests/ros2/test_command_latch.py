"""The process of the command topic: old commands never reach the robot, silence is a stop."""

import math

import numpy as np
import pytest

from cohelm.errors import PlatformError
from cohelm.ros2 import command_client
from cohelm.ros2.clocks import RobotClock, WallClock
from cohelm.ros2.command_client import ECHO_TIMEOUT, LOST_AFTER, CommandClient
from cohelm.ros2.command_process import MAX_AGE, MAX_DELAY, PERIOD, CommandLatch, WheelCommand
from cohelm.ros2.parameters import Ros2Parameters


def command(at, forward=0.5):
    return WheelCommand(at, at, (forward, 0.0, 0.0))


def test_a_fresh_command_passes_and_an_old_one_does_not():
    latch = CommandLatch(10.0)
    assert latch.accepts(command(10.0), 10.01)
    assert not latch.accepts(command(10.0), 10.0 + MAX_AGE + 0.01)


@pytest.mark.parametrize("twist", [(math.nan, 0.0, 0.0), (0.0, 0.0, math.inf)])
def test_a_command_that_is_not_a_number_does_not_pass(twist):
    assert not CommandLatch(10.0).accepts(WheelCommand(10.0, 10.0, twist), 10.0)


def test_a_command_from_the_future_does_not_pass():
    assert not CommandLatch(10.0).accepts(command(10.5), 10.0)


def test_silence_becomes_zeros_twenty_times_a_second():
    latch, zeros = CommandLatch(0.0), []
    latch.accepts(command(0.0), 0.0)
    for millisecond in range(1000):
        now = 0.001 * millisecond
        if latch.needs_zero(now):
            zeros.append(now)
    assert zeros[0] == pytest.approx(MAX_AGE, abs=0.002)
    # From 0.15 s to 1 s one each 0.05 s: 17.
    assert len(zeros) == pytest.approx((1.0 - MAX_AGE) / PERIOD, abs=1)


@pytest.mark.parametrize("delay", [0.0, 0.03, 0.1, MAX_AGE])
def test_a_command_moves_the_robot_for_a_bounded_time_whatever_its_way_took(delay):
    latch = CommandLatch(0.0)
    assert latch.accepts(command(0.0), delay)
    zero = next(now for now in np.arange(delay, 1.0, 0.001) if latch.needs_zero(now))
    assert zero <= MAX_DELAY + MAX_AGE + 0.002
    assert zero >= MAX_AGE


class Process:
    """A process of the command topic that answers when the test says so."""

    def __init__(self, *_):
        self.answers, self.pid = [0.0], 1

    def send(self, command):
        self.sent = command

    def receive(self, timeout):
        return self.answers.pop(0) if self.answers else None


@pytest.fixture
def client(monkeypatch):
    monkeypatch.setattr(command_client, "WorkerProcess", Process)
    zeros = []
    made = CommandClient(Ros2Parameters(), zeros.append)
    made.zeros = zeros
    return made


def test_an_owner_that_was_held_up_itself_takes_its_process_for_alive(client):
    for at in (10.0, 10.05, 13.0, 13.05):  # it stood for three seconds
        client.send(command(at))
        assert not client.late
        client._process.answers.append(at)
    assert client.zeros == []


def test_an_owner_without_answers_publishes_zeros_itself_and_gives_up_after_a_second(client):
    client.send(command(10.0))
    client._process.answers.append(10.0)
    client.send(command(10.05))
    client.send(command(10.05 + ECHO_TIMEOUT - 0.01))
    assert not client.late
    client.send(command(10.05 + ECHO_TIMEOUT + 0.01))
    assert client.late
    assert {zero.twist for zero in client.zeros} == {(0.0, 0.0, 0.0)}
    with pytest.raises(PlatformError, match="does not answer"):
        client.send(command(10.05 + LOST_AFTER + 0.01))
    client._process.answers.append(10.05 + LOST_AFTER + 0.01)
    client.send(command(12.0))
    assert not client.late


def test_before_the_first_command_there_are_zeros_only():
    assert CommandLatch(0.0).needs_zero(0.0)


def test_the_robot_s_clock_never_runs_backwards_and_counts_jumps():
    clock = RobotClock()
    assert clock.silent
    assert clock.now() == 0.0
    for stamp in (100.0, 100.1, 100.2):
        clock.take(stamp)
    assert clock.now() == pytest.approx(0.2)
    assert (clock.jumps, clock.silent) == (0, False)
    clock.take(50.0)
    assert clock.now() == pytest.approx(0.2)
    assert clock.jumps == 1


def test_a_jump_of_the_wall_clock_makes_stamps_old_until_it_is_taken_over(monkeypatch):
    wall, monotonic = [1000.0], [5.0]
    monkeypatch.setattr("cohelm.ros2.clocks.time.time", lambda: wall[0])
    monkeypatch.setattr("cohelm.ros2.clocks.time.monotonic", lambda: monotonic[0])
    clock = WallClock()

    def after(seconds, jump=0.0):
        wall[0] += seconds + jump
        monotonic[0] += seconds
        now = clock.now()
        return now, now - clock.of(wall[0])

    assert after(1.0) == pytest.approx((1.0, 0.0))
    now, age = after(0.5, jump=-30.0)  # a stamp of now seems 30 s old: everything is stale
    assert (now, age) == pytest.approx((1.5, 30.0))
    now, age = after(2.0)  # and after a second it is taken over, without time running backwards
    assert (now, age) == pytest.approx((3.5, 0.0))
    assert clock.jumps == 1
