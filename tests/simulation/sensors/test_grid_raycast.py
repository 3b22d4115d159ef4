"""Ray casting against closed forms and brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid
from cohelm.robots import LaserMount
from cohelm.simulation.sensors import cast, sweep
from cohelm.simulation.sensors.grid_raycast import in_sight

ALL_ROUND = np.linspace(-np.pi, np.pi, 360, endpoint=False)
NOBODY = np.empty((0, 3))
NOTHING = np.zeros((10, 10), dtype=bool)


def to_squares(occupied, resolution, X_MG, pose, angles, range_max):
    """The same by intersecting every ray with every occupied cell."""
    low = np.argwhere(occupied)[:, ::-1] * resolution
    origin = transform([0.0, 0.0, -X_MG[2]], pose[:2] - X_MG[:2])
    out = np.full(len(angles), np.inf)
    for b, angle in enumerate(pose[2] + angles - X_MG[2]):
        slope = np.array([np.cos(angle), np.sin(angle)])
        t = np.sort([(low - origin) / slope, (low + resolution - origin) / slope], axis=0)
        enter, leave = np.maximum(t[0].max(axis=1), 0.0), t[1].min(axis=1)
        met = enter[enter <= leave]
        out[b] = met.min() if len(met) else np.inf
    return np.where(out <= range_max, out, np.inf)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6))
def test_rays_meet_the_cells_that_brute_force_meets(seed):
    rng = np.random.default_rng(seed)
    occupied = rng.random((30, 40)) < 0.05
    X_MG = np.array([*rng.uniform(-3, 3, 2), rng.uniform(-3, 3)])
    pose = np.array([*rng.uniform(-2, 4, 2), rng.uniform(-3, 3)])  # on the grid or beside it
    angles = rng.uniform(-np.pi, np.pi, 40)
    ours = cast(occupied, 0.1, X_MG, NOBODY, pose, angles, 2.5)
    theirs = to_squares(occupied, 0.1, X_MG, pose, angles, 2.5)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)


@pytest.mark.parametrize("yaw", [0.0, 0.5, -2.0])
def test_a_wall_at_an_angle_is_at_its_distance_over_the_cosine(yaw):
    occupied = np.zeros((100, 100), dtype=bool)
    occupied[:, 60:] = True  # the face is 3 m along the grid's x axis
    X_MG = np.array([1.0, -2.0, yaw])
    pose = np.array([*transform(X_MG, [1.0, 2.5]), yaw])  # 2 m before it, looking straight at it
    angles = np.linspace(-0.7, 0.7, 50)
    ranges = cast(occupied, 0.05, X_MG, NOBODY, pose, angles, 10.0)
    np.testing.assert_allclose(ranges, 2.0 / np.cos(angles), rtol=1e-12)


def test_a_body_is_a_disc():
    pose, body = np.array([1.0, 1.0, 0.3]), np.array([[3.0, 2.0, 0.25]])
    ranges = cast(NOTHING, 0.05, np.zeros(3), body, pose, ALL_ROUND, 10.0)
    far, direction = np.hypot(2.0, 1.0), np.arctan2(1.0, 2.0) - 0.3
    # law of cosines: r² = d² + l² − 2 d l cos δ, the nearer root; met where d |sin δ| ≤ r
    delta = ALL_ROUND - direction
    hit = (np.abs(far * np.sin(delta)) <= 0.25) & (np.cos(delta) > 0.0)
    chord = np.sqrt(np.maximum(0.25**2 - (far * np.sin(delta)) ** 2, 0.0))
    np.testing.assert_allclose(ranges, np.where(hit, far * np.cos(delta) - chord, np.inf))


def test_the_nearer_of_body_and_wall_is_seen():
    occupied = np.zeros((100, 100), dtype=bool)
    occupied[:, 60:] = True
    pose, ahead = np.array([1.0, 2.5, 0.0]), np.zeros(1)
    before, behind = np.array([[2.0, 2.5, 0.3]]), np.array([[3.5, 2.5, 0.3]])
    assert cast(occupied, 0.05, np.zeros(3), before, pose, ahead, 10.0)[0] == pytest.approx(0.7)
    assert cast(occupied, 0.05, np.zeros(3), behind, pose, ahead, 10.0)[0] == pytest.approx(2.0)


def test_nothing_is_seen_beyond_reach():
    body = np.array([[5.0, 0.0, 0.5]])
    origin, ahead = np.zeros(3), np.zeros(1)
    assert cast(NOTHING, 0.05, np.zeros(3), body, origin, ahead, 4.5)[0] == pytest.approx(4.5)
    assert cast(NOTHING, 0.05, np.zeros(3), body, origin, ahead, 4.4)[0] == np.inf


def test_sight_ends_at_walls():
    occupied = np.zeros((100, 100), dtype=bool)
    occupied[:50, 60:62] = True
    here = np.array([[1.0, 1.0]] * 3)
    there = np.array([[4.0, 1.0], [2.9, 1.0], [4.0, 4.5]])  # behind, before, over the top
    sees = in_sight(occupied, 0.05, np.zeros(3), here, there)
    np.testing.assert_array_equal(sees, [False, True, True])


def room(value):
    data = np.full((200, 200), value, dtype=np.int8)
    data[2:-2, 2:-2] = 0
    return OccupancyGrid(data=data, resolution=0.05, X_MG=np.zeros(3))


def test_unknown_cells_do_not_reflect():
    mount = LaserMount(noise=0.0, dropout=0.0)
    pose, rng = np.array([5.0, 5.0, 0.0]), np.random.default_rng(0)
    assert np.isfinite(sweep(mount, room(100), NOBODY, pose, time=0.0, rng=rng).ranges).all()
    assert np.isinf(sweep(mount, room(-1), NOBODY, pose, time=0.0, rng=rng).ranges).all()


def test_noise_and_dropouts_are_as_the_mount_says():
    mount = LaserMount(beams=20_000, noise=0.02, dropout=0.01, pose=(0.3, 0.1, 0.4))
    pose = np.array([5.0, 4.0, 1.0])
    still = LaserMount(**{**mount.model_dump(), "noise": 0.0, "dropout": 0.0})
    truth = sweep(still, room(100), NOBODY, pose, time=0.0, rng=np.random.default_rng(0))
    noisy = sweep(mount, room(100), NOBODY, pose, time=3.0, rng=np.random.default_rng(0))
    assert noisy.time == 3.0
    np.testing.assert_array_equal(noisy.mount, mount.pose)
    lost = np.isnan(noisy.ranges)
    assert lost.mean() == pytest.approx(0.01, abs=0.003)  # ± 4 √(0.01 · 0.99 / 20000)
    error = (noisy.ranges - truth.ranges)[~lost]
    assert error.std() == pytest.approx(0.02, rel=0.05)
    assert error.mean() == pytest.approx(0.0, abs=0.001)


def test_beams_cover_the_field_of_view():
    rng = np.random.default_rng(0)
    full = sweep(LaserMount(beams=4), room(100), NOBODY, np.zeros(3), time=0.0, rng=rng)
    assert full.angle_min == pytest.approx(-np.pi)
    assert full.angle_increment == pytest.approx(np.pi / 2)  # the first is not repeated
    front = LaserMount(beams=3, field_of_view_deg=180.0)
    half = sweep(front, room(100), NOBODY, np.zeros(3), time=0.0, rng=rng)
    assert half.angle_min == pytest.approx(-np.pi / 2)
    assert half.angle_increment == pytest.approx(np.pi / 2)  # both ends are beams


def test_beams_turn_with_mount_and_robot():
    """The beam straight ahead of a scanner that looks left sees the wall on the left."""
    mount = LaserMount(beams=4, noise=0.0, dropout=0.0, pose=(0.5, 0.0, np.pi / 2))
    pose = np.array([5.0, 3.0, np.pi / 2])  # facing +y; left is −x; the sensor is at (5, 3.5)
    scan = sweep(mount, room(100), NOBODY, pose, time=0.0, rng=np.random.default_rng(0))
    # behind, right, ahead, left of the sensor: +x wall, +y, −x, −y; walls are 0.1 m thick
    np.testing.assert_allclose(scan.ranges, [4.9, 6.4, 4.9, 3.4], atol=1e-9)
