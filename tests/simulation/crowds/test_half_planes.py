"""The linear programs of ORCA, against brute force."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.simulation.crowds.velocity_constraints import best_velocity

SEEDS = st.integers(0, 2**32 - 1)


def half_planes(rng, count, depth):
    """Half-planes v·u ≤ offset as (k, 4) rows, with offset ≥ ``depth``."""
    angle = rng.uniform(-np.pi, np.pi, count)
    u = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    offset = rng.uniform(depth, 1.0, count)
    return np.hstack([offset[:, None] * u, -u[:, 1:], u[:, :1]]), u, offset


def disc_of_velocities(speed):
    axis = np.linspace(-speed, speed, 161)
    v = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    return v[np.hypot(*v.T) <= speed]


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, count=st.integers(0, 8))
def test_nothing_allowed_is_nearer_to_what_is_wanted(seed, count):
    rng = np.random.default_rng(seed)
    planes, u, offset = half_planes(rng, count, depth=0.05)  # standing still is always allowed
    wanted = rng.uniform(-2.0, 2.0, 2)
    v = np.array(best_velocity(planes, 0, 1.2, *wanted))
    assert np.hypot(*v) <= 1.2 + 1e-9
    assert (u @ v <= offset + 1e-6).all()
    sampled = disc_of_velocities(1.2)
    allowed = sampled[(sampled @ u.T <= offset).all(axis=1)]
    assert np.hypot(*(allowed - wanted).T).min() >= np.hypot(*(v - wanted)) - 1e-6


@settings(max_examples=60, deadline=None)
@given(seed=SEEDS, count=st.integers(2, 8), hard=st.integers(0, 3))
def test_where_not_all_can_hold_the_greatest_violation_is_least(seed, count, hard):
    rng = np.random.default_rng(seed)
    walls, wall_u, wall_offset = half_planes(rng, hard, depth=0.05)
    people, u, offset = half_planes(rng, count, depth=-1.0)
    wanted = rng.uniform(-2.0, 2.0, 2)
    v = np.array(best_velocity(np.vstack([walls, people]), hard, 1.2, *wanted))
    assert (wall_u @ v <= wall_offset + 1e-6).all()
    sampled = disc_of_velocities(1.2)
    sampled = sampled[(sampled @ wall_u.T <= wall_offset).all(axis=1)]
    least = (sampled @ u.T - offset).max(axis=1).min()
    assert (u @ v - offset).max() <= max(least, 0.0) + 1e-5
