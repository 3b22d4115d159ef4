"""The process of the command topic: old commands never reach the robot, silence is a stop."""

import math

import pytest

from cohelm.ros2.clocks import RobotClock, WallClock
from cohelm.ros2.command_process import MAX_AGE, PERIOD, CommandLatch, WheelCommand


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
