"""The monitor in rides: nothing without a fault, a stop with its reason for each fault."""

import math
from functools import cache

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.evaluation.episode.episode import run
from cohelm.messages import Reason
from cohelm.scenarios.scenario import load_scenario

ONSET = 2.0
COMMON = ("people.see_robot=false", "time_limit=4.5", "mode=autonomous")


@cache
def ride(*settings):
    ticks = []
    done = run(
        load_scenario("crossing", [*COMMON, *settings]), 3, lambda tick, truth: ticks.append(tick)
    )
    return done, ticks


def faulty(kind, magnitude=None):
    size = "" if magnitude is None else f", magnitude: {magnitude}"
    return ride(f"faults=[{{kind: {kind}, at: {ONSET}, duration: 99{size}}}]")


def findings(ticks):
    return {each.reason for tick in ticks for each in tick.health.findings}


def test_a_ride_without_a_fault_is_the_same_bit_for_bit_without_the_monitor():
    on, ticks = ride()
    off, _ = ride("health.enabled=false")
    assert findings(ticks) == set()
    for name in ("time", "pose", "twist", "command"):
        np.testing.assert_array_equal(getattr(on, name), getattr(off, name))


BELIEVED = [
    ("scan_frozen", None, 0.2),
    ("scan_constant", 0.0, 0.1),
    ("scan_constant", -1.0, 0.1),
    ("scan_constant", 5.0, 0.1),
    ("scan_constant", 1e9, 0.1),
    ("scan_blind", 81.0, 0.2),
    ("scan_free_sector", 180.0, 0.2),
    ("scan_mirrored", None, 0.8),
    ("twist_zero", None, 1.2),
    ("twist_scaled", -1.0, 0.3),
    ("command_flipped", None, 1.2),
    ("kidnapped", 2.0, 0.8),
    ("people_lost", 1.0, 0.4),
]


@pytest.mark.parametrize(("kind", "magnitude", "within"), BELIEVED)
def test_a_fault_that_was_believed_stops_the_chair_with_a_reason(kind, magnitude, within):
    done, ticks = faulty(kind, magnitude)
    stops = [t.observation.time for t in ticks if t.health.stop is not None]
    assert stops
    assert -1e-9 <= stops[0] - ONSET <= within + 1e-9
    first = next(t for t in ticks if t.health.stop is not None)
    assert first.decision.reason is first.health.stop
    assert not first.decision.twist.any()
    assert first.health.stop.sentence.endswith((".", "help."))
    assert abs(done.twist[-1, 0]) < 0.05


def test_doubt_slows_the_chair_and_says_so():
    _, ticks = faulty("scan_rotated", 6.0)
    doubtful = [t for t in ticks if t.health.slow is Reason.POSE_DOUBTFUL]
    assert doubtful
    assert all(t.health.speed_limit < math.inf for t in doubtful)
    assert any(t.decision.reason is Reason.POSE_DOUBTFUL for t in doubtful)


def test_the_same_observation_and_memory_give_the_same_health():
    from cohelm.health import beam_map, monitor
    from cohelm.maps import distance_field
    from cohelm.scenarios.build import build_scenario

    setup = build_scenario(load_scenario("crossing"), 3)
    _, ticks = ride()
    known = beam_map(setup.grid, distance_field(setup.grid))
    last, tick = ticks[40], ticks[41]
    twice = [
        monitor(
            tick.observation,
            tick.request,
            setup.robot,
            known,
            last.memory.health,
            setup.navigator.health,
        )
        for _ in range(2)
    ]
    assert identical(twice[0][0], twice[1][0])
    assert identical(twice[0][0].localisation, tick.health.localisation)
