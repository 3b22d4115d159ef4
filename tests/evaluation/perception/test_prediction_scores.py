import math

import numpy as np
import pytest

from cohelm.evaluation.perception.prediction_scores import (
    PredictionSamples,
    by_person,
    predict_film,
)
from cohelm.evaluation.perception.tracked_film import track_film
from cohelm.perception import ConstantVelocity
from cohelm.recordings.pedestrians.trajectories import Trajectories


def walks(people=12, frames=14, seed=0):
    """People on straight ways, each at a speed of his own, noted every 0.4 s."""
    rng = np.random.default_rng(seed)
    start = np.column_stack([np.zeros(people), 2.0 * np.arange(people)])
    velocity = np.column_stack([rng.uniform(0.8, 1.5, people), np.zeros(people)])
    time = 0.4 * np.arange(frames)
    position = start[:, None] + time[:, None] * velocity[:, None]
    return Trajectories(
        name="straight",
        step=0.4,
        id=np.arange(people),
        first=np.arange(people + 1) * frames,
        time=np.tile(time, people),
        position=position.reshape(-1, 2),
        velocity=np.repeat(velocity, frames, axis=0),
    )


def one(weight, offset, deviation):
    offset, deviation = np.asarray(offset, dtype=float), np.asarray(deviation, dtype=float)
    k, h = deviation.shape
    squared = (offset**2).sum(axis=-1) / deviation**2
    return PredictionSamples(
        names=tuple(f"h{j}" for j in range(h)),
        person=np.arange(k),
        time=np.zeros(k),
        weight=np.broadcast_to(np.asarray(weight, dtype=float), (k, h)),
        density=-np.log(2.0 * np.pi * deviation**2) - 0.5 * squared,
        offset=offset,
        deviation=deviation,
    )


def test_likelihood_of_a_mixture():
    got = one([0.25, 0.75], [[[0.0, 0.0], [1.0, 0.0]]], [[1.0, 2.0]]).log_likelihood()
    # ¼ · 1/2π + ¾ · e^{−1/8} / 8π
    assert got == pytest.approx(np.log((0.25 + 0.1875 * np.exp(-0.125)) / (2.0 * np.pi)))


def test_truth_is_within_the_region_as_often_as_it_should():
    rng = np.random.default_rng(1)
    k = 2000
    which = rng.random(k) < 0.4
    deviation = np.tile([0.5, 1.0], (k, 1))
    truth = rng.standard_normal((k, 2)) * np.where(which, 0.5, 1.0)[:, None]
    truth[~which] += (2.0, 0.0)
    offset = np.stack([truth, truth - [2.0, 0.0]], axis=1)
    # 2000 draws know 0.9 to 0.7 %
    assert one([0.4, 0.6], offset, deviation).within(0.9) == pytest.approx(0.9, abs=0.025)


def test_the_error_is_that_of_the_mean_of_the_mixture():
    # ¼ · (4, 0) + ¾ · (0, 4) = (1, 3)
    seen = one([0.25, 0.75], [[[4.0, 0.0], [0.0, 4.0]]], [[1.0, 1.0]])
    assert seen.error == pytest.approx([math.sqrt(10.0)])


def test_an_interval_by_person_is_wider_than_by_frame():
    rng = np.random.default_rng(0)
    person = np.repeat(np.arange(30), 50)
    values = rng.standard_normal(30)[person]
    got = by_person(values, person)
    # deviation of a mean of 30 people: 0.18, of 1500 frames: 0.026
    assert 0.4 < got.high - got.low < 1.0


def test_straight_walkers_are_foreseen():
    seen = predict_film(track_film(walks()), ConstantVelocity())
    assert np.median(seen.error) < 0.4
    assert set(seen.person) == set(range(12))


def test_is_judged_at_the_moments_of_the_film_only():
    watched = track_film(walks(people=2))
    seen = predict_film(watched, ConstantVelocity())
    assert np.abs(seen.time / 0.4 - np.rint(seen.time / 0.4)).max() < 1e-6
    # 1.2 s later there must still be a sighting
    assert seen.time.max() <= 13 * 0.4 - 1.2 + 1e-6
