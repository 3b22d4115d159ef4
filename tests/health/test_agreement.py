"""Pose against odometry, command against motion, stick against its past."""

import dataclasses

import numpy as np
import pytest

from cohelm.health import HealthParameters
from cohelm.health.agreement import disagreement, update_motion
from cohelm.health.evidence import NO_EVIDENCE, RULES, findings, update_evidence, without_latched
from cohelm.health.monitor import update_drive
from cohelm.health.stick import update_stick
from cohelm.messages import Mode, Observation, Reason, Request, RiderCommand
from cohelm.robots import load_robot, move

P = HealthParameters()
ROBOT = load_robot("quantum_q6_edge")
DT = 0.05


def seen(time, pose, twist, command=None, stick=None):
    rider = None if stick is None else RiderCommand(heartbeat=time, deflection=np.array(stick))
    return dataclasses.replace(
        Observation.at_rest(time, pose=np.asarray(pose, dtype=float)),
        twist=np.asarray(twist, dtype=float),
        command=None if command is None else np.array([command, 0.0, 0.0]),
        rider=rider,
    )


def drive(seconds, reported):
    """Largest disagreement of a ride along x; ``reported`` gives the pose for a true one."""
    memory, pose, worst = None, np.zeros(3), 0.0
    twist = np.array([0.6, 0.0, 0.2])
    for k in range(round(seconds / DT)):
        memory = update_motion(memory, seen(k * DT, reported(pose, k * DT), twist), P)
        worst = max(worst, disagreement(memory, P))
        pose = move(pose, twist, DT)
    return worst


def test_a_sound_localiser_agrees_with_the_wheels():
    rng = np.random.default_rng(2)

    def noisy(pose, _):
        return pose + rng.uniform(-1, 1, 3) * [0.03, 0.03, np.radians(1.0)]

    assert drive(0.1, noisy) < 1.0
    assert drive(10.0, noisy) < 1.0


@pytest.mark.parametrize("gap", [1, 3, 6, 9])
def test_sound_odometry_agrees_where_a_slow_computer_sees_few_of_its_values(gap):
    """Turns to and fro as about a corner; with the newest speeds alone, 6 and 9 were a fault."""
    memory, pose, worst = None, np.zeros(3), 0.0
    for k in range(240):
        time = k * DT
        twist = np.array([0.5 - 0.3 * np.cos(1.5 * time), 0.0, 0.6 * np.sin(1.5 * time)])
        if k % gap == 0:
            memory = update_motion(memory, seen(time, pose, twist), P)
            worst = max(worst, disagreement(memory, P))
        middle = time + 0.5 * DT
        turn = 0.6 * np.sin(1.5 * middle)
        pose = move(pose, np.array([0.5 - 0.3 * np.cos(1.5 * middle), 0.0, turn]), DT)
    assert worst < 0.6


@pytest.mark.parametrize("drift", [(0.0, 0.15, 0.0), (0.0, 0.0, np.radians(3.0))])
def test_a_drift_disagrees(drift):
    assert drive(6.0, lambda pose, t: pose + np.array(drift) * t) > 1.0


def test_a_jump_begins_anew_and_is_remembered():
    memory = update_motion(None, seen(0.0, [0, 0, 0], [0, 0, 0]), P)
    memory = update_motion(memory, seen(DT, [0.5, 0, 0], [0, 0, 0]), P)
    assert memory.jumped == DT
    assert len(memory.rows) == 1


def follow(commands, measured):
    memory, found = None, []
    for k, (c, v) in enumerate(zip(commands, measured, strict=True)):
        memory, symptom = update_drive(
            memory, seen(k * DT, [0, 0, 0], [v, 0, 0], command=c), ROBOT, P
        )
        found.append(symptom)
    return found


def response(commands, ramp=1.0, gain=1.0):
    """Speeds of a drive with the robot's lag whose ramps are a share of the stated ones."""
    v, setpoint, out = 0.0, 0.0, []
    follow_share = 1.0 - np.exp(-DT / ROBOT.actuation_lag)
    for command in commands:
        out.append(v)
        up, down = ramp * ROBOT.max_acceleration * DT, ramp * ROBOT.max_deceleration * DT
        setpoint += np.clip(gain * command - setpoint, -down, up)
        v += follow_share * (setpoint - v)
    return out


