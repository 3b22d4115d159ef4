"""LiDARs and depth cameras against closed forms, the planar caster, and laws."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from cohelm.arrays import identical
from cohelm.geometry import compose, transform
from cohelm.maps import OccupancyGrid
from cohelm.robots import BlindSector, DepthCameraMount, LidarMount
from cohelm.simulation.sensors import (
    FloorSurface,
    HumanBodies,
    StaticScene,
    cast,
    scan_cloud,
    sweep_cloud,
)
from cohelm.simulation.sensors.point_cloud import sensor_pose

NOBODY = HumanBodies.standing(np.empty((0, 2)))
HERE = np.array([5.0, 5.0, 0.0])
HEIGHT = 1.3
ATOL = 2e-6  # points are float32, up to 10 m


def lidar(**changes):
    plain = {"rings": 16, "azimuths": 180, "noise": 0.0, "dropout": 0.0, "range_min": 0.0}
    return LidarMount(**{**plain, **changes})


def camera(**changes):
    plain = {"columns": 40, "rows": 24, "noise": 0.0, "dropout": 0.0, "range_min": 0.0}
    return DepthCameraMount(**{**plain, **changes})


def hall(*boxes, size=(12.0, 10.0), X_MG=(0.0, 0.0, 0.0), heights=None, **changes):
    """An open floor with walls in boxes (x0, y0, x1, y1), m."""
    data = np.zeros((round(size[1] / 0.05), round(size[0] / 0.05)), dtype=np.int8)
    for box in boxes:
        x0, y0, x1, y1 = (round(b / 0.05) for b in box)
        data[y0:y1, x0:x1] = 100
    grid = OccupancyGrid(data=data, resolution=0.05, X_MG=np.array(X_MG))
    if heights is not None:
        changes["heights"] = np.full(data.shape, heights, dtype=np.float32)
    return StaticScene(grid=grid, **changes)


def swept(mount, scenery, bodies=NOBODY, X_MR=HERE, seed=0):
    return sweep_cloud(mount, scenery, bodies, X_MR, time=0.0, rng=np.random.default_rng(seed))


def in_map(sweep, mount, scenery, X_MR=HERE):
    """(p, 3) points of a sweep in the map frame."""
    origin, rotation = sensor_pose(mount, scenery, X_MR)
    return origin + sweep.cloud.points.astype(float) @ rotation.T


# ------------------------------------------------------------------ floors and walls

POSES = [(0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0), (0.2, -0.3, 0.8, 0.1, 0.3, -2.0)]


@pytest.mark.parametrize("pose", POSES)
@pytest.mark.parametrize("kind", [lidar, camera])
def test_what_goes_down_meets_the_floor_at_height_zero(kind, pose):
    mount, scenery = kind(pose=pose), hall()
    points = in_map(swept(mount, scenery), mount, scenery)
    # a ray with slope −s from height z meets the floor after z √(1 + s²) / s
    _, rotation = sensor_pose(mount, scenery, HERE)
    down = -(mount.rays().reshape(-1, 3) @ rotation.T)[:, 2]
    meets = down * mount.range_max > pose[2]
    np.testing.assert_array_equal(np.isfinite(points).all(axis=1), meets)
    assert meets.any()
    np.testing.assert_allclose(points[meets, 2], 0.0, atol=ATOL)


def test_a_ceiling_is_met_at_its_height():
    mount, scenery = lidar(), hall(ceiling=2.4)
    points = in_map(swept(mount, scenery), mount, scenery)
    above = points[:, 2] > HEIGHT
    assert above.any()
    np.testing.assert_allclose(points[above, 2], 2.4, atol=ATOL)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 10**6), pitch=st.sampled_from([0.0, 0.2]))
def test_walls_are_where_the_planar_caster_meets_them(seed, pitch):
    """Every ray is as long on the level as the planar one in its direction, unless it ends on the
    floor before."""
    rng = np.random.default_rng(seed)
    data = np.where(rng.random((80, 100)) < 0.02, 100, 0).astype(np.int8)
    grid = OccupancyGrid(data=data, resolution=0.1, X_MG=np.array([1.0, -2.0, rng.uniform(-3, 3)]))
    scenery = StaticScene(grid=grid, wall_height=1e3)
    X_MR = np.array([*transform(grid.X_MG, rng.uniform(1, 7, 2)), rng.uniform(-3, 3)])
    mount = lidar(azimuths=45, pose=(0.1, 0.2, HEIGHT, 0.0, pitch, 0.4))
    sweep = swept(mount, scenery, X_MR=X_MR)
    origin, rotation = sensor_pose(mount, scenery, X_MR)
    towards = mount.rays().reshape(-1, 3) @ rotation.T
    level = np.hypot(towards[:, 0], towards[:, 1])
    angles = np.arctan2(towards[:, 1], towards[:, 0])
    planar = cast(
        grid.occupied(),
        0.1,
        grid.X_MG,
        np.empty((0, 3)),
        np.array([*origin[:2], 0.0]),
        angles,
        20.0,
    )
    down = np.where(towards[:, 2] < 0.0, -origin[2] / np.minimum(towards[:, 2], -1e-12), np.inf)
    expected = np.minimum(planar / level, down)
    expected[expected > 10.0] = np.nan
    got = np.linalg.norm(sweep.cloud.points.astype(float), axis=1)
    np.testing.assert_allclose(got, expected, atol=1e-5)


def test_furniture_ends_at_its_height_and_shows_its_top():
    mount = lidar(rings=64, elevation_deg=(-40, 10))
    scenery = hall((7.0, 4.0, 8.0, 6.0), heights=0.75)
    points = in_map(swept(mount, scenery), mount, scenery)
    inside = (np.abs(points[:, 0] - 7.5) < 0.5 - 1e-5) & (np.abs(points[:, 1] - 5.0) < 1.0 - 1e-5)
    np.testing.assert_allclose(points[inside, 2], 0.75, atol=ATOL)
    face = (np.abs(points[:, 0] - 7.0) < 1e-5) & (np.abs(points[:, 1] - 5.0) < 0.9)
    assert points[face, 2].min() < 0.1
    assert points[face, 2].max() <= 0.75 + ATOL
    # the ray over its far edge, 3 m away, goes on to the floor: 3 · 1.3 / (1.3 − 0.75) = 7.09 m
    ahead = np.abs(points[:, 1] - 5.0) < 1e-3
    behind = points[ahead & (points[:, 0] > 8.0 + 1e-5), 0]
    assert behind.min() > 5.0 + 7.09


def test_cells_that_are_free_are_empty_whatever_their_height():
    mount = lidar()
    same = swept(mount, hall(heights=1.0)).cloud, swept(mount, hall()).cloud
    assert identical(*same)


def test_heights_of_another_grid_are_refused():
    with pytest.raises(ValueError, match="heights of shape"):
        swept(lidar(), replace(hall(), heights=np.zeros((3, 3), dtype=np.float32)))


# ------------------------------------------------------------------ floors that slope


@pytest.mark.parametrize("gradient", [0.1, -0.08])
@pytest.mark.parametrize("start", [6.0, 2.0])
def test_points_of_a_ramp_lie_on_it(gradient, start):
    """Before it, on it and beyond it; the chair stands as the floor slopes where it is."""
    floor = FloorSurface(at=np.array([start, 0.0]), direction=0.3, gradient=gradient, length=3.5)
    scenery = replace(hall(), floor=floor)
    mount = lidar(rings=48, elevation_deg=(-30.0, 10.0))
    points = in_map(swept(mount, scenery), mount, scenery)
    met = np.isfinite(points).all(axis=1)
    assert met.mean() > 0.4
    np.testing.assert_allclose(points[met, 2], floor.height(points[met, :2]), atol=1e-5)
    kinds = floor.height(points[met, :2])
    assert (np.abs(kinds) < 1e-9).any()
    assert (np.abs(kinds) > 0.01).any()


def test_a_tilted_floor_looks_level_to_a_chair_that_stands_on_it():
    scenery = replace(
        hall(), floor=FloorSurface(at=np.array([-100.0, 0.0]), direction=0.5, gradient=0.12)
    )
    tilted, level = (swept(lidar(), s, X_MR=np.array([5, 5, 1.0])) for s in (scenery, hall()))
    np.testing.assert_allclose(tilted.cloud.points, level.cloud.points, atol=2e-4)


# ------------------------------------------------------------------ bodies


def walker(**changes):
    fields = {
        "position": np.array([[8.0, 5.0]]),
        "heading": np.zeros(1),
        "walked": np.zeros(1),
        "speed": np.ones(1),
        "height": np.array([1.7]),
        "radius": np.array([0.25]),
    }
    return HumanBodies(**{**fields, **changes})


def test_a_body_alone_is_wholly_visible_and_behind_a_wall_not_at_all():
    body = HumanBodies.standing(np.array([[8.0, 5.0]]))
    for mount in (lidar(), camera(), lidar(pose=(0, 0, 1.0, 0.1, 0.2, 0))):
        assert swept(mount, hall(), body).visible.tolist() == [1.0]
        assert swept(mount, hall((7, 3, 7.2, 7)), body).visible.tolist() == [0.0]


def test_behind_another_or_a_counter_a_body_is_partly_visible():
    mount = lidar(rings=64, azimuths=1024)
    # twice as far away the shadow is twice as wide: it ends in the middle of the one behind
    row = HumanBodies.standing(np.array([[7.0, 5.0], [9.0, 5.0 + 2 * 0.14 * 1.7]]))
    before, behind = swept(mount, hall(), row).visible
    assert before == 1.0
    assert 0.4 < behind < 0.75  # beside the first one's narrower legs more is seen
    # over a counter's edge, 2 m away and 1 m high, from 1.3 m up: at 3 m 1.3 − 0.3 · 3/2 = 0.85 m;
    # the lower half of 1.7 m is hidden, which is narrower
    body = HumanBodies.standing(np.array([[8.0, 5.0]]))
    counter = hall((6.9, 3.0, 7.0, 7.0), heights=1.0)
    assert 0.4 < swept(mount, counter, body).visible[0] < 0.75


def test_who_is_met_is_told_of_every_point():
    mount = lidar(rings=32, azimuths=512)
    bodies = HumanBodies.standing(np.array([[7.0, 5.0], [4.0, 8.0], [5.5, 2.0]]))
    sweep = swept(mount, hall(), bodies)
    points = in_map(sweep, mount, hall())
    apart = np.linalg.norm(points[:, None, :2] - bodies.position, axis=2)
    on_body = sweep.owner >= 0
    assert set(sweep.owner) == {-1, 0, 1, 2}
    assert apart[on_body, sweep.owner[on_body]].max() <= 0.25 + ATOL
    rest = points[~on_body]
    np.testing.assert_allclose(rest[np.isfinite(rest).all(axis=1), 2], 0.0, atol=ATOL)


@settings(max_examples=30, deadline=None)
@given(
    walked=st.floats(0.0, 5.0),
    speed=st.floats(0.0, 2.0),
    heading=st.floats(-3.0, 3.0),
    height=st.floats(1.0, 2.0),
    radius=st.floats(0.12, 0.4),
)
def test_a_body_keeps_within_its_disc_and_its_height(walked, speed, heading, height, radius):
    mount = lidar(rings=48, azimuths=720, elevation_deg=(-40.0, 30.0))
    given_ = {"walked": walked, "speed": speed, "heading": heading, "height": height}
    body = walker(
        position=np.array([[6.5, 5.0]]),
        radius=np.array([radius]),
        **{name: np.array([number]) for name, number in given_.items()},
    )
    sweep = swept(mount, hall(), body)
    points = in_map(sweep, mount, hall())[sweep.owner == 0]
    assert len(points) > 20
    assert np.hypot(*(points[:, :2] - body.position[0]).T).max() <= radius + ATOL
    assert points[:, 2].min() >= -ATOL
    assert points[:, 2].max() <= height + ATOL


def shins(body):
    """Where points between 0.1 and 0.3 m up lie along and across the walk."""
    mount = lidar(rings=64, azimuths=2048, pose=(0, 0, 0.5, 0, 0, 0), elevation_deg=(-20, 0))
    here = np.array([8.0, 1.5, 0.0])  # beside the way
    sweep = swept(mount, hall(), body, X_MR=here)
    points = in_map(sweep, mount, hall(), here)[sweep.owner == 0]
    low = points[(points[:, 2] > 0.1) & (points[:, 2] < 0.3)]
    return low[:, :2] - body.position[0]


def test_legs_swing_with_the_distance_walked():
    stride = 2 * 0.41 * 1.7
    together, apart = shins(walker()), shins(walker(walked=np.array([stride / 4])))
    assert np.ptp(together[:, 0]) < 0.2
    assert 0.3 < np.ptp(apart[:, 0]) <= 0.5
    # a step later the other leg is ahead; a stride later all is as before
    left = {}
    for steps in (0.5, 1.5, 2.5):
        along = shins(walker(walked=np.array([steps * stride / 2])))
        left[steps] = (
            along[along[:, 0] > 0.05][:, 1].mean() > along[along[:, 0] < -0.05][:, 1].mean()
        )
    assert left[0.5] == left[2.5] != left[1.5]


def test_who_stands_has_both_legs_below_the_hips():
    for walked in (0.0, 0.35, 1.0):
        along = shins(walker(walked=np.array([walked]), speed=np.zeros(1)))
        assert np.ptp(along[:, 0]) < 0.2


# ------------------------------------------------------------------ laws of the whole


def busy():
    rng = np.random.default_rng(4)
    bodies = HumanBodies(
        position=rng.uniform([1, 1], [11, 9], (8, 2)),
        heading=rng.uniform(-3, 3, 8),
        walked=rng.uniform(0, 3, 8),
        speed=rng.uniform(0, 1.5, 8),
        height=rng.uniform(1.5, 1.9, 8),
        radius=np.full(8, 0.25),
    )
    return hall((0, 0, 12, 0.1), (0, 9.9, 12, 10), (6, 3, 6.5, 3.5), ceiling=2.5), bodies


@pytest.mark.parametrize("kind", [lidar, camera])
def test_a_rotated_world_gives_the_same_cloud(kind):
    """The sensor turns along, so all that it sees is the same in its own frame."""
    scenery, bodies = busy()
    X = np.array([3.0, -2.0, 0.7])
    turned = replace(scenery, grid=replace(scenery.grid, X_MG=compose(X, scenery.grid.X_MG)))
    others = replace(bodies, position=transform(X, bodies.position), heading=bodies.heading + X[2])
    mount = kind(pose=POSES[1])
    one, two = swept(mount, scenery, bodies), swept(mount, turned, others, compose(X, HERE))
    agree = np.isclose(one.cloud.points, two.cloud.points, atol=1e-4, equal_nan=True).all(axis=1)
    assert agree.mean() > 0.999  # a ray along an edge may fall to either side of it
    np.testing.assert_allclose(one.visible, two.visible, atol=0.02)


def test_a_turned_chair_sees_the_same_points_in_the_map():
    scenery, bodies = busy()
    mount = lidar(azimuths=360)
    turn = np.array([5.0, 5.0, np.radians(90.0)])
    one = in_map(swept(mount, scenery, bodies), mount, scenery)
    two = in_map(swept(mount, scenery, bodies, turn), mount, scenery, turn)
    rolled = np.roll(two.reshape(360, 16, 3), 90, axis=0).reshape(-1, 3)
    agree = np.isclose(one, rolled, atol=1e-4, equal_nan=True).all(axis=1)
    assert agree.mean() > 0.999


def test_the_same_seed_gives_the_same_cloud():
    scenery, bodies = busy()
    noisy = LidarMount(rings=16, azimuths=180)
    assert identical(swept(noisy, scenery, bodies), swept(noisy, scenery, bodies))
    assert not identical(swept(noisy, scenery, bodies), swept(noisy, scenery, bodies, seed=1))


@pytest.mark.parametrize("mount", [LidarMount(rings=16, azimuths=180), DepthCameraMount()])
def test_as_many_numbers_are_drawn_whatever_there_is_to_see(mount):
    scenery, bodies = busy()
    after = []
    for world, people in ((scenery, bodies), (hall(), NOBODY)):
        rng = np.random.default_rng(0)
        scan_cloud(mount, world, people, HERE, time=0.0, rng=rng)
        after.append(rng.random())
    assert after[0] == after[1]


def test_blind_sectors_are_empty_and_the_rest_is_as_it_was():
    scenery, bodies = busy()
    sector = BlindSector(azimuth_deg=(350.0, 40.0), elevation_deg=(-90.0, -5.0))
    whole = swept(lidar(), scenery, bodies).cloud.points
    blind = swept(lidar(blind=(sector,)), scenery, bodies).cloud.points
    x, y, z = whole.T
    azimuth, elevation = (
        np.degrees(np.arctan2(y, x)) % 360.0,
        np.degrees(np.arcsin(z / np.linalg.norm(whole, axis=1))),
    )
    inside = ((azimuth >= 350.0 - 1e-3) | (azimuth <= 40.0 + 1e-3)) & (elevation <= -5.0)
    assert inside.sum() > 50
    assert np.isnan(blind[inside]).all()
    np.testing.assert_array_equal(blind[~inside], whole[~inside])
    # who stands in it is hidden by it
    ahead = HumanBodies.standing(np.array([[6.0, 5.0]]))
    assert swept(lidar(blind=(sector,)), hall(), ahead).visible[0] < 0.5


def test_nothing_nearer_than_the_least_range_is_seen():
    scenery = hall((5.4, 3.0, 5.6, 7.0))
    near = swept(lidar(range_min=1.0), scenery).cloud.points
    assert np.nanmin(np.linalg.norm(near, axis=1)) >= 1.0
    assert np.nanmin(np.linalg.norm(swept(lidar(), scenery).cloud.points, axis=1)) < 0.5


def test_noise_and_dropouts_are_as_the_mounts_say():
    scenery = hall((7.9, 0.0, 8.0, 10.0), wall_height=5.0)
    noisy = LidarMount(noise=0.03, dropout=0.02, range_min=0.0)
    still = noisy.model_copy(update={"noise": 0.0, "dropout": 0.0})
    one, two = (np.linalg.norm(swept(m, scenery).cloud.points, axis=1) for m in (noisy, still))
    seen = np.isfinite(two) & (two < 9.8)
    assert np.isnan(one[seen]).mean() == pytest.approx(0.02, abs=0.004)  # 4 √(0.02 / 2e4)
    error = (one - two)[seen & np.isfinite(one)]
    assert error.std() == pytest.approx(0.03, rel=0.05)
    assert error.mean() == pytest.approx(0.0, abs=0.001)
    # of the camera it grows with the square of the range: divided by it, it is the same everywhere
    pixels = DepthCameraMount(columns=200, rows=100, noise=0.002, dropout=0.0, range_min=0.0)
    exact = pixels.model_copy(update={"noise": 0.0})
    one, two = (np.linalg.norm(swept(m, scenery).cloud.points, axis=1) for m in (pixels, exact))
    share = ((one - two) / two**2)[two < 9.0]
    assert share.std() == pytest.approx(0.002, rel=0.05)


def test_a_camera_looks_ahead_as_wide_as_it_says():
    mount = camera(columns=1001, rows=3, field_of_view_deg=(87.0, 58.0))
    rays = mount.rays()
    azimuth = np.degrees(np.arctan2(rays[..., 1], rays[..., 0]))
    assert azimuth.max() == pytest.approx(43.5, abs=0.1)
    assert azimuth.min() == pytest.approx(-43.5, abs=0.1)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0)
