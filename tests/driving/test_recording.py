"""A drive that is recorded can be ridden again, whatever was asked for in between."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.driving.messages import Limits, RiderSettings
from cohelm.driving.recording import Recording
from cohelm.driving.wanted import Errand, request_of
from cohelm.evaluation import load_scenario
from cohelm.evaluation.open_loop import replayed
from cohelm.evaluation.staging import set_stage
from cohelm.messages import Mode, RiderCommand, Wish
from cohelm.navigation import Navigator
from cohelm.recordings import RecordedRide
from cohelm.simulation import Newcomer, World

LIMITS = Limits(max_speed=0.7, max_acceleration=0.5, min_distance=0.45)
RIDER = RiderSettings(tremor_filter=0.1)


@pytest.fixture(scope="module")
def stage():
    return set_stage(load_scenario("distracted"), 0)


def asked(stage):
    """What a rider might ask for, each for a third of a second: (request, stick) each."""
    route = stage.route.points
    there = replace(stage.request, wishes=(), speed_limit=0.7)
    nowhere = request_of(Errand(), stage.scenario.profile, LIMITS, RIDER, moves=True)
    wish = Wish(points=route[len(route) // 2][None])
    slower = there.profile.model_copy(update={"preferred_speed": 0.4, "social_distance": 0.8})
    yield nowhere, (0.0, 0.0)
    yield nowhere, (0.6, 0.1)
    yield there, (0.0, 0.0)
    yield replace(there, wishes=(wish,)), (0.3, -0.4)
    yield replace(there, mode=Mode.AUTONOMOUS, profile=slower), (0.0, 0.0)
    yield replace(there, goal=route[len(route) // 3]), (0.0, 0.0)
    yield replace(there, speed_limit=0.0), (0.0, 0.0)
    yield replace(there, stop=True), (0.0, 0.0)
    yield replace(there, farther=0.5), (0.2, 0.0)
    yield replace(nowhere, mode=Mode.MANUAL), (0.5, 0.5)
    yield there, (0.0, 0.0)


def driven(stage, recording, most=None):
    """Drive through all that is asked for; somebody comes in and a step is lost on the way."""
    world, navigator, last = World(stage.world, 0), Navigator(stage.navigator), None
    for k, (request, stick) in enumerate(list(asked(stage))[:most]):
        if k == 3:
            spot = stage.start[:2] + 2.0 * np.array(
                [np.cos(stage.start[2]), np.sin(stage.start[2])]
            )
            world.admit(Newcomer(position=spot, waypoints=np.empty((0, 2))))
        for step in range(6):
            seen = world.observe()
            if (k, step) == (5, 5):  # the navigator was late, and never saw this one
                world.advance(last.decision)
                continue
            hand = RiderCommand(heartbeat=seen.time, deflection=np.array(stick))
            last = navigator.step(replace(seen, rider=hand), request, last)
            recording.add(last, world.truth)
            world.advance(last.decision)


def test_every_tick_is_decided_again_to_the_bit(stage, tmp_path):
    file = tmp_path / "a.mcap"
    with Recording(file, stage) as recording:
        driven(stage, recording)
    ride = RecordedRide(file)
    compared = list(replayed(ride))
    assert len(compared) == 65
    assert all(each.same and each.same_way for each in compared)
    assert not ride.warnings
    modes = [each.tick.request.mode for each in compared]
    assert {Mode.ASSISTED, Mode.AUTONOMOUS, Mode.MANUAL} <= set(modes)


def test_a_world_that_begins_anew_has_a_file_of_its_own(stage, tmp_path):
    file = tmp_path / "a.mcap"
    (tmp_path / "a-3.mcap").write_bytes(b"another's")
    with Recording(file, stage) as recording:
        recording.afresh()  # the first world begins, too
        driven(stage, recording, 1)
        for _ in range(2):
            recording.afresh()
            driven(stage, recording, 1)
    files = [tmp_path / name for name in ("a.mcap", "a-2.mcap", "a-4.mcap")]
    for each in files:
        ticks = list(RecordedRide(each))
        assert len(ticks) == 6
        assert ticks[0].observation.time == 0.0
    assert (tmp_path / "a-3.mcap").read_bytes() == b"another's"
