"""Laws of the world."""

from dataclasses import replace

import numpy as np
import pytest

from cohelm.arrays import identical
from cohelm.geometry import compose, transform, wrap_angle
from cohelm.messages import Decision
from cohelm.robots import DepthCameraMount, LaserMount, LidarMount
from cohelm.simulation import Fault, Localisation, NoRider, Odometry, World

STAY = Decision(twist=np.zeros(3))
GO = Decision(twist=np.array([1.0, 0.0, 0.2]))


@pytest.fixture
def busy(make_setup, make_crowd, make_grid):
    rng = np.random.default_rng(3)
    n = 6
    crowd = make_crowd(
        rng.uniform([4, 1], [11, 9], (n, 2)),
        rng.uniform([1, 1], [11, 9], (n, 3, 2)),
        loop=np.ones(n, dtype=bool),
        sees_robot=np.ones(n, dtype=bool),
    )
    walls = ((0, 0, 12, 0.1), (0, 9.9, 12, 10), (6, 3, 6.5, 3.5))
    return make_setup(grid=make_grid(boxes=walls), crowd=crowd)


def ride(setup, seed, ticks=60, decision=GO):
    world = World(setup, seed)
    out = [(world.observe(), world.truth)]
    for _ in range(ticks):
        world.advance(decision)
        out.append((world.observe(), world.truth))
    return out


def test_twin_worlds_agree_bit_for_bit(busy):
    assert identical(ride(busy, 7), ride(busy, 7))
    assert not identical(ride(busy, 7)[-1][0].pose, ride(busy, 8)[-1][0].pose)


def test_one_more_sensor_changes_nothing_else(busy):
    second = LaserMount(name="rear", pose=(-0.4, 0.0, np.pi), rate=25.0)
    robot = busy.robot.model_copy(update={"lasers": (*busy.robot.lasers, second)})
    for (o, t), (o2, t2) in zip(ride(busy, 1), ride(replace(busy, robot=robot), 1), strict=True):
        assert identical(t, t2)
        assert identical(o, o2, ignore=frozenset({"scans"}))
        assert identical(o.scans, tuple(s for s in o2.scans if s.mount[0] == 0.0))


LIDAR = LidarMount(rings=8, azimuths=90, rate=10.0)
CAMERA = DepthCameraMount(columns=20, rows=12, rate=15.0)


@pytest.fixture
def seeing(busy):
    """The same with a LiDAR and a depth camera beside the scanner."""
    update = {"lidars": (LIDAR,), "depth_cameras": (CAMERA,)}
    return replace(busy, robot=busy.robot.model_copy(update=update))


def test_sensors_in_space_change_nothing_else(busy, seeing):
    for (o, t), (o2, t2) in zip(ride(busy, 1), ride(seeing, 1), strict=True):
        assert identical(t, t2)
        assert identical(o, o2, ignore=frozenset({"clouds"}))
    assert identical(ride(seeing, 1), ride(seeing, 1))


def test_each_sensor_in_space_keeps_its_own_rate(seeing):
    clouds = [c for o, _ in ride(seeing, 0) for c in o.clouds]
    for mount, period in ((LIDAR, 0.1), (CAMERA, 1.0 / 15.0)):
        times = np.array([c.time for c in clouds if c.mount[0] == mount.pose[0]])
        assert len(times) == round(3.0 / period) + 1
        # on the first physics step (0.01 s) that is not before its turn
        late = times - period * np.arange(len(times))
        assert late.min() > -1e-6
        assert late.max() < 0.01


def test_people_who_stay_look_the_same_all_the_time(busy):
    robot = busy.robot.model_copy(
        update={"lidars": (LIDAR.model_copy(update={"noise": 0.0, "dropout": 0.0}),)}
    )
    still = replace(
        busy, robot=robot, crowd=replace(busy.crowd, waypoints=busy.crowd.position[:, None])
    )
    one, *_, last = (c for o, _ in ride(still, 0, decision=STAY) for c in o.clouds)
    np.testing.assert_allclose(one.points, last.points, atol=1e-3)


