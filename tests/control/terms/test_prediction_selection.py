import dataclasses

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.control import Trajectory
from cohelm.control.terms import PersonBarrier, SocialSpaceBarrier
from cohelm.control.terms.constraints.prediction_selection import PersonMargin, selected_predictions
from cohelm.messages import Predictions
from cohelm.testing.problems import mirrored, random_problem, turned
from cohelm.testing.scenes import local_problem, round_spaces, walkers

STEPS = 6
NO_MARGIN = PersonMargin()


def split(weights, *, aside=3.0, state=(2.0, 0.0, -0.5, 0.0)):
    """One person whose hypotheses (h,) differ by ``aside`` m to the left each."""
    problem = local_problem(steps=STEPS, step=0.2, people=walkers([state]))
    p = problem.predictions
    h = len(weights)
    shift = aside * np.arange(h)[None, :, None, None] * np.array([0.0, 1.0])
    predictions = Predictions(
        step=p.step,
        names=tuple(f"future_{j}" for j in range(h)),
        weight=np.array([weights]),
        mean=np.repeat(p.mean, h, axis=1) + shift,
        velocity=np.repeat(p.velocity, h, axis=1),
        deviation=np.repeat(p.deviation, h, axis=1),
    )
    return dataclasses.replace(problem, predictions=predictions, spaces=round_spaces(predictions))


def bind(problem, min_probability):
    return selected_predictions(problem, min_probability, NO_MARGIN, 0.3, 0.0)


@pytest.mark.parametrize(
    ("min_probability", "which"),
    [(0.0, [0, 1, 2]), (0.3, [0, 1]), (0.31, [1]), (0.6, [1]), (1.0, [1])],
)
def test_the_likeliest_binds_and_all_others_from_a_probability_on(min_probability, which):
    assert bind(split([0.3, 0.6, 0.1]), min_probability).layout.series_id.tolist() == which


def test_of_equally_likely_futures_the_first_binds():
    assert bind(split([0.4, 0.4, 0.2]), 0.5).layout.series_id.tolist() == [0]


@settings(max_examples=25)
@given(st.lists(st.floats(0.01, 1.0), min_size=1, max_size=5), st.floats(0.0, 1.0))
def test_everybody_binds_in_one_future_min_probability(weights, min_probability):
    share = np.array(weights) / np.sum(weights)
    found = bind(split(share, aside=0.5), min_probability)
    expected = (share >= min_probability) | (np.arange(len(share)) == share.argmax())
    assert found.layout.series_id.tolist() == np.flatnonzero(expected).tolist()
    assert set(found.layout.slack_index.tolist()) == {0}
    assert (found.layout.num_slacks, found.layout.num_series_ids) == (1, len(share))


@pytest.mark.parametrize("kind", [PersonBarrier, SocialSpaceBarrier])
def test_a_future_that_does_not_bind_changes_nothing(kind, motions):
    """The one in the way, at 0.2, is as good as not there for a constraint that asks for 0.25."""
    problem = split([0.8, 0.2], aside=-3.0, state=(1.2, 3.0, 0.0, 0.0))
    trajectory = motions.standing(problem)
    sure, doubtful = (kind(kind.Parameters(min_probability=p)) for p in (0.25, 0.15))
    assert sure.values(problem, trajectory).slack.tolist() == [0.0]
    assert doubtful.values(problem, trajectory).slack[0] > 0.0
    alone = dataclasses.replace(problem, predictions=problem.predictions.most_likely())
    alone = dataclasses.replace(alone, spaces=round_spaces(alone.predictions))
    assert np.array_equal(sure.values(problem, trajectory).h, sure.values(alone, trajectory).h)


@pytest.mark.parametrize("kind", [PersonBarrier, SocialSpaceBarrier])
def test_rows_are_named_among_those_of_every_future(kind, motions):
    """Whichever futures bind, the same row of the same one has the same key."""
    problem = split([0.3, 0.6, 0.1], aside=0.1)
    trajectory = motions.standing(problem)
    names = {}
    for min_probability in (0.0, 0.2, 1.0):
        constraint = kind(kind.Parameters(min_probability=min_probability))
        there = constraint.values(problem, trajectory)
        rows = constraint.rows(problem, trajectory, motions.sensitivity(problem, trajectory), there)
        assert rows.num_row_ids == 3 * STEPS
        assert rows.num_slacks == 1
        for key, margin in zip(rows.row_id, rows.margin, strict=True):
            assert names.setdefault(int(key), margin) == margin
    assert len(names) == 3 * STEPS


