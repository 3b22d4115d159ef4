"""Faults of each part do what their names say, and equal seeds give equal faults."""

import runpy
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from cohelm.arrays import identical
from cohelm.messages import Decision, Observation, RiderCommand, Scan
from cohelm.scenarios.build import build_scenario
from cohelm.scenarios.scenario import load_scenario
from cohelm.simulation import FAULT_KINDS, Fault, World
from cohelm.simulation.drivetrain import DriveCommand
from cohelm.simulation.faults import FaultInjector
from cohelm.simulation.faults.drive import TRACK, true_twist, weakened

BEAMS = 360


def observation(time):
    ranges = 2.0 + 0.01 * np.arange(BEAMS) + time
    scan = Scan(
        time=time,
        mount=np.zeros(3),
        angle_min=-np.pi,
        angle_increment=2.0 * np.pi / BEAMS,
        range_max=20.0,
        ranges=ranges,
    )
    return Observation(
        time=time,
        pose=np.array([time, 0.0, 0.0]),
        pose_time=time,
        twist=np.array([1.0, 0.0, 0.1]),
        twist_time=time,
        scans=(scan,),
        rider=RiderCommand(heartbeat=time, deflection=np.array([time / 10.0, 0.0])),
    )


def delivered(kind, magnitude=None, *, onset=1.0, until=2.0, seed=3):
    """Observation at ``until`` of a ride at 10 Hz whose fault begins at ``onset``."""
    fault = Fault(kind=kind, at=onset, duration=100.0, magnitude=magnitude)
    injector = FaultInjector((fault,), seed)
    out = None
    for k in range(round(until * 10) + 1):
        out = injector.observed(observation(k / 10))
    return out


def ranges(kind, magnitude=None, **options):
    return delivered(kind, magnitude, **options).scans[0].ranges


SOUND = observation(2.0).scans[0].ranges


@pytest.mark.parametrize("kind", FAULT_KINDS)
def test_equal_seeds_give_equal_faults_and_the_typical_magnitude_is_allowed(kind):
    if FAULT_KINDS[kind].unit:
        Fault(kind=kind, at=0.0, magnitude=FAULT_KINDS[kind].typical)
    for size in FAULT_KINDS[kind].intensities:
        assert identical(delivered(kind, size), delivered(kind, size))


def test_a_frozen_scan_repeats_the_sweep_before_the_onset_with_new_stamps():
    scan = delivered("scan_frozen").scans[0]
    assert scan.time == pytest.approx(2.0)
    np.testing.assert_array_equal(scan.ranges, observation(0.9).scans[0].ranges)


def test_constant_ranges_and_scaled_ones():
    assert set(ranges("scan_constant", -1.0)) == {-1.0}
    np.testing.assert_allclose(ranges("scan_scaled", 0.5), 0.5 * SOUND)


