import dataclasses

import numpy as np
import pytest
from hypothesis import given

from cohelm import messages
from cohelm.arrays import identical
from cohelm.messages import (
    Groups,
    LocalPlan,
    Observation,
    People,
    Reason,
    Request,
    RiderProfile,
    Status,
    Wish,
    WishReport,
)
from cohelm.testing.strategies import people, references, rider_commands, scans

VALUES = [
    cls for name in messages.__all__ if dataclasses.is_dataclass(cls := getattr(messages, name))
]


@pytest.mark.parametrize("cls", VALUES)
def test_every_value_is_frozen_and_has_nothing_beside_its_fields(cls):
    assert cls.__dataclass_params__.frozen
    assert "__slots__" in vars(cls)


def test_nobody_is_n_zero():
    nobody = People.empty(3.0, source="given")
    assert len(nobody) == 0
    assert (nobody.mean.shape, nobody.covariance.shape) == ((0, 4), (0, 4, 4))
    assert (nobody.time, nobody.source) == (3.0, "given")


def test_everyone_alone_is_no_group():
    groups = Groups.alone(3)
    assert groups.member.tolist() == [-1, -1, -1]
    assert len(groups.id) == 0


@given(people())
def test_people_must_agree_in_number(who):
    with pytest.raises(ValueError, match="People"):
        dataclasses.replace(who, radius=np.zeros(len(who) + 1))


@given(references())
def test_a_reference_has_a_speed_for_every_pose(reference):
    assert len(reference.speeds) == len(reference.poses)
    with pytest.raises(ValueError, match="speeds"):
        dataclasses.replace(reference, speeds=reference.speeds[1:])


@given(scans(), rider_commands())
def test_an_observation_carries_what_arrived(scan, command):
    seen = Observation(
        time=1.0,
        pose=np.zeros(3),
        pose_time=1.0,
        twist=np.zeros(3),
        twist_time=1.0,
        scans=(scan,),
        rider=command,
    )
    assert seen.scans[0] is scan
    assert identical(seen, dataclasses.replace(seen))


def test_a_plan_has_one_pose_more_than_inputs():
    plan = LocalPlan(
        time=0.0,
        step=0.1,
        command=np.zeros(3),
        poses=np.zeros((26, 3)),
        inputs=np.zeros((25, 2)),
        status=Status.OK,
    )
    with pytest.raises(ValueError, match="LocalPlan"):
        dataclasses.replace(plan, poses=np.zeros((25, 3)))


def test_a_plan_s_costs_cannot_be_changed_by_default():
    plan = LocalPlan(
        time=0.0,
        step=0.1,
        command=np.zeros(3),
        poses=np.zeros((2, 3)),
        inputs=np.zeros((1, 2)),
        status=Status.OK,
    )
    with pytest.raises(TypeError):
        plan.costs["tracking"] = 1.0


def test_a_request_asks_for_no_more_than_a_goal():
    request = Request(goal=np.array([1.0, 2.0]))
    assert request.wishes == ()
    assert request.mode == "shared"
    assert np.isinf(request.speed_limit)


def test_a_wish_names_points():
    with pytest.raises(ValueError, match="points"):
        Wish(points=np.zeros((3, 3)))
    assert WishReport(closest=np.empty(0)).extra_length == 0.0


@pytest.mark.parametrize("reason", Reason)
def test_every_reason_has_a_code_and_a_sentence_for_the_rider(reason):
    assert reason == reason.value == str(reason)
    assert reason.value == reason.value.lower()
    assert reason.sentence.endswith(".")
    assert reason.sentence[0].isupper()


def test_reasons_are_as_they_always_were():
    """Codes cross the wire; new ones may be added."""
    assert {
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
        "no_safe_plan",
        "solver_failed",
        "start_blocked",
        "goal_blocked",
        "outside_map",
        "no_path",
        "planning",
        "arrived",
    } <= {reason.value for reason in Reason}


def test_the_default_profile_is_pinned():
    assert RiderProfile().model_dump() == {
        "preferred_speed": 0.8,
        "clearance": 0.05,
        "social_distance": 0.45,
        "passing_side": "none",
        "tremor_filter": 0.0,
        "dead_zone": 0.05,
        "tight_speed": 3.0,
    }
