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
    Predictions,
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


def futures():
    """Two people with three hypotheses, one step."""
    mean = np.arange(24.0).reshape(2, 3, 2, 2)
    return Predictions(
        step=0.5,
        names=("keeps_going", "turns_left", "turns_right"),
        weight=np.array([[0.2, 0.5, 0.3], [0.9, 0.04, 0.06]]),
        mean=mean,
        velocity=-mean,
        deviation=mean[..., 0],
    )


def test_the_most_likely_future_of_each_person():
    got = futures().most_likely()
    assert got.names == ("likeliest",)
    assert got.weight.tolist() == [[1.0], [1.0]]
    assert identical(got.mean[:, 0], futures().mean[[0, 1], [1, 0]])
    assert identical(got.deviation[:, 0], futures().deviation[[0, 1], [1, 0]])


def test_several_likely_futures_in_their_order():
    got = futures().likeliest(2)
    assert got.names == ("likeliest", "likeliest_2")
    # 0.5 : 0.3 and 0.9 : 0.06
    assert got.weight == pytest.approx(np.array([[0.625, 0.375], [0.9375, 0.0625]]))
    assert identical(got.velocity[1], futures().velocity[1, [0, 2]])
    assert futures().likeliest(9).mean.shape == (2, 3, 2, 2)
    with pytest.raises(ValueError, match="not 0"):
        futures().likeliest(0)


def test_futures_of_some_probability():
    got = futures().likely(0.25)
    assert got.weight == pytest.approx(np.array([[0.625, 0.375], [1.0, 0.0]]))
    # nothing else is likely enough of the second: the same once more
    assert identical(got.mean[1, 0], got.mean[1, 1])
    assert futures().likely(0.95).weight.tolist() == [[1.0], [1.0]]


def test_probability_of_what_is_called_so():
    assert futures().probability("turns") == pytest.approx([0.8, 0.1])
    assert futures().probability("keeps_going") == pytest.approx([0.2, 0.9])
    assert futures().probability("flies").tolist() == [0.0, 0.0]


def test_nobody_has_no_future():
    nobody = Predictions(
        step=0.5,
        names=("a", "b"),
        weight=np.empty((0, 2)),
        mean=np.empty((0, 2, 3, 2)),
        velocity=np.empty((0, 2, 3, 2)),
        deviation=np.empty((0, 2, 3)),
    )
    assert nobody.most_likely().mean.shape == (0, 1, 3, 2)
    assert nobody.likely(0.3).mean.shape == (0, 1, 3, 2)
