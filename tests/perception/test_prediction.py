from dataclasses import replace

import numpy as np
import pytest

from cohelm.messages import People
from cohelm.perception import ConstantVelocity
from cohelm.testing import check_predictor


def person(covariance):
    nobody = People.empty(0.0)
    return type(nobody)(
        time=0.0,
        id=np.array([3]),
        mean=np.array([[1.0, 2.0, 0.5, -1.0]]),
        covariance=np.asarray(covariance, dtype=float)[None],
        heading=np.zeros(1),
        radius=np.full(1, 0.25),
        confidence=np.ones(1),
    )


def test_fulfils_the_contract():
    check_predictor(ConstantVelocity())


def test_keeps_going():
    got, _ = ConstantVelocity().predict(person(0.01 * np.eye(4)), 5, 0.2)
    assert got.names == ("keeps_going",)
    assert got.mean[0, 0, 5] == pytest.approx([1.5, 1.0])
    assert (got.velocity == [0.5, -1.0]).all()
    assert got.weight.tolist() == [[1.0]]


def test_who_is_expected_to_stand_stays_where_he_is():
    stands = ConstantVelocity(ConstantVelocity.Parameters(velocity_share=0.0))
    got, _ = stands.predict(person(0.01 * np.eye(4)), 5, 0.2)
    assert (got.mean == [1.0, 2.0]).all()
    assert (got.velocity == 0.0).all()


@pytest.mark.parametrize(
    ("speed", "share"), [(0.0, 0.0), (0.09, 0.0), (0.15, 0.5), (0.2, 1.0), (1.0, 1.0)]
)
def test_the_noise_about_standing_leads_nobody_away(speed, share):
    """Below 0.1 m/s people stand, from 0.2 m/s on they walk; in between the share is linear."""
    slow = replace(person(0.01 * np.eye(4)), mean=np.array([[1.0, 2.0, 0.6 * speed, 0.8 * speed]]))
    got, _ = ConstantVelocity(ConstantVelocity.Parameters(standing_speed=0.1)).predict(slow, 5, 0.2)
    assert got.velocity[0, 0, 0] == pytest.approx([0.6 * share * speed, 0.8 * share * speed])
    assert got.mean[0, 0, 5] == pytest.approx(slow.mean[0, :2] + got.velocity[0, 0, 0])


def test_grows_unsure_as_the_sampled_motion_does():
    # position and velocity correlated; white acceleration of q = 0.05 on top
    rng = np.random.default_rng(0)
    root = 0.1 * rng.standard_normal((4, 4))
    covariance = root @ root.T
    got, _ = ConstantVelocity(ConstantVelocity.Parameters(process_noise=0.05)).predict(
        person(covariance), 10, 0.1
    )
    samples = rng.multivariate_normal(np.zeros(4), covariance, 40_000)
    kicks = rng.normal(0.0, np.sqrt(0.05 * 0.01), (100, 40_000, 2))
    for kick in kicks:
        samples[:, :2] += 0.01 * samples[:, 2:] + 0.005 * kick
        samples[:, 2:] += kick
    spread = np.sqrt(np.linalg.eigvalsh(np.cov(samples[:, :2].T))[-1])
    # 40,000 samples know a deviation to about 0.4 %
    assert got.deviation[0, 0, 10] == pytest.approx(spread, rel=0.015)


def test_is_never_less_sure_than_told():
    parameters = ConstantVelocity.Parameters(max_deviation=0.5)
    got, _ = ConstantVelocity(parameters).predict(person(np.eye(4)), 30, 0.1)
    assert got.deviation.max() == 0.5
