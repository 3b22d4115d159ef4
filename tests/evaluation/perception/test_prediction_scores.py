import os
from pathlib import Path

import numpy as np
import pytest

from cohelm.evaluation.perception.behaviour_changes import (
    CHANGES,
    ONSET,
    change_delays,
    simulated_changes,
    walk,
)
from cohelm.evaluation.perception.prediction_scores import (
    PredictionSamples,
    alarms,
    by_person,
    likelihoods,
    predict_film,
)
from cohelm.evaluation.perception.tracked_film import track_film
from cohelm.perception import ConstantVelocity, Hypotheses
from cohelm.recordings.pedestrians.trajectories import Trajectories, read_trajectories


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
        continued=np.ones(k, dtype=bool),
    )


def test_likelihood_of_a_mixture():
    got = one([0.25, 0.75], [[[0.0, 0.0], [1.0, 0.0]]], [[1.0, 2.0]]).log_likelihood()
    # ¼ · 1/2π + ¾ · e^{−1/8} / 8π
    assert got == pytest.approx(np.log((0.25 + 0.1875 * np.exp(-0.125)) / (2.0 * np.pi)))


def test_best_weights_are_those_of_the_mixture_it_came_from():
    rng = np.random.default_rng(0)
    which = rng.random(4000) < 0.3
    truth = rng.standard_normal((4000, 2)) + np.where(which[:, None], [4.0, 0.0], 0.0)
    offset = np.stack([truth, truth - [4.0, 0.0]], axis=1)
    best = one([0.5, 0.5], offset, np.ones((4000, 2))).best_weights()
    # 4000 draws know a share of 0.3 to 0.7 %
    assert best[1] == pytest.approx(0.3, abs=0.02)


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


def test_an_interval_by_person_is_wider_than_by_frame():
    rng = np.random.default_rng(0)
    person = np.repeat(np.arange(30), 50)
    values = rng.standard_normal(30)[person]
    got = by_person(values, person)
    # deviation of a mean of 30 people: 0.18, of 1500 frames: 0.026
    assert 0.4 < got.high - got.low < 1.0


def test_straight_walkers_are_foreseen_and_nobody_is_alarmed():
    watched = track_film(walks())
    seen = predict_film(watched, Hypotheses())
    assert seen.continued.all()
    assert alarms(seen).predicted == 0
    assert np.median(np.hypot(*seen.offset[:, 0].T)) < 0.25
    assert set(seen.person) == set(range(12))


def test_is_judged_at_the_moments_of_the_film_only():
    watched = track_film(walks(people=2))
    seen = predict_film(watched, ConstantVelocity())
    assert np.abs(seen.time / 0.4 - np.rint(seen.time / 0.4)).max() < 1e-6
    # 1.2 s later there must still be a sighting
    assert seen.time.max() <= 13 * 0.4 - 1.2 + 1e-6


def test_figures_are_those_of_the_foresight():
    watched = track_film(walks(people=4), rate=None)
    got = likelihoods(watched, Hypotheses())
    seen = predict_film(watched, Hypotheses())
    assert got.frames == len(seen.person)
    assert got.people == 4
    assert got.mean.mean == pytest.approx(seen.log_likelihood().mean())
    assert got.over_constant.low <= got.over_constant.mean <= got.over_constant.high


@pytest.mark.parametrize("name", CHANGES)
def test_a_change_begins_when_it_says(name):
    times, positions = walk(name, np.random.default_rng(3))
    velocity = np.diff(positions, axis=0) / np.diff(times)[:, None]
    first, last = velocity[5], velocity[-1]
    assert np.abs(velocity[times[1:] < ONSET] - first).max() < 1e-9
    cosine = (first @ last) / (first @ first)
    assert cosine == pytest.approx(
        {"stops": 0.0, "turns_back": -1.0}.get(name, 0.0), abs=0.51 if "aside" in name else 1e-6
    )
    if "aside" in name:
        left = first[0] * last[1] - first[1] * last[0] > 0.0
        assert left == name.endswith("left")


def test_changes_are_noticed():
    happened = simulated_changes(300, counts=(30, 10, 10, 10))
    got = change_delays(happened, Hypotheses())
    assert len(got.names) == 60
    assert got.share("stops") >= 0.9
    assert got.share("turns") >= 0.95
    assert got.early <= 0.01 * got.ticks
    blind = change_delays(happened, ConstantVelocity())
    assert np.isinf(blind.delay).all()


@pytest.mark.data
@pytest.mark.slow
@pytest.mark.parametrize("rate", [10.0, None])
@pytest.mark.parametrize("film", ["eth_obsmat.txt", "zara01_obsmat.txt"])
def test_filmed_crowds_are_foreseen_better_than_by_fixed_weights(film, rate):
    data = os.environ.get("COHELM_DATA")
    if data is None:
        pytest.skip("COHELM_DATA names no folder of recordings")
    watched = track_film(read_trajectories(Path(data) / "pedestrians" / film), rate=rate)
    got = likelihoods(watched, Hypotheses())
    assert got.over_mean_weights.low > 0.0
    assert got.over_constant.low > 0.5
    assert 0.85 < got.within_90 < 0.95
    assert alarms(predict_film(watched, Hypotheses())).share <= 0.05
