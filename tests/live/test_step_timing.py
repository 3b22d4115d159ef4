"""Steps begin with the leading sensor's readings, and come all the same where it is silent."""

import itertools
import math

import numpy as np
import pytest

from cohelm.live.control import step_timing
from cohelm.live.control.step_timing import MIN_PERIOD, PATIENCE, STEP, StepTimer

JITTER = 0.003
"""Maximum deviation of an arrival, s."""


class Sensor:
    """A clock, and readings that arrive at given times of it."""

    def __init__(self, arrivals):
        self.now, self.arrivals, self.observed = 0.0, list(arrivals), 0.0

    def monotonic(self):
        return self.now

    def sleep(self, timeout):
        self.now += timeout

    def wait(self, after, timeout):
        end = self.now + timeout
        new = [each for each in self.arrivals if each > max(self.observed, after)]
        here = [each for each in new if each <= self.now]
        if not here and new and new[0] <= end:
            self.now, here = new[0], new[:1]
        if not here:
            self.now = end
        return here[-1] if here else None

    def steps(self, count, computing=0.01, *, silent=False):
        """(begin, due) of steps that observe at their beginning and then compute."""
        timer, due, out = StepTimer(self), 0.0, []
        for _ in range(count):
            out.append((self.now, due))
            self.observed = self.now
            self.now += computing
            due = timer.wait(due, None if silent else self.wait)
        return np.array(out)


@pytest.fixture
def sensor(monkeypatch):
    def made(arrivals):
        sensor = Sensor(arrivals)
        monkeypatch.setattr(step_timing.time, "monotonic", sensor.monotonic)
        return sensor

    return made


def waits(sensor, steps):
    """Time from each arrival to the step that observes it, s."""
    begins = steps[:, 0]
    known = [each for each in sensor.arrivals if 0.5 < each <= begins[-1]]
    return np.array([begins[begins >= each - 1e-9][0] - each for each in known])


@pytest.fixture(autouse=True)
def closing(monkeypatch):
    """The timer sleeps on the sensor's clock."""

    def sleep_until(self, end):
        clock = self._closing
        clock.sleep(max(end - clock.now, 0.0))

    monkeypatch.setattr(StepTimer, "_sleep_until", sleep_until)


@pytest.mark.parametrize("rate", [8.0, 10.0, 12.5, 15.0, 20.0, 24.0])
def test_a_step_begins_when_a_reading_arrives(sensor, rng, rate):
    made = sensor(k / rate + rng.uniform(0.0, JITTER) for k in range(1, 400))
    steps = made.steps(400)
    # Two arrivals may be closer than the minimum period by their jitter.
    assert waits(made, steps).max() <= 2 * JITTER
    assert np.median(waits(made, steps)) <= 1e-6
    assert np.diff(steps[5:, 0]).max() <= STEP + PATIENCE + 1e-6


def test_between_two_readings_at_10_hz_there_is_a_step(sensor, rng):
    made = sensor(k / 10.0 + rng.uniform(0.0, JITTER) for k in range(1, 400))
    gaps = np.diff(made.steps(200)[10:, 0])
    assert gaps == pytest.approx(STEP, abs=2 * JITTER)


@pytest.mark.parametrize("rate", [30.0, 40.0, 100.0])
def test_a_fast_sensor_is_not_followed(sensor, rate):
    made = sensor(np.arange(1, 3000) / rate)
    steps = made.steps(300)
    gaps = np.diff(steps[10:, 0])
    assert gaps.min() >= MIN_PERIOD - 1e-9
    assert gaps.max() <= STEP + PATIENCE
    assert waits(made, steps).max() <= MIN_PERIOD


def test_without_readings_the_steps_come_all_the_same(sensor):
    made = sensor(np.arange(1, 40) / 20.0)  # it falls silent after 1.95 s
    begins = made.steps(100)[:, 0]
    after = begins[begins > 1.95]
    assert after[0] - 1.95 <= STEP + PATIENCE + 1e-9
    assert np.diff(after) == pytest.approx(STEP)


def test_a_reading_that_came_while_a_step_was_computed_begins_the_next_one_at_once(sensor):
    made = sensor(np.arange(1, 100) / 20.0)
    begins = made.steps(60, computing=0.07)[:, 0]
    assert np.diff(begins) == pytest.approx(0.07)


def test_a_platform_without_a_leading_sensor_has_a_fixed_period(sensor):
    steps = sensor([]).steps(50, silent=True)
    assert np.diff(steps[:, 0]) == pytest.approx(STEP)
    assert steps[:, 0] == pytest.approx(steps[:, 1])


def test_a_step_that_begins_with_a_reading_is_due_at_its_arrival(sensor):
    made = sensor(np.arange(1, 100) / 20.0)
    steps = made.steps(60)
    assert steps[1:, 1] == pytest.approx(steps[1:, 0])


def test_arrivals_tell_when_the_next_one_is_expected():
    arrivals = step_timing.Arrivals()
    assert arrivals.after(1.0).expected == -math.inf
    for time in itertools.accumulate([1.0, 0.1, 0.1, 0.3, 0.1]):  # one reading was late
        arrivals = arrivals.after(time)
    assert arrivals.expected == pytest.approx(1.7)
