"""A drive that is recorded can be ridden again, whatever was asked for in between."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.evaluation.episode.open_loop import replay_ride
from cohelm.live.control.mission import Mission, request_of
from cohelm.live.messages import Limits, RiderSettings
from cohelm.live.sessions.mcap_recording import DriveRecording
from cohelm.messages import Mode, RiderCommand, Wish
from cohelm.navigation import Navigator
from cohelm.recordings import RecordedRide
from cohelm.scenarios import load_scenario
from cohelm.scenarios.build import build_scenario
from cohelm.simulation import NewPedestrian, World

LIMITS = Limits(max_speed=0.7, max_acceleration=0.5, min_distance=0.45)
RIDER = RiderSettings(tremor_filter=0.1)


@pytest.fixture(scope="module")
def ride_setup():
    return build_scenario(load_scenario("distracted"), 0)


def asked(ride_setup):
    """What a rider might ask for, each for a third of a second: (request, stick) each."""
    route = ride_setup.route.points
    there = replace(ride_setup.request, wishes=(), speed_limit=0.7)
    nowhere = request_of(Mission(), ride_setup.scenario.profile, LIMITS, RIDER, moves=True)
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
    yield replace(there, extra_clearance=0.5), (0.2, 0.0)
    yield replace(nowhere, mode=Mode.MANUAL), (0.5, 0.5)
    yield there, (0.0, 0.0)


def driven(ride_setup, recording, most=None):
    """Drive through all that is asked for; somebody comes in and a step is lost on the way."""
    world, navigator, last = World(ride_setup.world, 0), Navigator(ride_setup.navigator), None
    for k, (request, stick) in enumerate(list(asked(ride_setup))[:most]):
        if k == 3:
            spot = ride_setup.start[:2] + 2.0 * np.array(
                [np.cos(ride_setup.start[2]), np.sin(ride_setup.start[2])]
            )
            world.spawn(NewPedestrian(position=spot, waypoints=np.empty((0, 2))))
        for step in range(6):
            seen = world.observe()
            if (k, step) == (5, 5):  # the navigator was late, and never saw this one
                world.advance(last.decision)
                continue
            hand = RiderCommand(heartbeat=seen.time, deflection=np.array(stick))
            last = navigator.step(replace(seen, rider=hand), request, last)
            recording.add(last, world.truth)
            world.advance(last.decision)


def test_every_tick_is_decided_again_to_the_bit(ride_setup, tmp_path):
    file = tmp_path / "a.mcap"
    with DriveRecording(file, ride_setup) as recording:
        driven(ride_setup, recording)
    ride = RecordedRide(file)
    compared = list(replay_ride(ride))
    assert len(compared) == 65
    assert all(each.same and each.same_inputs for each in compared)
    assert not ride.warnings
    modes = [each.tick.request.mode for each in compared]
    assert {Mode.ASSISTED, Mode.AUTONOMOUS, Mode.MANUAL} <= set(modes)


def test_a_world_that_begins_anew_has_a_file_of_its_own(ride_setup, tmp_path, capsys):
    file = tmp_path / "a.mcap"
    (tmp_path / "a-3.mcap").write_bytes(b"another's")
    with DriveRecording(file, ride_setup) as recording:
        recording.restart()  # the first world begins, too
        driven(ride_setup, recording, 1)
        for _ in range(2):
            recording.restart()
            driven(ride_setup, recording, 1)
    files = [tmp_path / name for name in ("a.mcap", "a-4.mcap", "a-5.mcap")]
    assert capsys.readouterr().out.splitlines() == [f"recording {each}" for each in files]
    for each in files:
        ticks = list(RecordedRide(each))
        assert len(ticks) == 6
        assert ticks[0].observation.time == 0.0
    assert (tmp_path / "a-3.mcap").read_bytes() == b"another's"
