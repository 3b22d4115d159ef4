"""Shared control in a ride: the side that the rider wants, at once, and nothing without a push."""

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.evaluation import Outcome, run
from cohelm.scenarios import load_scenario

from .rides import follow, stage

MANY = [pytest.param(seed, marks=pytest.mark.slow) for seed in range(1, 20)]


@pytest.mark.parametrize("seed", [0, *MANY])
@pytest.mark.parametrize(
    ("side", "sign"), [("left", 1.0), pytest.param("right", -1.0, marks=pytest.mark.slow)]
)
def test_a_push_to_a_side_passes_a_box_on_that_side(side, sign, seed):
    """The box reaches from 6.6 to 7.4 m in x, its centre at y = 7 on the path."""
    ride = run(load_scenario("box", [f"rider.side={side}"]), seed)
    assert ride.outcome is Outcome.REACHED
    assert not ride.hit_wall.any()
    beside = np.abs(ride.pose[:, 0] - 7.0) < 0.4
    assert beside.any()
    assert (sign * (ride.pose[beside, 1] - 7.0) > 0.4).all()


@pytest.mark.parametrize("side", ["left", "right"])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_push_shows_at_the_wheels_within_a_third_of_a_second(side, seed):
    """Against the same ride with the hand at rest; 0.05 rad/s is what counts as turning."""
    at = 4.0
    push = f"rider={{use: nudge, at: {at}, duration: 1.0, side: {side}}}"
    pushed = follow(stage("empty", push, seed=seed), at + 0.35)
    idle = follow(stage("empty", "rider=idle", seed=seed), at + 0.35)
    before = pushed.time < at + 1e-9
    assert np.array_equal(pushed.twist[before], idle.twist[before])
    turn = pushed.twist[:, 2] - idle.twist[:, 2]
    turning = turn > 0.05 if side == "left" else turn < -0.05
    assert turning.any()
    assert pushed.time[turning][0] <= at + 0.3 + 1e-9


def test_eta_steps_as_eq_13_corrected_says():
    push = "rider={use: nudge, at: 2.0, duration: 0.75}"
    log = follow(stage("empty", push), 4.0)
    eta = np.array([tick.authority.eta for tick in log.ticks])
    # intents at 2.0, 2.25 and 2.5 s; each is forgotten after 1 s
    for start, end, i in [
        (0.0, 2.0, 0),
        (2.0, 2.25, 1),
        (2.25, 2.5, 2),
        (2.5, 3.0, 3),
        (3.0, 3.25, 2),
        (3.25, 3.5, 1),
        (3.5, 4.0, 0),
    ]:
        within = (log.time > start - 1e-9) & (log.time < end - 1e-9)
        assert set(eta[within]) == {1.0 - np.exp(-i)}


@pytest.mark.parametrize(
    ("scenario", "limit"), [("box", 14), pytest.param("crossing", 60, marks=pytest.mark.slow)]
)
def test_a_hand_at_rest_in_shared_mode_rides_as_autonomous_bit_for_bit(scenario, limit):
    settings = ["rider=idle", f"time_limit={limit}"]
    shared = run(load_scenario(scenario, [*settings, "mode=shared"]), 0)
    alone = run(load_scenario(scenario, [*settings, "mode=autonomous"]), 0)
    assert not shared.eta.any()
    for field in ("time", "pose", "twist", "command", "people", "gap_wall", "gap_people"):
        assert identical(getattr(shared, field), getattr(alone, field)), field
    assert shared.outcome is alone.outcome
    assert len(shared.stops) == len(alone.stops)


def test_no_device_at_all_rides_as_autonomous_too():
    shared = run(load_scenario("box", ["rider=none", "time_limit=5"]), 0)
    alone = run(load_scenario("box", ["rider=none", "time_limit=5", "mode=autonomous"]), 0)
    assert identical(shared.command, alone.command)


def test_after_a_push_the_chair_finds_back_to_its_goal():
    push = "rider={use: nudge, at: 4.0, duration: 2.0, lateral: 1.0}"
    ride = run(load_scenario("empty", [push]), 0)
    assert ride.outcome is Outcome.REACHED
    assert np.abs(ride.pose[:, 1] - 7.0).max() > 0.3