@pytest.mark.parametrize(
    ("kind", "reads"), [("scan_blind", np.isnan), ("scan_free_sector", np.isinf)]
)
def test_a_sector_of_81_degrees_to_each_side_is_45_percent_of_the_beams(kind, reads):
    lost = reads(ranges(kind, 81.0))
    assert lost.mean() == pytest.approx(2 * 81 / 360, abs=0.01)
    assert lost[BEAMS // 2]  # straight ahead
    assert not lost[0]


@pytest.mark.parametrize("kind", ["scan_free_beams", "scan_spots"])
def test_a_share_of_the_beams_is_disturbed(kind):
    changed = ranges(kind, 0.3) != SOUND
    assert changed.mean() == pytest.approx(0.3, abs=0.1)  # four deviations of 360 draws


@pytest.mark.parametrize("kind", ["scan_glass", "scan_sunlight", "scan_multipath"])
def test_stripes_are_fixed_in_the_map(kind):
    changed = [ranges(kind, 0.25, until=t) != observation(t).scans[0].ranges for t in (1.5, 2.0)]
    assert 0.1 < changed[0].mean() <= 0.26
    assert (changed[0] & changed[1]).sum() > 0.4 * changed[0].sum()


def test_mirrored_twice_is_sound_and_rotated_is_a_roll():
    np.testing.assert_array_equal(ranges("scan_mirrored")[::-1], SOUND)
    np.testing.assert_array_equal(ranges("scan_rotated", 20.0), np.roll(SOUND, 20))


def test_a_restamped_scan_is_old_and_says_it_is_new():
    scan = delivered("scan_restamped", 0.4).scans[0]
    assert scan.time == pytest.approx(2.0)
    np.testing.assert_array_equal(scan.ranges, observation(1.6).scans[0].ranges)
    assert delivered("scan_delayed", 0.4).scans[0].time == pytest.approx(1.6)


def test_drift_grows_with_time():
    assert delivered("pose_drift", 0.05).pose[1] == pytest.approx(0.05)
    assert delivered("pose_turn_drift", 2.0).pose[2] == pytest.approx(np.radians(2.0))


def test_a_stick_is_stuck_or_repeats():
    assert delivered("rider_stuck", 0.3).rider.deflection.tolist() == [0.3, 0.0]
    assert delivered("rider_repeated").rider.deflection[0] == pytest.approx(0.09)
    assert delivered("rider_repeated").rider.heartbeat == pytest.approx(2.0)


def received(kind, magnitude, commands):
    injector = FaultInjector((Fault(kind=kind, at=0.1, duration=9.0, magnitude=magnitude),), 0)
    sent = [Decision(twist=np.array([v, 0.0, v])) for v in commands]
    return [injector.received(each, 0.1 * k).twist.tolist() for k, each in enumerate(sent)]


def test_commands_are_stuck_dead_delayed_scaled_flipped():
    assert received("command_stuck", None, [0.5, 0.4, 0.0])[-1] == [0.5, 0.0, 0.5]
    assert received("command_dead", None, [0.5, 0.4])[-1] == [0.0, 0.0, 0.0]
    assert received("command_delayed", 0.2, [0.5, 0.4, 0.3, 0.2])[-1] == [0.4, 0.0, 0.4]
    assert received("command_scaled", -1.0, [0.5, 0.4])[-1] == [-0.4, 0.0, -0.4]
    assert received("command_flipped", None, [0.5, 0.4])[-1] == [0.4, 0.0, -0.4]
    assert received("command_dropped", 1.0, [0.5, 0.4, 0.3])[-1] == [0.5, 0.0, 0.5]


def test_weak_motors_and_brakes():
    command = DriveCommand(np.ones(2), np.ones(2), np.ones(2), np.ones(2))
    weak = weakened(command, [Fault(kind="brake_slow", at=0.0, magnitude=0.5)])
    np.testing.assert_allclose([*weak.fall, *weak.braking, *weak.rise], [0.5] * 4 + [1.0] * 2)
    # the right wheel loses 30 % of 1 m/s: the mean falls by 0.15, and the chair turns right
    twist = true_twist(np.array([1.0, 0.0, 0.0]), [Fault(kind="motor_weak", at=0.0, magnitude=0.3)])
    np.testing.assert_allclose(twist, [0.85, 0.0, -0.3 / TRACK])


def test_a_carried_chair_is_elsewhere_and_its_localiser_goes_on():
    fault = "faults=[{kind: kidnapped, at: 1.0, duration: 100, magnitude: 2.0}]"
    world = World(build_scenario(load_scenario("empty", [fault]), 0).world, 0)
    apart = []
    for _ in range(30):
        world.advance(Decision(twist=np.array([0.3, 0.0, 0.0])))
        apart.append(float(np.hypot(*(world.truth.pose - world.observe().pose)[:2])))
    # the error of the sound localiser is at most 0.03 m
    assert max(apart[:19]) <= 0.03 + 1e-9
    assert apart[-1] == pytest.approx(2.0, abs=0.04)


def test_nobody_sees_people_who_are_lost():
    settings = ["people.see_robot=false", "faults=[{kind: people_lost, at: 0.5, duration: 9}]"]
    sound = World(build_scenario(load_scenario("crossing", settings[:1]), 0).world, 0)
    lost = World(build_scenario(load_scenario("crossing", settings), 0).world, 0)
    for _ in range(20):
        for world in (sound, lost):
            world.advance(Decision(twist=np.zeros(3)))
    a, b = (
        np.nan_to_num(w.observe().scans[0].ranges, nan=99.0, posinf=99.0) for w in (sound, lost)
    )
    assert (b >= a - 1e-9).all()
    assert (b > a + 0.5).any()


def test_wrong_magnitudes_are_refused():
    with pytest.raises(ValidationError, match="did you mean 'scan_frozen'"):
        Fault(kind="scan_frozn", at=0.0)
    with pytest.raises(ValidationError, match="must lie in"):
        Fault(kind="scan_free_beams", at=0.0, magnitude=1.5)


def test_slip_shows_in_the_odometry_and_not_in_the_motion():
    faults = [Fault(kind="wheel_slip", at=0.0, magnitude=0.5)]
    assert true_twist(np.array([0.5, 0.0, 0.0]), faults)[0] == pytest.approx(0.25)
    moving = replace(observation(2.0), twist=np.array([0.25, 0.0, 0.0]))
    fault = Fault(kind="wheel_slip", at=0.0, duration=9.0, magnitude=0.5)
    assert FaultInjector((fault,), 0).observed(moving).twist[0] == pytest.approx(0.5)


@pytest.mark.parametrize(
    ("kind", "magnitude", "text"),
    [
        ("scan_frozen", 0.5, "scan_frozen has no magnitude, got 0.5"),
        ("scan_glass", 2.0, "magnitude of scan_glass must lie in [0, 1] share, got 2"),
        ("pose_jump", -1.0, "magnitude of pose_jump must be at least 0 m, got -1"),
    ],
)
def test_a_magnitude_that_a_kind_does_not_take_is_refused(kind, magnitude, text):
    with pytest.raises(ValidationError) as error:
        Fault(kind=kind, at=0.0, magnitude=magnitude)
    assert text in str(error.value)


@pytest.mark.parametrize("first", FAULT_KINDS)
def test_two_faults_at_once_raise_nothing_in_any_order(first):
    """Warnings are errors here: no effect computes with what another one made of the input."""
    for second in FAULT_KINDS:
        faults = (
            Fault(kind=first, at=0.2, duration=2.0),
            Fault(kind=second, at=0.4, duration=2.0),
        )
        injector = FaultInjector(faults, 3)
        for k in range(12):
            injector.observed(observation(k / 10))
            decision = injector.received(Decision(twist=np.ones(3)), k / 10)
            injector.twist(decision.twist, k / 10)


@pytest.mark.parametrize("localiser", ["pose_turn_drift", "pose_nan"])
def test_panes_stay_where_they_are_whatever_the_localiser_says(localiser):
    faults = (
        Fault(kind=localiser, at=0.5, duration=9.0),
        Fault(kind="scan_multipath", at=0.5, duration=9.0),
    )
    # Stripes depend on the place in the list, so a fault that never begins stands first.
    never = Fault(kind="late", at=99.0)
    alone, both = FaultInjector((never, faults[1]), 3), FaultInjector(faults, 3)
    for k in range(20):
        one, two = (each.observed(observation(k / 10)) for each in (alone, both))
    np.testing.assert_array_equal(one.scans[0].ranges, two.scans[0].ranges)


def test_the_documents_list_every_kind_with_its_unit_and_bounds():
    script = Path(__file__).parents[3] / "docs" / "figures" / "fault_kinds.py"
    made = runpy.run_path(str(script))
    table = made["table"]()
    assert table in made["PAGE"].read_text(encoding="utf-8"), "run docs/figures/fault_kinds.py"
    assert all(f"| `{name}` |" in table for name in FAULT_KINDS)
