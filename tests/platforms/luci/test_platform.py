"""A LUCI chair behind a mock of its published gRPC interface."""

import sys
import time

import numpy as np
import pytest

pytest.importorskip("grpc", reason="needs the extra luci")

from cohelm.errors import PlatformError
from cohelm.messages import Decision
from cohelm.platforms.luci import Luci, LuciParameters, protocol
from cohelm.platforms.luci.client import LOST_AFTER, MAX_AGE
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.testing import check_open_platform, check_platform

from .mock_chair import MockChair

STEP = 0.05
FORWARD = Decision(twist=np.array([0.5, 0.0, 0.25]))


@pytest.fixture(scope="module")
def setup():
    return build_scenario(load_scenario("empty"), 0)


@pytest.fixture
def chair():
    made = MockChair()
    yield made
    made.close()


def parameters(chair, **changes):
    return LuciParameters(host="127.0.0.1", port=chair.port, wait=3.0, **changes)


@pytest.fixture
def platform(chair, setup):
    opened = Luci(parameters(chair)).open(setup)
    yield opened
    opened.close()


def drive(platform, seconds, decision=FORWARD):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        platform.observe()
        platform.apply(decision)
        time.sleep(STEP)


def test_the_plugin_keeps_its_contract():
    check_platform(Luci(LuciParameters()))


def test_the_platform_keeps_its_contract_and_moves_as_commanded(platform, chair):
    seen = check_open_platform(platform, wait=time.sleep)
    assert seen[-1].pose[0] == pytest.approx(0.2, abs=0.06)  # 0.2 m/s for 1 s
    assert {len(each.clouds) for each in seen} >= {0, 1}
    assert seen[-1].clouds == () or seen[-1].clouds[0].points.shape == (21, 3)


def test_commands_go_out_20_times_a_second_scaled_and_with_the_shared_source(platform, chair):
    drive(platform, 0.3)
    began = time.monotonic()
    drive(platform, 2.0)
    count = len(chair.commands(began))
    assert count / (time.monotonic() - began) == pytest.approx(20.0, rel=0.1)
    assert set(chair.commands(began)) == {(50, -25)}  # 1 m/s and 1 rad/s at 100; left is negative
    assert {each.source for each in chair.heard} == {protocol.SHARED_REMOTE}
    assert platform.observe().twist[0] == pytest.approx(0.5, abs=0.1)


def test_after_silence_of_the_loop_the_joystick_is_centred(platform, chair):
    drive(platform, 0.5)
    silent = time.monotonic()
    time.sleep(0.6)
    moving = [each.at for each in chair.heard if each.forward_back != 100]
    assert max(moving) - silent <= MAX_AGE + 0.02
    assert chair.commands(silent + 0.25)
    assert set(chair.commands(silent + 0.25)) == {(0, 0)}


def test_closing_centres_the_joystick_and_releases_the_chair(chair, setup):
    platform = Luci(parameters(chair)).open(setup)
    assert chair.sources == [protocol.SHARED_REMOTE]
    drive(platform, 0.3)
    platform.close()
    platform.close()
    assert [each[1] for each in chair.changes] == ["add", "remove"]
    assert chair.sources == []
    assert chair.commands()[-1] == (0, 0)
    assert chair.heard[-1].at <= chair.changes[-1][0]
    count = len(chair.heard)
    time.sleep(0.2)
    assert len(chair.heard) == count


def test_the_rider_s_joystick_arrives(platform, chair):
    chair.stick = (80, -30)
    time.sleep(0.3)
    rider = platform.observe().rider
    np.testing.assert_allclose(rider.deflection, [0.8, 0.3])
    assert platform.observe().time - rider.heartbeat < 0.2
    chair.silent = True
    time.sleep(0.5)
    seen = platform.observe()
    assert seen.time - seen.rider.heartbeat > 0.3


def test_a_joystick_that_speaks_only_when_moved_lives_with_the_encoders(chair, setup):
    chair.silent = True
    platform = Luci(parameters(chair, joystick={"repeats": False})).open(setup)
    try:
        assert platform.observe().rider is None
        chair.stick, chair.silent = (50, 0), False
        time.sleep(0.3)
        chair.silent = True
        time.sleep(0.5)
        seen = platform.observe()
        assert seen.time - seen.rider.heartbeat < 0.2
        np.testing.assert_allclose(seen.rider.deflection, [0.5, 0.0])
    finally:
        platform.close()


def test_a_luci_that_does_not_answer_is_lost(platform, chair):
    drive(platform, 0.2)
    chair.frozen.set()
    time.sleep(0.4)
    assert platform.observe().twist_time < 0.0
    time.sleep(LOST_AFTER)
    with pytest.raises(PlatformError, match="does not answer"):
        platform.apply(FORWARD)
    chair.frozen.clear()


@pytest.mark.parametrize(
    ("lacks", "named"),
    [("joystick", "joystick.repeats"), ("encoders", "encoders"), ("cameras", "cameras")],
)
def test_an_input_that_does_not_come_is_named(setup, lacks, named):
    chair = MockChair(**{lacks: False})
    given = parameters(chair).model_copy(update={"wait": 0.5})
    try:
        with pytest.raises(PlatformError, match=named):
            Luci(given).open(setup)
        assert chair.changes == []  # it never took the chair over
    finally:
        chair.close()


def test_nobody_at_the_address_is_named(setup):
    with pytest.raises(PlatformError, match=r"127\.0\.0\.1:1 "):
        Luci(LuciParameters(host="127.0.0.1", port=1, wait=0.3)).open(setup)


def test_without_the_extra_it_says_what_to_install(setup, monkeypatch):
    monkeypatch.delitem(sys.modules, "cohelm.platforms.luci.client")
    monkeypatch.setitem(sys.modules, "grpc", None)
    with pytest.raises(PlatformError, match=r"cohelm\[luci,web\]"):
        Luci(LuciParameters()).open(setup)
