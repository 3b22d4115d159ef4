"""The contract of a platform finds platforms that break it."""

import dataclasses
import time

import numpy as np
import pytest

from cohelm.messages import Decision
from cohelm.platforms import Planar, PlanarPlatform
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World
from cohelm.testing import ConformanceError, check_open_platform, check_platform


@pytest.fixture(scope="module")
def setup():
    return build_scenario(load_scenario("empty"), 0)


class Broken(PlanarPlatform):
    """A simulated chair whose observations or commands are changed."""

    def __init__(self, setup, see=lambda seen, k: seen, command=lambda decision: decision):
        super().__init__(World(setup.world, 0))
        self._see, self._command, self._count = see, command, 0

    def observe(self):
        self._count += 1
        return self._see(super().observe(), self._count)

    def apply(self, decision):
        super().apply(self._command(decision))


def with_time(time):
    return lambda seen, k: dataclasses.replace(seen, time=time(seen, k))


FAULTS = {
    "backwards": ({"see": with_time(lambda seen, k: -seen.time)}, "backwards"),
    "frozen": ({"see": with_time(lambda seen, k: 0.0)}, "future|pass"),
    "half speed": ({"see": with_time(lambda seen, k: 0.5 * seen.time)}, "pass as"),
    "reversed wheels": (
        {"command": lambda d: dataclasses.replace(d, twist=-d.twist)},
        "forward",
    ),
    "reversed odometry": (
        {"see": lambda seen, k: dataclasses.replace(seen, twist=-seen.twist)},
        "odometry",
    ),
    "creeps on": (
        {"command": lambda d: Decision(twist=np.array([0.3, 0.0, 0.0]))},
        "a stop",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_found(setup, fault):
    changes, text = FAULTS[fault]
    with pytest.raises(ConformanceError, match=text):
        check_open_platform(Broken(setup, **changes))


def test_a_scan_that_comes_twice_is_found(setup):
    last = {}

    def again(seen, k):
        last["scans"] = seen.scans or last.get("scans", ())
        return dataclasses.replace(seen, scans=last["scans"])

    with pytest.raises(ConformanceError, match="once"):
        check_open_platform(Broken(setup, see=again))


def test_a_sound_platform_passes(setup):
    seen = check_open_platform(Planar(Planar.Parameters()).open(setup))
    assert len(seen) == 60  # 3 s of 0.05 s


def test_a_plugin_that_does_not_say_whether_it_is_simulated_is_refused():
    with pytest.raises(ConformanceError, match="simulated"):
        check_platform(object())


@pytest.mark.parametrize(
    ("wait", "text"),
    [(lambda after, timeout: 1.0, "None"), (lambda after, timeout: time.sleep(0.4), "timeout")],
)
def test_a_wait_for_readings_that_ignores_its_arguments_is_found(setup, wait, text):
    broken = Broken(setup)
    broken._capabilities = dataclasses.replace(broken.capabilities, wait=wait)
    with pytest.raises(ConformanceError, match=text):
        check_open_platform(broken)
