"""A real chair's commands leave before anything else is done, and late answers are used at once."""

import numpy as np
import pytest

from cohelm.live.control.step_timing import MAX_ELAPSED, STEP
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario

from .rig import Hidden, Rig


@pytest.fixture(scope="module")
def hall():
    return build_scenario(load_scenario("empty"), 0)


@pytest.fixture
def rig(hall):
    rig = Rig(hall, Hidden)
    rig.drive()
    return rig


def test_the_command_leaves_before_the_pages_get_the_state(rig, monkeypatch):
    order = []
    monkeypatch.setattr(rig.cycle.world._platform, "apply", lambda _: order.append("wheels"))
    monkeypatch.setattr(rig.cycle, "_send", lambda message, _: order.append(message.type))
    rig.beat(0.5)
    rig.clock.now = rig.due
    rig.cycle.step(rig.due, rig.attend)
    assert order[0] == "wheels"
    assert order.count("wheels") == order.count("state") == 1


def test_a_late_answer_moves_the_chair_at_once_and_the_next_step_follows(rig):
    """The answer takes 70 ms: it is used 70 ms after its scan, not at the end of the next step."""
    rig.steps(20, 0.5)
    if rig.simulation.observe().scans:  # at 10 Hz: then the step after the slow one has a scan
        rig.steps(1, 0.5)
    assert not rig.cycle.behind
    asked, rig.navigator.takes = rig.due, 0.07
    rig.beat(0.8)
    slow = rig.step()
    assert rig.navigator.pending is not None
    rig.beat(0.8)
    late = rig.step()
    assert rig.clock.now == pytest.approx(asked + 0.07)
    assert late.command[0] > slow.command[0]
    # The observation of the second step waits for its request.
    assert rig.cycle.behind
    count = len(rig.navigator.requests)
    rig.due = rig.clock.now
    rig.step()
    scans = [scan.time for request in rig.navigator.requests for scan in request.observation.scans]
    assert len(rig.navigator.requests) == count + 1
    assert len(set(scans)) == len(scans)
    assert np.diff(sorted(scans)).max() == pytest.approx(np.diff(sorted(scans)).min())


def test_speed_rises_by_the_time_that_has_passed_and_not_by_steps(hall):
    rig = Rig(hall, Hidden, max_acceleration=0.3)
    rig.drive()
    rig.steps(4, 1.0)
    before = rig.state.command[0]
    rig.due += 0.03  # the scan is 80 ms after the last one
    rig.beat(1.0)
    rise = rig.step().command[0] - before
    assert 0.3 * STEP + 2e-4 < rise <= 0.3 * (STEP + 0.03) + 2e-4
    before = rig.state.command[0]
    rig.due += 0.1  # two steps were lost
    rig.beat(1.0)
    assert rig.step().command[0] - before <= 0.3 * MAX_ELAPSED + 2e-4
