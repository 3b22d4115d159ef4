import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import solve_discrete_are

from cohelm.perception.tracking.kalman import innovations, predict, update

H = np.eye(2, 4)


def tracks(seed, n=7):
    rng = np.random.default_rng(seed)
    root = rng.standard_normal((n, 4, 4))
    return rng, rng.standard_normal((n, 4)), root @ root.swapaxes(1, 2) + 0.1 * np.eye(4)


def transition(dt):
    return np.kron([[1.0, dt], [0.0, 1.0]], np.eye(2))


def noise(dt, q):
    return q * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], np.eye(2))


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 1000))
def test_is_the_textbook_filter(seed):
    rng, mean, covariance = tracks(seed)
    dt, q = rng.uniform(0.0, 1.0, 7), rng.uniform(0.1, 2.0, 7)
    z, deviation = rng.standard_normal((7, 2)), rng.uniform(0.05, 0.5, 7)
    x, P = predict(mean, covariance, dt, q)
    y, C = update(x, P, z, deviation)
    squared, log_det = innovations(x, P, z, deviation)
    for i in range(7):
        F = transition(dt[i])
        assert x[i] == pytest.approx(F @ mean[i])
        assert P[i] == pytest.approx(F @ covariance[i] @ F.T + noise(dt[i], q[i]))
        S = H @ P[i] @ H.T + deviation[i] ** 2 * np.eye(2)
        K = P[i] @ H.T @ np.linalg.inv(S)
        e = z[i] - H @ x[i]
        assert y[i] == pytest.approx(x[i] + K @ e)
        assert C[i] == pytest.approx((np.eye(4) - K @ H) @ P[i], abs=1e-9)
        assert squared[i, i] == pytest.approx(e @ np.linalg.solve(S, e))
        assert log_det[i, i] == pytest.approx(np.linalg.slogdet(S)[1])


def test_settles_where_the_riccati_equation_says():
    dt, q, deviation = 0.1, 0.15, 0.04
    mean, covariance = np.zeros((1, 4)), np.eye(4)[None]
    for _ in range(300):
        mean, covariance = predict(mean, covariance, np.array([dt]), np.array([q]))
        settled = covariance
        mean, covariance = update(mean, covariance, np.zeros((1, 2)), np.array([deviation]))
    R = deviation**2 * np.eye(2)
    assert settled[0] == pytest.approx(solve_discrete_are(transition(dt).T, H.T, noise(dt, q), R))


def test_steps_add_up():
    _, mean, covariance = tracks(3)
    q = np.full(7, 0.3)
    once = predict(mean, covariance, np.full(7, 0.5), q)
    twice = predict(*predict(mean, covariance, np.full(7, 0.2), q), np.full(7, 0.3), q)
    assert twice[0] == pytest.approx(once[0])
    assert twice[1] == pytest.approx(once[1])


def test_nobody_is_ordinary_and_arguments_stay():
    none, nothing = np.empty((0, 4)), np.empty((0, 4, 4))
    x, P = predict(none, nothing, np.empty(0), np.empty(0))
    x, P = update(x, P, np.empty((0, 2)), np.empty(0))
    assert x.shape == (0, 4)
    assert innovations(x, P, np.zeros((3, 2)), np.ones(3))[0].shape == (0, 3)
    _, mean, covariance = tracks(1)
    mean.flags.writeable = covariance.flags.writeable = False
    update(*predict(mean, covariance, np.ones(7), np.ones(7)), np.zeros((7, 2)), np.ones(7))
