"""Rider on a Joy topic: each button has an edge of its own; one that is held begins nothing."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from cohelm.live.messages import Heartbeat, ResumeCommand, StopCommand, TakeControl
from cohelm.ros2 import rider_node
from cohelm.ros2.parameters import Ros2Parameters, StickParameters

DEAD_MAN, CONFIRM, STOP, OTHER = 4, 0, 1, 7


class Chair:
    """Drive that records what it receives, and the node before it."""

    def __init__(self, monkeypatch, **stick):
        self.received, self.now, self.take = [], 100.0, {}
        network = SimpleNamespace(
            subscribe=lambda topic, kind, quality, take: self.take.update({topic: take}),
            start=lambda: None,
        )
        monkeypatch.setattr(rider_node, "make_node", lambda parameters, name: network)
        monkeypatch.setattr(rider_node.time, "monotonic", lambda: self.now)
        parameters = Ros2Parameters(stick=StickParameters(**stick), displays=False, actions=False)
        drive = SimpleNamespace(
            connect=lambda client, role: None,
            receive=lambda client, message, arrival=None: self.received.append(message),
        )
        rider_node.RiderNode(parameters, drive, None)

    def joy(self, *held, forward=0.0, left=0.0, repeat=1, pause=0.1):
        """Send a message with these buttons, as often as the driver repeats it."""
        axes = np.array([left, forward], dtype=np.float32)
        buttons = np.array([int(n in held) for n in range(8)], dtype=np.int32)
        for _ in range(repeat):
            self.now += pause
            self.take["/joy"](SimpleNamespace(axes=axes, buttons=buttons))

    def count(self, kind):
        return sum(isinstance(each, kind) for each in self.received)


@pytest.fixture
def chair(monkeypatch):
    found = Chair(monkeypatch, dead_man=DEAD_MAN)
    found.joy()
    return found


@pytest.mark.parametrize("latched", [DEAD_MAN, CONFIRM, OTHER])
def test_a_latched_button_masks_no_other(chair, latched):
    chair.joy(latched, repeat=5)
    before = [chair.count(kind) for kind in (StopCommand, ResumeCommand, TakeControl)]
    for _ in range(3):
        for button in (STOP, CONFIRM, DEAD_MAN):
            chair.joy(latched, button, repeat=5)
            chair.joy(latched, repeat=5)
    after = [chair.count(kind) for kind in (StopCommand, ResumeCommand, TakeControl)]
    expected = [3, 0 if latched == CONFIRM else 3, 0 if latched == DEAD_MAN else 3]
    assert [b - a for a, b in zip(before, after, strict=True)] == expected


def test_a_latched_stop_button_stops_once(chair):
    chair.joy(STOP, repeat=50)
    chair.joy(STOP, OTHER, forward=0.3, repeat=50)
    assert chair.count(StopCommand) == 1


@pytest.mark.parametrize("away", [math.inf, 0.5])
def test_a_button_held_as_the_stick_comes_may_stop_but_never_confirms(monkeypatch, away):
    chair = Chair(monkeypatch, dead_man=DEAD_MAN)
    if math.isfinite(away):
        chair.joy()
        chair.now += away
    chair.joy(STOP, CONFIRM, DEAD_MAN, repeat=5)
    assert (chair.count(StopCommand), chair.count(ResumeCommand)) == (1, 0)
    chair.joy(DEAD_MAN)
    chair.joy(DEAD_MAN, CONFIRM)
    assert chair.count(ResumeCommand) == 1


def test_a_stuck_dead_man_button_does_not_take_control_again(chair):
    chair.joy(DEAD_MAN, repeat=60)  # longer than it counts without a change
    assert not [each for each in chair.received if isinstance(each, Heartbeat)][-1].visible
    chair.joy(DEAD_MAN, forward=0.4)
    assert [each for each in chair.received if isinstance(each, Heartbeat)][-1].visible
    assert chair.count(TakeControl) == 1


@pytest.mark.parametrize("dead_man", [DEAD_MAN, None])
def test_stop_counts_beside_an_axis_that_is_no_number(monkeypatch, dead_man):
    chair = Chair(monkeypatch, dead_man=dead_man)
    chair.joy()
    with pytest.raises(ValueError, match="number"):
        chair.joy(STOP, forward=math.nan)
    assert chair.count(StopCommand) == 1
