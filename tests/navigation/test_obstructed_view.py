"""People stay known while somebody at the scanner hides a part of the view."""

import dataclasses

import numpy as np
import pytest

from cohelm.messages import Reason
from cohelm.navigation import Navigator
from cohelm.scenarios import build_scenario, load_scenario
from cohelm.simulation import World

BLIND_FROM, BLIND_TO = 1.5, 3.5
"""Time in which half of the beams end at the scanner itself, s."""


def obstructed(observation):
    """The observation with the beams to the rear and to the right at 0 m."""
    half = [
        dataclasses.replace(
            scan, ranges=np.where(np.arange(len(scan.ranges)) % 4 < 2, 0.0, scan.ranges)
        )
        for scan in observation.scans
    ]
    return dataclasses.replace(observation, scans=tuple(half))


@pytest.fixture(scope="module")
def ticks():
    """(time, truth, tick) of a chair among people whose scanner is obstructed for two seconds."""
    stage = build_scenario(load_scenario("crossing"), 3)
    world, navigator = World(stage.world, 3), Navigator(stage.navigator)
    tick, out = None, []
    while world.truth.time < 5.0:
        now, seen = world.truth.time, world.observe()
        seen = obstructed(seen) if BLIND_FROM <= now < BLIND_TO else seen
        tick = navigator.step(seen, stage.request, tick)
        out.append((now, world.truth, tick))
        world.advance(tick.decision)
    return out


def test_the_chair_stops_while_half_the_view_is_hidden(ticks):
    told = {t.decision.reason for now, _, t in ticks if BLIND_FROM + 0.2 < now < BLIND_TO}
    assert told == {Reason.SCAN_IMPLAUSIBLE}


def test_people_are_tracked_meanwhile(ticks):
    """Tracks follow people who walk; kept as they were they would be 1 m or more behind."""
    there = [(truth, t) for now, truth, t in ticks if BLIND_TO - 0.5 < now < BLIND_TO]
    assert any(len(t.people) for _, t in there)
    for _, t in there:
        assert t.people.time == pytest.approx(t.observation.time)