def test_a_rotated_world_has_the_same_ride_rotated(busy):
    X = np.array([3.0, -2.0, np.pi / 2])
    turn = np.array([0.0, 0.0, np.pi / 2])
    rotated = replace(
        busy,
        grid=replace(busy.grid, X_MG=compose(X, busy.grid.X_MG)),
        start=compose(X, busy.start),
        crowd=replace(
            busy.crowd,
            position=transform(X, busy.crowd.position),
            velocity=transform(turn, busy.crowd.velocity),
            heading=busy.crowd.heading + np.pi / 2,
            waypoints=transform(X, busy.crowd.waypoints),
        ),
        rider_goal=transform(X, busy.rider_goal),
        rider_route=transform(X, busy.rider_route),
    )
    for (o, t), (o2, t2) in zip(ride(busy, 4), ride(rotated, 4), strict=True):
        np.testing.assert_allclose(o2.pose[:2], compose(X, o.pose)[:2], atol=1e-9)
        np.testing.assert_allclose(t2.crowd.position, transform(X, t.crowd.position), atol=1e-6)
        np.testing.assert_allclose(o2.twist, o.twist, atol=1e-12)
        for scan, scan2 in zip(o.scans, o2.scans, strict=True):
            np.testing.assert_allclose(scan2.ranges, scan.ranges, atol=1e-5)


def test_scans_come_at_their_own_rate(busy):
    scans = [s.time for o, _ in ride(busy, 0) for s in o.scans]
    np.testing.assert_allclose(scans, np.arange(31) * 0.1, atol=1e-9)  # 10 Hz over 3 s


def test_time_is_counted_not_summed(busy):
    times = [o.time for o, _ in ride(busy, 0, ticks=41)]
    assert times == [k * 0.05 for k in range(42)]


def test_the_localiser_errs_within_its_bounds_and_slowly():
    localisation, rng = Localisation(), np.random.default_rng(0)
    errors = [localisation.first(rng)]
    for _ in range(4000):
        errors.append(localisation.after(errors[-1], 0.05, rng))
    error = np.array(errors)
    far = np.hypot(error[:, 0], error[:, 1])
    assert far.max() <= 0.03 + 1e-12
    assert np.abs(error[:, 2]).max() <= np.deg2rad(1.0) + 1e-12
    assert far.max() > 0.02
    # step of an OU process: σ √(2 dt/τ) = 0.015 √(2 · 0.05 / 2) = 3.4 mm
    assert np.std(np.diff(error[:, 0])) == pytest.approx(0.0034, rel=0.15)


def test_without_errors_the_chair_knows_all(busy):
    exact = replace(
        busy,
        localisation=Localisation(position_bound=0.0, heading_bound_deg=0.0),
        odometry=Odometry(share=0.0, linear_floor=0.0, angular_floor=0.0),
        give_people=True,
    )
    for o, t in ride(exact, 0):
        np.testing.assert_allclose(o.pose, t.pose, atol=1e-15)
        np.testing.assert_array_equal(o.twist, t.twist)
        np.testing.assert_array_equal(o.people.mean[:, :2], t.crowd.position)
        np.testing.assert_array_equal(o.people.mean[:, 2:], t.crowd.velocity)
        assert o.people.source == "simulation"


def test_people_are_not_given_unless_asked_for(busy):
    assert all(o.people is None for o, _ in ride(busy, 0, ticks=2))


def test_odometry_reads_zero_at_rest_and_noise_in_motion(make_setup):
    assert not any(o.twist.any() for o, _ in ride(make_setup(), 0, ticks=20, decision=STAY))
    error = np.array([(o.twist - t.twist)[0] for o, t in ride(make_setup(), 0, ticks=100)[40:]])
    # share 0.02 × 1 m/s + 0.003
    assert np.std(error) == pytest.approx(0.023, rel=0.35)


def test_the_riders_heart_beats(busy):
    assert all(o.rider.heartbeat == o.time for o, _ in ride(busy, 0, ticks=5))
    silent = replace(busy, rider=NoRider())
    assert all(o.rider is None for o, _ in ride(silent, 0, ticks=5))


