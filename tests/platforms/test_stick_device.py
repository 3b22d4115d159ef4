"""A stick at this computer: Linux's events, and what a stick that is gone does."""

import os
import struct
import time
from typing import ClassVar

import numpy as np
import pytest

from cohelm.errors import PlatformError
from cohelm.messages import Observation
from cohelm.platforms import Capabilities, WithStick
from cohelm.platforms.stick_device import NEVER
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.testing import check_platform

AXIS, BUTTON, INITIAL = 0x02, 0x01, 0x80


class Chair:
    """A chair that stands, as ``module:Class`` in a file beside the test."""

    simulated = False
    opened: ClassVar = []

    class Parameters(WithStick.Parameters):
        platform: str = ""

    def __init__(self, parameters):
        self.capabilities, self.closed, self.began = Capabilities(name="chair"), False, 100.0

    def open(self, setup):
        Chair.opened.append(self)
        return self

    def observe(self):
        return Observation.at_rest(3.5)

    def apply(self, decision):
        self.decision = decision

    def close(self):
        self.closed = True


@pytest.fixture(scope="module")
def setup():
    return build_scenario(load_scenario("empty"), 0)


@pytest.fixture
def device(tmp_path):
    """(path, function that sends an event, function that unplugs it)."""
    path = tmp_path / "js0"
    os.mkfifo(path)
    ours = os.open(path, os.O_RDWR)

    def send(value, number, kind=AXIS):
        os.write(ours, struct.pack("IhBB", 0, value, kind, number))
        time.sleep(0.05)

    def unplug():
        os.close(ours)
        time.sleep(0.05)

    return str(path), send, unplug


def opened(path, setup, platform=None):
    given = platform or {"use": f"{__name__}:Chair"}
    return WithStick(WithStick.Parameters(platform=given, device=path)).open(setup)


def test_the_stick_is_in_the_observations_until_it_is_unplugged(device, setup):
    path, send, unplug = device
    platform = opened(path, setup)
    send(0, 0, AXIS | INITIAL)
    send(-32767, 1)  # forward is negative
    send(16384, 0)
    send(1, 1, BUTTON)
    rider = platform.observe().rider
    np.testing.assert_allclose(rider.deflection, [1.0, -0.5], atol=1e-4)
    time.sleep(0.5)  # a held stick sends nothing
    assert platform.observe().rider.heartbeat == 3.5
    send(-32768, 1)
    assert platform.observe().rider.deflection[0] == 1.0
    unplug()
    rider = platform.observe().rider
    assert rider.heartbeat == NEVER
    platform.close()
    platform.close()
    assert Chair.opened[-1].closed


def test_a_stick_that_is_not_there_is_named(tmp_path, setup):
    with pytest.raises(PlatformError, match="no-stick"):
        opened(str(tmp_path / "no-stick"), setup)


def test_a_simulation_has_no_stick_at_this_computer(device, setup):
    with pytest.raises(PlatformError, match="simulation"):
        opened(device[0], setup, {"use": "planar"})


def test_the_plugin_keeps_its_contract():
    check_platform(WithStick(WithStick.Parameters(platform={"use": "ros2"})))
