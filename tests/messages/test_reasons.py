"""Reasons: stable codes for programs and sentences for riders."""

import pytest

from cohelm.messages import Reason

CODES = {
    "not_finite",
    "clock",
    "stale_scan",
    "stale_pose",
    "stale_twist",
    "pose_jump",
    "stale_rider_command",
    "rider_stop",
    "therapist_stop",
    "stop_pressed",
    "stick_back",
    "late",
    "over_limits",
    "too_close",
    "blocked",
    "keepout",
    "edge_ahead",
    "floor_unseen",
    "edges_allowed",
    "fell",
    "no_safe_plan",
    "scan_frozen",
    "scan_implausible",
    "scan_blind",
    "scan_partly_blind",
    "scan_motion",
    "odometry_fault",
    "pose_fault",
    "sensors_disagree",
    "pose_doubtful",
    "lost",
    "drive_fault",
    "drive_weak",
    "stick_stuck",
    "solver_failed",
    "start_blocked",
    "goal_blocked",
    "outside_map",
    "no_path",
    "too_many_wishes",
    "invalid_problem",
    "planning_timeout",
    "planning",
    "arrived",
    "waiting",
    "goal_occupied",
    "replanning",
    "backing_up",
    "reversing",
    "creeping",
    "ask_rider",
    "no_driver",
    "connection_lost",
    "release_stick",
    "confirm",
    "navigator_timeout",
    "navigator_restarts",
    "navigator_failed",
    "program_failed",
    "collision",
    "paused",
    "starting",
}
"""Codes are part of the interface: add here, never rename."""


def test_the_codes_are_stable():
    assert {reason.value for reason in Reason} == CODES
    assert all(Reason(code) == code for code in CODES)


@pytest.mark.parametrize("reason", list(Reason))
def test_each_has_a_sentence_for_the_rider(reason):
    sentence = reason.sentence
    assert sentence[0].isupper()
    assert sentence.endswith(".")
    assert 3 <= len(sentence.split()) <= 14
    assert len(sentence) <= 80
    for jargon in ("_", "NaN", "None", "gate", "MPC", "solver", "timeout", "twist", "error"):
        assert jargon not in sentence


def test_no_two_say_the_same():
    assert len({reason.sentence for reason in Reason}) == len(Reason)
