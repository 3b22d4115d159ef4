import dataclasses

import numpy as np
import pytest

from cohelm.control.terms import InputEffort, PathProgress, SeatComfort, SmoothInput, TrackReference
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem

TERMS = {
    "track_reference": TrackReference(
        TrackReference.Parameters(position=1.0, heading=0.3, terminal=4.0)
    ),
    "input_effort": InputEffort(InputEffort.Parameters(speed=0.8, turn=0.25)),
    "input_effort as printed": InputEffort(InputEffort.Parameters(input_cost="printed")),
    "smooth_input": SmoothInput(SmoothInput.Parameters(speed=0.08, turn=0.04)),
    "track_reference across": TrackReference(TrackReference.Parameters(along=0.25)),
    "progress": PathProgress(PathProgress.Parameters(pace=0.7)),
    "progress without a weight": PathProgress(),
    "comfort": SeatComfort(SeatComfort.Parameters(acceleration=0.1, jerk=0.02)),
    "comfort, jerk alone": SeatComfort(SeatComfort.Parameters(jerk=0.02)),
    "comfort without weights": SeatComfort(),
}


@pytest.mark.parametrize("moves", ["as a chair", "any way"])
@pytest.mark.parametrize("name", TERMS)
def test_the_model_is_of_the_derivative_of_the_residual_through_the_rollout(name, moves, motions):
    rng = np.random.default_rng(3)
    for _ in range(5):
        problem = random_problem(rng, 0, steps=12).problem
        problem = problem if moves == "as a chair" else motions.any_way(problem)
        trajectory = motions.wandering(problem, rng)
        term, residual = TERMS[name], TERMS[name].residual(problem, trajectory)
        hessian, gradient = term.model(
            problem, trajectory, motions.sensitivity(problem, trajectory)
        )
        numeric = motions.slope(lambda m: TERMS[name].residual(problem, m), problem, trajectory)  # noqa: B023  # used at once
        # rounding: residuals of up to 30 m·√(4 s) at 2e-16, over a push of 1e-6, times r or J
        assert np.abs(gradient - residual @ numeric).max() < 1e-5
        assert np.abs(hessian - numeric.T @ numeric).max() < 1e-6


def test_nothing_costs_anything_on_the_reference(motions):
    problem = local_problem(steps=10, step=0.2, speed=0.8, wanted=0.8)
    inputs = np.tile([0.8, 0.0], (10, 1))
    trajectory = dataclasses.replace(
        motions.standing(problem),
        poses=problem.reference.poses,
        inputs=inputs,
        current_input=inputs[0],
    )
    for name in TERMS.keys() - {"input_effort as printed"}:
        assert np.abs(TERMS[name].residual(problem, trajectory)).max(initial=0.0) < 1e-12


def test_costs_by_hand(motions):
    """A chair that stands, ten steps of 0.2 s, while the reference goes ahead at 0.8 m/s."""
    problem = local_problem(steps=10, step=0.2, speed=0.0, wanted=0.8)
    trajectory = motions.standing(problem)
    cost = {name: 0.5 * np.sum(t.residual(problem, trajectory) ** 2) for name, t in TERMS.items()}
    # ½ · 0.2 s · Σ (0.16 k)², k = 1…10, Σ k² = 385; and ½ · 4 s · 1.6² for the last one
    assert cost["track_reference"] == pytest.approx(0.1 * 0.0256 * 385 + 2.0 * 2.56)
    # ½ · 0.8 · 2 s · 0.8²
    assert cost["input_effort"] == pytest.approx(0.4 * 2.0 * 0.64)
    assert cost["input_effort as printed"] == 0.0
    assert cost["smooth_input"] == cost["comfort"] == 0.0
    # the distance is along the reference: a quarter of its cost
    assert cost["track_reference across"] == pytest.approx(0.25 * cost["track_reference"])
    # ½ · 0.7 · 2 s · 0.8²
    assert cost["progress"] == pytest.approx(0.35 * 2.0 * 0.64)


def test_a_sudden_start_is_not_smooth(motions):
    problem = local_problem(steps=10, step=0.2)
    trajectory = dataclasses.replace(motions.standing(problem), inputs=np.tile([0.1, 0.0], (10, 1)))
    residual = TERMS["smooth_input"].residual(problem, trajectory)
    # 0.1 m/s in 0.2 s is 0.5 m/s²: ½ · 0.08 · 0.5² · 0.2 s
    assert 0.5 * residual @ residual == pytest.approx(0.5 * 0.08 * 0.25 * 0.2)


