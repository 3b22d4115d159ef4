"""Why the chair stands: codes that machines keep, sentences that a rider can read."""

import pytest

from cohelm.messages import Reason

CODES = {
    "not_finite",
    "clock",
    "stale_scan",
    "stale_pose",
    "stale_twist",
    "pose_jump",
    "rider_silent",
    "rider_stop",
    "late",
    "over_limits",
    "too_close",
    "blocked",
    "keepout",
    "no_safe_plan",
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
    "replanning",
    "backing_up",
    "creeping",
    "ask_rider",
    "nobody_drives",
    "page_silent",
    "let_go",
    "confirm",
    "navigator_silent",
    "collision",
    "paused",
    "getting_ready",
}
"""They cross the wire: one may be added here, none renamed."""


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