STEPS = [0.8] * 40 + [0.0] * 40


def test_a_sound_drive_stays_in_its_band():
    assert set(follow(STEPS, response(STEPS))) == {None}


def test_wheels_that_drive_on_are_a_fault_within_half_a_second_beyond_braking():
    stuck = [*response(STEPS)[:40], *[0.8] * 40]
    first = follow(STEPS, stuck).index(Reason.DRIVE_FAULT)
    # the slow model brakes with 0.75 m/s² after 0.2 s; 0.12 + 0.08·0.8 m/s beyond it, and 0.04 m
    assert 40 < first <= 40 + round(0.8 / DT)


def test_dead_and_weak_motors():
    dead = follow(STEPS[:40], [0.0] * 40)
    assert dead[-1] is Reason.DRIVE_FAULT
    weak = follow(STEPS[:40], response(STEPS[:40], gain=0.6))
    assert Reason.DRIVE_WEAK in weak


def test_a_gap_or_an_unknown_command_begins_anew():
    memory, _ = update_drive(None, seen(0.0, [0, 0, 0], [0.8, 0, 0], command=0.0), ROBOT, P)
    assert update_drive(memory, seen(9.0, [0, 0, 0], [0.8, 0, 0], command=0.0), ROBOT, P)[1] is None
    assert update_drive(memory, seen(DT, [0, 0, 0], [0.8, 0, 0]), ROBOT, P) == (None, None)


def stuck_for(seconds, stick, mode=Mode.STOP_ONLY, twist=(0.0, 0.0, 0.0), goal=(0.0, 0.0)):
    request = Request(goal=np.array(goal), mode=mode)
    memory, symptom = None, None
    for k in range(round(seconds / DT) + 1):
        memory, symptom = update_stick(
            memory, seen(k * DT, [0, 0, 0], twist, stick=stick), request, P
        )
    return symptom


def test_a_deflection_that_never_changes_before_a_standing_chair():
    assert stuck_for(P.stuck_time + DT, [1.0, 0.0]) is Reason.STICK_STUCK
    assert stuck_for(P.stuck_time - 0.5, [1.0, 0.0]) is None
    assert stuck_for(P.stuck_time + 1.0, [0.0, 0.0]) is None
    assert stuck_for(P.stuck_time + 1.0, [1.0, 0.0], twist=(0.5, 0.0, 0.0)) is None
    assert stuck_for(P.stuck_time + 1.0, [1.0, 0.0], mode=Mode.AUTONOMOUS) is None


def test_a_chair_with_a_destination_drives_there_with_any_stick():
    stuck = P.stuck_time + 1.0
    assert stuck_for(stuck, [1.0, 0.0], mode=Mode.SHARED) is None
    nowhere = (np.nan, np.nan)
    assert stuck_for(stuck, [1.0, 0.0], mode=Mode.SHARED, goal=nowhere) is Reason.STICK_STUCK
    assert stuck_for(stuck, [1.0, 0.0], mode=Mode.ASSISTED) is Reason.STICK_STUCK


def test_a_symptom_is_confirmed_when_it_lasts_and_ends_when_it_stays_away():
    evidence, reason = NO_EVIDENCE, Reason.LOST
    rule = RULES[reason]
    for k in range(5):
        evidence = update_evidence(evidence, [reason], k * 0.1)
        assert bool(findings(evidence)) == (k * 0.1 >= rule.confirm)
    end = 0.4 + rule.release
    assert findings(update_evidence(evidence, [], end - 0.01))
    assert not findings(update_evidence(evidence, [], end))


def test_a_latched_finding_holds_until_stop_is_pressed():
    evidence = update_evidence(NO_EVIDENCE, [Reason.DRIVE_FAULT], 0.0)
    evidence = update_evidence(evidence, [], 99.0)
    assert findings(evidence)[0].latched
    assert not findings(without_latched(evidence))
    for k in range(11):
        evidence = update_evidence(evidence, [Reason.LOST], 100.0 + 0.1 * k)
    assert {each.reason for each in findings(evidence)} == {Reason.LOST, Reason.DRIVE_FAULT}
    assert [each.reason for each in findings(without_latched(evidence))] == [Reason.LOST]