def test_faults_reach_the_observation_and_not_the_truth(busy):
    broken = replace(busy, faults=(Fault(kind="pose_silent", at=1.0, duration=0.5),))
    sound, faulty = ride(busy, 0), ride(broken, 0)
    assert identical([t for _, t in sound], [t for _, t in faulty])
    frozen = [o for o, _ in faulty if o.pose_time < o.time]
    assert [round(o.time, 2) for o in frozen] == [1.0 + 0.05 * k for k in range(10)]
    assert all(o.pose_time == pytest.approx(0.95) for o in frozen)


def test_driving_into_a_wall_is_told_and_does_not_stop_the_world(make_setup, make_grid):
    setup = make_setup(grid=make_grid(boxes=((5.0, 0.0, 5.2, 10.0),)))
    out = ride(setup, 0, ticks=120, decision=Decision(twist=np.array([1.0, 0.0, 0.0])))
    hits = [t.hit_wall for _, t in out]
    first = hits.index(True)
    # the front reaches 0.65 m ahead of the axle, the wall begins at 5 m
    assert out[first - 1][1].pose[0] < 4.35
    assert out[first][1].pose[0] >= 4.35 - 1e-9
    assert out[-1][1].pose[0] > 5.5
    before = out[first - 5][1]
    assert before.gap_wall == pytest.approx(4.35 - before.pose[0])


def someone_coming(make_crowd, speed=1.0):
    """A person 4 m ahead of the chair who comes straight at it and does not see it."""
    return make_crowd(
        [[6.0, 5.0]], [[[-6.0, 5.0]]], preferred_speed=np.array([speed]),
        sees_robot=np.array([False]),
    )  # fmt: skip


def test_touching_someone_counts_apart_for_a_chair_that_stands(make_setup, make_crowd):
    setup = make_setup(crowd=someone_coming(make_crowd))
    standing = [t for _, t in ride(setup, 0, ticks=100, decision=STAY)]
    assert not any(t.hit_moving.any() for t in standing)
    first = next(t for t in standing if t.hit_standing.any())
    # from 6 m to the front at 2.65 m, less the body's 0.25 m: 3.1 s at 1 m/s, and 0.06 s more for
    # starting at 6 m/s² (0.3, 0.6, 0.9 m/s); seen at the end of a tick of 0.05 s
    assert first.time == pytest.approx(3.16, abs=0.05)
    moving = [t for _, t in ride(setup, 0, ticks=50)]
    assert any(t.hit_moving.any() for t in moving)


def test_one_who_sees_the_chair_goes_round_it(make_setup, make_crowd):
    crowd = replace(
        someone_coming(make_crowd), sees_robot=np.array([True]), position=np.array([[6.0, 5.1]])
    )
    out = ride(make_setup(crowd=crowd), 0, ticks=140, decision=STAY)
    assert not any(t.hit_standing.any() for _, t in out)
    assert out[-1][1].crowd.position[0, 0] < 1.0  # passed it


def test_gaps_are_between_surfaces(make_setup, make_crowd):
    crowd = someone_coming(make_crowd)
    truth = World(make_setup(crowd=crowd), 0).truth
    np.testing.assert_allclose(truth.gap_people, [6.0 - 2.65 - 0.25])
    assert truth.gap_wall == np.inf


def test_the_laser_sees_people_where_they_are(make_setup, make_crowd):
    quiet = LaserMount(noise=0.0, dropout=0.0)
    setup = make_setup(crowd=someone_coming(make_crowd))
    setup = replace(setup, robot=setup.robot.model_copy(update={"lasers": (quiet,)}))
    world = World(setup, 0)
    world.advance(STAY)
    world.advance(STAY)
    (scan,) = world.observe().scans
    ahead = scan.ranges[180]  # −π + 180°
    assert ahead == pytest.approx(world.truth.crowd.position[0, 0] - 2.0 - 0.25, abs=1e-9)
    assert np.isfinite(scan.ranges).sum() < 20  # the chair does not see itself


def test_headings_stay_wrapped(make_setup):
    out = ride(make_setup(), 0, ticks=200, decision=Decision(twist=np.array([0, 0, 1.0])))
    heading = np.array([t.pose[2] for _, t in out])
    np.testing.assert_allclose(heading, wrap_angle(heading), atol=1e-12)