def test_margins_by_hand():
    """σ is 0.05 m and grows by 0.1 m/s; six steps of 0.2 s; a body of 0.25 m."""
    problem = split([1.0])
    age = 0.2 * np.arange(STEPS + 1)
    sigma = 0.05 + 0.1 * age
    for margin, expected in (
        (PersonMargin(initial=0.1), 0.1 + 0.0 * age),
        (PersonMargin(initial=0.1, growth=0.2), 0.1 + 0.2 * age),
        (PersonMargin(deviations=2.0), 2.0 * sigma),
        (PersonMargin(initial=0.1, growth=0.2, deviations=1.0, upper=0.3), 0.1 + 0.2 * age + sigma),
    ):
        kept = selected_predictions(problem, 0.0, margin, 0.3, 0.0).clearance
        assert kept == pytest.approx(0.25 + np.minimum(expected, margin.upper)[None])


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(0.1, 1.0))
def test_who_is_left_out_for_being_far_can_have_no_row(seed, gamma):
    """People up to 60 m away: left out is only who is far for any motion, and his h is bounded."""
    rng = np.random.default_rng(seed)
    near = random_problem(rng, 6, steps=8).problem
    p = near.predictions
    away = rng.uniform(0.0, 50.0, (6, 1, 1, 1)) * np.array([np.cos(seed), np.sin(seed)])
    problem = dataclasses.replace(near, predictions=dataclasses.replace(p, mean=p.mean + away))
    found = selected_predictions(problem, 0.0, NO_MARGIN, gamma, 0.0)
    gone = np.setdiff1d(np.arange(6), found.layout.series_id)
    top = problem.robot.max_speed
    robot = problem.robot.circumscribed_radius + problem.robot.capsule[4]
    for i in gone:
        age = p.step * np.arange(9)
        closest = np.hypot(*(problem.predictions.mean[i, 0] - problem.pose[:2]).T)
        least = (closest - top * age - robot - problem.people.radius[i]).min()
        assert least >= found.lower_bound_of_others - 1e-9
        # a step of both takes less than the share γ of it
        stride = top * p.step + np.hypot(*np.diff(problem.predictions.mean[i, 0], axis=0).T).max()
        assert gamma * least > stride
    if len(gone) == 0:
        assert found.lower_bound_of_others == np.inf


@pytest.mark.parametrize("kind", [PersonBarrier, SocialSpaceBarrier])
def test_somebody_far_away_changes_nothing(kind, motions):
    with_one = local_problem(steps=STEPS, step=0.2, people=walkers([[1.5, 0.4, -0.5, 0.0]]))
    with_two = local_problem(
        steps=STEPS, step=0.2, people=walkers([[1.5, 0.4, -0.5, 0.0], [40.0, 9.0, -1.0, 0.0]])
    )
    trajectory = motions.standing(with_one)
    constraint = kind()
    one, two = (constraint.values(p, trajectory) for p in (with_one, with_two))
    assert two.slack.tolist() == [*one.slack.tolist(), 0.0]
    assert two.smallest == one.smallest
    assert np.array_equal(one.h, two.h)


@pytest.mark.parametrize("kind", [PersonBarrier, SocialSpaceBarrier])
def test_the_world_may_be_turned_or_mirrored(kind, motions):
    constraint, rng = kind(), np.random.default_rng(5)
    for people in (1, 4, 9):
        problem = random_problem(rng, people, steps=STEPS).problem
        trajectory = motions.wandering(problem, rng)
        here = constraint.values(problem, trajectory)
        for other, inputs in (
            (turned(problem, np.array([3.0, -2.0, 1.1])), trajectory.inputs),
            (mirrored(problem), trajectory.inputs * np.array([1.0, -1.0])),
        ):
            step = trajectory.step
            there = dataclasses.replace(
                trajectory,
                inputs=inputs,
                poses=other.robot.motion_model.rollout(other.pose, inputs, step),
            )
            assert constraint.values(other, there).h == pytest.approx(here.h, abs=1e-9)


@settings(max_examples=25)
@given(st.integers(0, 1000), st.floats(0.1, 1.0))
def test_where_no_slack_is_needed_the_barrier_condition_holds(seed, gamma):
    """h_{k+1} ≥ (1 − γ) h_k along the way, so that h stays positive once it is; eq. (9)."""
    rng = np.random.default_rng(seed)
    problem = random_problem(rng, 3, steps=STEPS).problem
    inputs = np.column_stack([rng.uniform(0.0, 0.6, STEPS), rng.normal(0.0, 0.2, STEPS)])
    poses = problem.robot.motion_model.rollout(problem.pose, inputs, 0.16)
    constraint = PersonBarrier(PersonBarrier.Parameters(gamma=gamma))
    found = constraint.values(problem, _trajectory(problem, poses, inputs))
    who = selected_predictions(
        problem, 0.15, PersonMargin(initial=0.1, growth=0.08, upper=0.35), gamma, 0.0
    ).layout.slack_index
    assert not np.delete(found.slack, who).any()
    for slack, h in zip(found.slack[who], found.h, strict=True):
        held = h[1:] >= (1.0 - gamma) * h[:-1] - 1e-12
        assert held.all() == (slack <= 1e-12)
        if held.all() and h[0] >= 0.0:
            assert (h >= -1e-9).all()


def _trajectory(problem, poses, inputs):
    return Trajectory(step=0.16, poses=poses, inputs=inputs, current_input=problem.twist[[0, 2]])


def test_gamma_1_is_a_distance_constraint(motions):
    """Only who is nearer than the margin needs slack, by how much he is nearer."""
    constraint = PersonBarrier(
        PersonBarrier.Parameters(gamma=1.0, margin=0.4, growth=0.0, max_margin=1.0)
    )
    for x in (1.2, 1.5, 1.8, 4.0):
        problem = local_problem(steps=STEPS, step=0.2, people=walkers([[x, 0.0, 0.0, 0.0]]))
        gap = x - 0.539 - problem.robot.capsule[4] - 0.25
        slack = constraint.values(problem, motions.standing(problem)).slack
        assert slack[0] == pytest.approx(max(0.4 - gap, 0.0), abs=1e-6)
