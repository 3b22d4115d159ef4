"""A LUCI chair driven live: the rider's joystick and a page in, the remote joystick out."""

import contextlib
import re
import time
from pathlib import Path

import pytest

pytest.importorskip("grpc", reason="needs the extra luci")

from cohelm.cli import drive as drive_command
from cohelm.cli.requests import DriveRequest
from cohelm.live import Drive
from cohelm.live.messages import ChairState, Heartbeat, ResumeCommand, SetMode, TakeControl
from cohelm.messages import Mode

from .mock_chair import MockChair

GUIDE = Path(__file__).parents[3] / "docs" / "your-robot.md"
pytestmark = pytest.mark.slow
START = 180.0
"""Maximum time for kernels and processes to be ready, s."""
STOP_TIME = 0.35
"""Bound of the issue: zero within 0.3 s and one control step."""


class Page:
    """A page that beats ten times a second."""

    def __init__(self, drive):
        self.drive, self.seq, self.state = drive, 0, None
        drive.listen(self._take)

    def _take(self, message, _):
        if isinstance(message, ChairState):
            self.state = message

    def beat_until(self, done, timeout):
        end = time.monotonic() + timeout
        while time.monotonic() < end:
            now = time.monotonic()
            self.seq += 1
            self.drive.receive("a", Heartbeat(seq=self.seq, sent=1000.0 * now), now)
            if self.state is not None and done(self.state):
                return True
            time.sleep(0.1)
        return False

    def go_on(self):
        assert self.beat_until(lambda state: state.link == "confirm", START)
        self.drive.receive("a", ResumeCommand())
        assert self.beat_until(lambda state: state.link == "ready", 5.0)


@pytest.fixture
def chair():
    made = MockChair()
    yield made
    made.close()


@pytest.fixture
def page(chair, tmp_path):
    blocks = dict(re.findall(r"```yaml\n# ([\w.-]+)[^\n]*\n(.*?)```", GUIDE.read_text(), re.DOTALL))
    (tmp_path / "luci-chair.yaml").write_text(blocks["luci-chair.yaml"])
    file = tmp_path / "luci.yaml"
    here = f"host: 127.0.0.1\n  port: {chair.port}"
    file.write_text(re.sub(r"host: [\d.]+", here, blocks["luci.yaml"]))
    with contextlib.ExitStack() as files:
        request = DriveRequest(platform=str(file), data=tmp_path / "data")
        drive = Drive(drive_command.drive_setup(request, files))
        yield from driven(drive)


def driven(drive):
    made = Page(drive)
    drive.start()
    try:
        assert made.beat_until(lambda _: drive.health.ready, START)
        drive.connect("a", "driver")
        drive.receive("a", TakeControl())
        drive.receive("a", SetMode(mode=Mode.ASSISTED))
        made.go_on()
        yield made
    finally:
        drive.close()


def moves(chair):
    return bool(chair.commands()) and chair.commands()[-1][0] > 0


def stop_time(chair, since):
    """Time from a fault to the last message that moves the chair, s."""
    return max(each.at for each in chair.heard if each.forward_back != 100) - since


def test_the_rider_s_joystick_moves_the_chair_while_the_page_is_there(page, chair):
    assert not any(forward for forward, _ in chair.commands())
    chair.stick = (70, 0)
    assert page.beat_until(lambda _: moves(chair), 5.0)
    page.beat_until(lambda _: False, 1.0)
    began = time.monotonic()
    page.beat_until(lambda _: False, 2.0)
    rate = len(chair.commands(began)) / (time.monotonic() - began)
    assert rate == pytest.approx(20.0, rel=0.1)
    fault = time.monotonic()  # the page is gone; LUCI repeats the held joystick for ever
    time.sleep(1.5)
    assert not moves(chair)
    assert stop_time(chair, fault) <= STOP_TIME + 0.1  # its last beat is up to 0.1 s older


def test_a_silent_joystick_stops_the_chair(page, chair):
    chair.stick = (70, 0)
    assert page.beat_until(lambda _: moves(chair), 5.0)
    page.beat_until(lambda _: False, 0.5)
    chair.silent, fault = True, time.monotonic()
    assert page.beat_until(lambda _: not moves(chair), 1.0)
    page.beat_until(lambda _: False, 0.5)
    assert stop_time(chair, fault) <= STOP_TIME
    assert page.state.reason.code == "stale_rider_command"
    chair.silent = False  # still held: nothing moves before it is released
    page.beat_until(lambda _: False, 1.0)
    assert not moves(chair)
