"""The remote joystick keeps 20 Hz whatever the control loop does; time is simulated in ms."""

import numpy as np
import pytest

from cohelm.platforms.luci.client import MAX_AGE, Pacer, TimedTwist

FORWARD = np.array([0.4, 0.0, 0.0])


def sent(commands, until=3.0):
    """(time, twist) of each message, for commands made at these times."""
    pacer, out, waiting = Pacer(0.0), [], sorted(commands)
    for k in range(round(1000 * until)):
        now = 0.001 * k
        while waiting and waiting[0] <= now:
            pacer.take(TimedTwist(waiting.pop(0), FORWARD))
        due, twist = pacer.next(now)
        if due:
            out.append((now, twist))
    return out


def rate(messages, since, until):
    return sum(since <= at < until for at, _ in messages) / (until - since)


@pytest.mark.parametrize("jitter", [0.0, 0.004, 0.012])
def test_a_steady_loop_is_passed_on(jitter):
    rng = np.random.default_rng(0)
    times = 0.05 * np.arange(60) + rng.uniform(-jitter, jitter, 60).clip(0.0)
    messages = sent(times.tolist())
    assert rate(messages, 0.2, 2.8) == pytest.approx(20.0, rel=0.1)
    assert all(twist is FORWARD for at, twist in messages if 0.2 < at < 2.8)


@pytest.mark.parametrize("period", [0.005, 0.03, 0.1, 0.14])
def test_another_loop_does_not_change_the_rate(period):
    messages = sent((period * np.arange(3.0 / period)).tolist())
    gaps = np.diff([at for at, _ in messages])
    assert gaps.max() < 1.1 * 0.05 + 1e-9  # so that every second has 20 messages ± 10 %
    assert gaps.min() > 0.9 * 0.05


def test_silence_is_a_centred_joystick_at_the_same_rate():
    messages = sent([0.05 * k for k in range(20)])  # the last one is made at 0.95 s
    moving = [at for at, twist in messages if twist is not None]
    assert max(moving) <= 0.95 + MAX_AGE
    later = [at for at, twist in messages if at > max(moving)]
    assert later[0] <= 0.95 + MAX_AGE + 0.05 + 1e-3
    assert rate(messages, 1.2, 2.8) == pytest.approx(20.0, rel=0.1)


def test_without_a_command_the_joystick_is_centred():
    messages = sent([])
    assert {twist is None for _, twist in messages} == {True}
    assert rate(messages, 0.0, 3.0) == pytest.approx(20.0, rel=0.1)


def test_a_command_of_the_future_or_of_the_past_moves_nothing():
    for made_at in (10.5, 10.0 - MAX_AGE - 0.01):
        pacer = Pacer(10.0)
        pacer.take(TimedTwist(made_at, FORWARD))
        assert pacer.next(10.0) == (True, None)
