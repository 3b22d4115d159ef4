import numpy as np
import pytest
from scipy.optimize import least_squares

from cohelm.perception.clustering.shape_fits import (
    DiscPrior,
    clutter_evidence,
    disc_evidence,
    fit_disc,
    flat_evidence,
)

from .rays import box, cast

ORIGIN = np.zeros(2)
R0, DEVIATION, NOISE = 0.27, 0.05, 0.015
PRIOR = DiscPrior(R0, DEVIATION, NOISE)
BEAMS = np.radians(np.arange(-60, 60))


def face(discs=(), segments=(), noise=0.0, seed=0):
    """The returns of what stands alone before the sensor."""
    ranges = cast(ORIGIN, BEAMS, np.reshape(segments, (-1, 4)), np.reshape(discs, (-1, 3)))
    ranges = ranges + noise * np.random.default_rng(seed).standard_normal(len(ranges))
    hit = np.isfinite(ranges)
    return ranges[hit, None] * np.stack([np.cos(BEAMS[hit]), np.sin(BEAMS[hit])], axis=-1)


@pytest.mark.parametrize("away", [1.0, 3.0, 6.0])
def test_exact_returns_of_the_expected_body_give_its_centre(away):
    x, y, r, misfit, _ = fit_disc(face([away, 0.3, R0]), ORIGIN, PRIOR)
    # the weak prior on the start pulls by less than 1 mm
    assert np.hypot(x - away, y - 0.3) < 2e-3
    assert r == pytest.approx(R0, abs=2e-3)
    assert misfit < 0.1


def test_is_the_minimum_that_a_general_solver_finds():
    points = face([3.0, -0.4, 0.31], noise=0.01)
    x, y, r, _, deviation = fit_disc(points, ORIGIN, PRIOR)
    mean = points.mean(axis=0)
    start = mean * (1.0 + 0.8 * R0 / np.hypot(*mean))

    def residual(q):
        return np.concatenate(
            [
                (np.hypot(*(points - q[:2]).T) - q[2]) / NOISE,
                [(q[2] - R0) / DEVIATION],
                (q[:2] - start) / 0.3,
            ]
        )

    oracle = least_squares(residual, [*start, R0], xtol=1e-12, ftol=1e-12)
    assert [x, y, r] == pytest.approx(oracle.x, abs=1e-4)
    covariance = np.linalg.inv(oracle.jac.T @ oracle.jac)[:2, :2]
    assert deviation == pytest.approx(np.sqrt(np.linalg.eigvalsh(covariance)[-1]), rel=0.1)


def test_the_mean_of_the_returns_lies_most_of_a_radius_too_near():
    points = face([4.0, 0.0, 0.25])
    # about 0.8 r, as measured for the printed eq. (3)
    assert 4.0 - points.mean(axis=0)[0] == pytest.approx(0.8 * 0.25, abs=0.02)
    x, *_ = fit_disc(points, ORIGIN, PRIOR)
    assert x == pytest.approx(4.0, abs=0.02)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("away", [1.0, 2.5, 4.0])
def test_discs_are_discs_and_boxes_are_not(away, seed):
    def odds(points):
        _, _, _, misfit, _ = fit_disc(points, ORIGIN, PRIOR)
        other = min(clutter_evidence(misfit, len(points)), flat_evidence(points, NOISE))
        return 0.5 * (other - disc_evidence(misfit, len(points)))

    turn = np.random.default_rng(seed).uniform(0.0, np.pi / 2)
    assert odds(face([away, 0.0, 0.25], noise=0.01, seed=seed)) > 2.0
    assert odds(face(segments=box(away, 0.0, 0.5, turn), noise=0.01, seed=seed)) < -2.0


def test_a_flat_face_costs_two_parameters_and_a_corner_four():
    # exact returns: no misfit, so what is left is the price of the parameters, ln m each
    flat = face(segments=[3.0, -0.25, 3.0, 0.25])
    assert flat_evidence(flat, NOISE) == pytest.approx(2.0 * np.log(len(flat)), abs=1e-6)
    corner = face(segments=box(3.0, 0.0, 0.6, np.pi / 4))
    assert flat_evidence(corner, NOISE) == pytest.approx(4.0 * np.log(len(corner)), abs=0.1)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_returns_are_solvable_and_unsure(count):
    points = np.stack([np.full(count, 5.0), 0.1 * np.arange(count)], axis=-1)
    x, y, r, misfit, deviation = fit_disc(points, ORIGIN, PRIOR)
    assert np.isfinite([x, y, r, misfit, deviation]).all()
    assert x > 5.0
    assert deviation > 0.01