def test_the_heading_of_the_reference_is_not_wrapped(motions):
    """A reference that has turned once round is a whole turn away from a chair that has not."""
    problem = local_problem(steps=10, step=0.2)
    trajectory = motions.standing(problem)
    turn = np.array([0.0, 0.0, 2.0 * np.pi])
    further = dataclasses.replace(problem.reference, poses=problem.reference.poses + turn)
    there = dataclasses.replace(problem, reference=further)
    term = TERMS["track_reference"]
    difference = term.residual(there, trajectory) - term.residual(problem, trajectory)
    # √(0.3 · 0.2 s) a turn
    assert difference.reshape(10, 3)[0] == pytest.approx([0, 0, -np.sqrt(0.06) * 2.0 * np.pi])


def test_going_beside_the_reference_at_its_pace_is_progress(motions):
    """1 m to the left of a reference that goes on at 0.8 m/s, along it and against it."""
    problem = local_problem(steps=10, step=0.2, speed=0.8, wanted=0.8)
    term = TERMS["progress"]
    beside = dataclasses.replace(
        motions.standing(problem), poses=problem.reference.poses + np.array([0.0, 1.0, 0.3])
    )
    assert np.abs(term.residual(problem, beside)).max() < 1e-12
    # in circles at any speed: back at each turn, where ½ · 0.7 · 2 s · 0.8² is owed at least
    around = np.linspace(0.0, 4.0 * np.pi, 11)
    circles = np.column_stack([np.cos(around), np.sin(around), around])
    residual = term.residual(problem, dataclasses.replace(beside, poses=circles))
    assert 0.5 * residual @ residual >= 0.35 * 2.0 * 0.64


def test_turning_at_speed_is_felt_as_braking_is(motions):
    """1 m/s and 0.5 rad/s is 0.5 m/s² sideways; so is slowing down by 0.1 m/s in 0.2 s."""
    problem = local_problem(steps=4, step=0.2)
    term = SeatComfort(SeatComfort.Parameters(acceleration=2.0))
    still = motions.standing(problem)
    turning = dataclasses.replace(
        still, inputs=np.tile([1.0, 0.5], (4, 1)), current_input=np.array([1.0, 0.5])
    )
    # √(2 · 0.2 s) · 0.5 m/s²
    expected = np.sqrt(0.4) * np.tile([0.0, 0.5], (4, 1))
    assert term.residual(problem, turning).reshape(4, 2) == pytest.approx(expected)
    speeds = np.array([0.9, 0.8, 0.7, 0.6])
    braking = dataclasses.replace(
        still, inputs=np.stack([speeds, np.zeros(4)], axis=-1), current_input=np.array([1.0, 0.0])
    )
    assert term.residual(problem, braking).reshape(4, 2) == pytest.approx(
        -np.sqrt(0.4) * np.tile([0.5, 0.0], (4, 1))
    )
    jerk = SeatComfort(SeatComfort.Parameters(jerk=2.0))
    assert np.abs(jerk.residual(problem, braking)).max() < 1e-12
    sudden = dataclasses.replace(braking, current_input=np.array([0.9, 0.0]))
    # from 0 to −0.5 m/s² in 0.2 s: √(2 · 0.2 s) · 2.5 m/s³
    assert jerk.residual(problem, sudden)[0] == pytest.approx(-np.sqrt(0.4) * 2.5)


def test_circling_is_felt_alike_however_the_robot_faces(motions):
    """1 m/s on a circle at 0.5 rad/s: to its centre, whether it goes ahead or to the left."""
    problem = motions.any_way(local_problem(steps=3, step=0.2))
    term = SeatComfort(SeatComfort.Parameters(acceleration=1.0 / 0.2))
    for velocity, centre in (([1.0, 0.0], [0.0, 0.5]), ([0.0, 1.0], [-0.5, 0.0])):
        u = np.array([*velocity, 0.5])
        trajectory = dataclasses.replace(
            motions.standing(problem), inputs=np.tile(u, (3, 1)), current_input=u
        )
        felt = term.residual(problem, trajectory).reshape(3, 2)
        assert felt == pytest.approx(np.tile(centre, (3, 1)))


def test_who_moves_any_way_may_face_any_way(motions):
    """Along the reference at its speed, looking to its left: no effort but in facing."""
    plain = local_problem(steps=5, step=0.2, speed=0.8, wanted=0.8)
    problem = motions.any_way(plain)
    poses = problem.reference.poses + np.array([0.0, 0.0, np.pi / 2.0])
    trajectory = dataclasses.replace(
        motions.standing(problem), poses=poses, inputs=np.tile([0.0, -0.8, 0.0], (5, 1))
    )
    assert np.abs(TERMS["input_effort"].residual(problem, trajectory)).max() < 1e-12
