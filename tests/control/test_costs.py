import dataclasses

import numpy as np
import pytest

from cohelm.control.costs import InputEffort, SmoothInput, TrackReference
from cohelm.testing.problems import random_problem
from cohelm.testing.scenes import local_problem

TERMS = {
    "track_reference": TrackReference(
        TrackReference.Parameters(position=1.0, heading=0.3, terminal=4.0)
    ),
    "input_effort": InputEffort(InputEffort.Parameters(speed=0.8, turn=0.25)),
    "input_effort as printed": InputEffort(InputEffort.Parameters(input_cost="printed")),
    "smooth_input": SmoothInput(SmoothInput.Parameters(speed=0.08, turn=0.04)),
}


@pytest.mark.parametrize("name", TERMS)
def test_the_model_is_of_the_derivative_of_the_residual_through_the_rollout(name, motions):
    rng = np.random.default_rng(3)
    for _ in range(5):
        problem = random_problem(rng, 0, steps=12).problem
        motion = motions.wandering(problem, rng)
        term, residual = TERMS[name], TERMS[name].residual(problem, motion)
        hessian, gradient = term.model(problem, motion, motions.sensitivity(problem, motion))
        numeric = motions.slope(lambda m: TERMS[name].residual(problem, m), problem, motion)  # noqa: B023  # used at once
        # rounding: residuals of up to 30 m·√(4 s) at 2e-16, over a push of 1e-6, times r or J
        assert np.abs(gradient - residual @ numeric).max() < 1e-5
        assert np.abs(hessian - numeric.T @ numeric).max() < 1e-6


def test_nothing_costs_anything_on_the_reference(motions):
    problem = local_problem(steps=10, step=0.2, speed=0.8, wanted=0.8)
    inputs = np.tile([0.8, 0.0], (10, 1))
    motion = dataclasses.replace(
        motions.standing(problem),
        poses=problem.reference.poses,
        inputs=inputs,
        last_input=inputs[0],
    )
    for name in ("track_reference", "input_effort", "smooth_input"):
        assert np.abs(TERMS[name].residual(problem, motion)).max() < 1e-12


def test_costs_by_hand(motions):
    """A chair that stands, ten steps of 0.2 s, while the reference goes ahead at 0.8 m/s."""
    problem = local_problem(steps=10, step=0.2, speed=0.0, wanted=0.8)
    motion = motions.standing(problem)
    cost = {name: 0.5 * np.sum(t.residual(problem, motion) ** 2) for name, t in TERMS.items()}
    # ½ · 0.2 s · Σ (0.16 k)², k = 1…10, Σ k² = 385; and ½ · 4 s · 1.6² for the last one
    assert cost["track_reference"] == pytest.approx(0.1 * 0.0256 * 385 + 2.0 * 2.56)
    # ½ · 0.8 · 2 s · 0.8²
    assert cost["input_effort"] == pytest.approx(0.4 * 2.0 * 0.64)
    assert cost["input_effort as printed"] == 0.0
    assert cost["smooth_input"] == 0.0


def test_a_sudden_start_is_not_smooth(motions):
    problem = local_problem(steps=10, step=0.2)
    motion = dataclasses.replace(motions.standing(problem), inputs=np.tile([0.1, 0.0], (10, 1)))
    residual = TERMS["smooth_input"].residual(problem, motion)
    # 0.1 m/s in 0.2 s is 0.5 m/s²: ½ · 0.08 · 0.5² · 0.2 s
    assert 0.5 * residual @ residual == pytest.approx(0.5 * 0.08 * 0.25 * 0.2)


def test_the_heading_of_the_reference_is_not_wrapped(motions):
    """A reference that has turned once round is a whole turn away from a chair that has not."""
    problem = local_problem(steps=10, step=0.2)
    motion = motions.standing(problem)
    turn = np.array([0.0, 0.0, 2.0 * np.pi])
    further = dataclasses.replace(problem.reference, poses=problem.reference.poses + turn)
    there = dataclasses.replace(problem, reference=further)
    term = TERMS["track_reference"]
    difference = term.residual(there, motion) - term.residual(problem, motion)
    # √(0.3 · 0.2 s) a turn
    assert difference.reshape(10, 3)[0] == pytest.approx([0, 0, -np.sqrt(0.06) * 2.0 * np.pi])
