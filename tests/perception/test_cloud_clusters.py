import dataclasses
import os
import time
from pathlib import Path

import numpy as np
import pytest

from cohelm.geometry import compose, transform
from cohelm.maps import distance_field
from cohelm.perception import CloudClusters
from cohelm.perception.preprocessing.merged_cloud import merge_clouds
from cohelm.robots import DepthCameraMount
from cohelm.simulation.sensors import HumanBodies
from cohelm.testing import check_cloud_detector
from cohelm.testing.scenes import open_floor

from .clouds import HERE, LIDAR, SPARSE, bare, cloud_of, hall, off, scenery, see

SURE = 0.73
"""Confidence from which a tracker takes a shape alone for a person."""


def test_fulfils_the_contract():
    check_cloud_detector(CloudClusters(), within=20.0)


@pytest.mark.parametrize("mount", [LIDAR, SPARSE], ids=["32", "16"])
@pytest.mark.parametrize("heading", [0.0, 0.8, np.pi / 2])
def test_people_are_found_where_they_are(mount, heading):
    places = np.array([[2.0, 0.5], [-1.0, 4.0], [5.0, -3.0], [-6.0, -3.0], [0.5, -7.0]])
    bodies = HumanBodies.standing(places, heading=heading)
    seen = see(scenery(), bodies, mount)
    assert len(seen.position) == 5
    assert off(seen, bodies).max() < 0.1
    assert seen.confidence.min() > 0.5
    assert seen.confidence.mean() > (SURE if mount is LIDAR else 0.65)


def test_the_printed_centre_is_too_near_and_the_corrected_one_is_not():
    away = np.array([[4.0, 0.0], [-5.0, 0.0], [0.0, 6.0], [0.0, -3.0]])
    bodies = HumanBodies.standing(away, heading=0.6)
    bias = {}
    for centre in ("printed", "corrected"):
        seen = see(scenery(), bodies, centre=centre)
        bias[centre] = (np.sort(np.hypot(*seen.position.T)) - [3.0, 4.0, 5.0, 6.0]).mean()
    assert bias["printed"] < -0.06
    assert abs(bias["corrected"]) < 0.03


@pytest.mark.parametrize("gap", [0.5, 0.6, 0.8])
@pytest.mark.parametrize("away", [2.0, 4.0, 6.0])
def test_two_side_by_side_are_two(gap, away):
    bodies = HumanBodies.standing(np.array([[away, -gap / 2], [away, gap / 2]]))
    seen = see(scenery(), bodies)
    assert len(seen.position) == 2
    assert off(seen, bodies).max() < 0.1


def test_three_abreast_are_three():
    bodies = HumanBodies.standing(np.array([[4.0, -0.6], [4.0, 0.0], [4.0, 0.6]]))
    assert off(see(scenery(), bodies), bodies).max() < 0.1


@pytest.mark.parametrize("gap", [0.15, 0.4])
@pytest.mark.parametrize(
    "thing",
    [((0.1, 4.0), 2.7), ((0.8, 1.6), 0.75), ((0.6, 3.0), 1.1)],
    ids=["wall", "table", "bar"],
)
def test_people_at_walls_and_tables_stand_free_of_them(thing, gap):
    (depth, breadth), height = thing
    bodies = HumanBodies.standing(np.array([[5.0 - depth / 2 - gap - 0.12, 0.3]]))
    seen = see(scenery((5.0, 0.0, (depth, breadth), height)), bodies)
    assert off(seen, bodies)[0] < 0.1
    assert (seen.confidence > SURE).sum() == 1


def test_a_person_behind_a_table_or_half_behind_another_is_seen():
    table = (3.0, 0.0, (0.8, 1.6), 0.75)
    bodies = HumanBodies.standing(np.array([[4.0, 0.2], [2.0, 3.0], [2.8, 4.6]]))
    assert off(see(scenery(table), bodies), bodies).max() < 0.15


def test_legs_belong_to_their_body():
    bodies = dataclasses.replace(
        HumanBodies.standing(np.array([[3.0, 0.0]])), speed=np.array([1.2]), walked=np.array([0.35])
    )
    seen = see(scenery(), bodies)
    near = np.hypot(*(seen.points - [3.0, 0.0]).T) < 0.6
    assert near.sum() > 10
    assert (seen.detection_of_return[near] == 0).mean() > 0.9


FURNITURE = {
    "cabinet": ((0.5, 0.5), 1.8),
    "shelf": ((1.0, 0.4), 2.0),
    "bookcase": ((0.3, 0.8), 1.6),
    "pillar": (0.2, np.nan),
    "square pillar": ((0.4, 0.4), np.nan),
    "chair": ((0.45, 0.45), 0.9),
    "table": ((1.4, 0.8), 0.75),
    "coat stand": (0.06, 1.75),
    "bin": (0.2, 0.7),
}


@pytest.mark.parametrize("name", FURNITURE)
def test_furniture_is_hardly_a_person(name):
    size, height = FURNITURE[name]
    for x, y in ((2.5, 0.3), (-3.0, 3.0), (1.0, -6.0)):
        seen = see(scenery((x, y, size, height)))
        assert (seen.confidence < SURE).all()


@pytest.mark.parametrize("ceiling", [2.4, 2.7, np.inf])
def test_an_empty_hall_shows_nobody_and_its_walls_are_the_maps(ceiling):
    seen = see(scenery(ceiling=ceiling))
    assert len(seen.position) == 0
    assert seen.mapped.mean() > 0.99


def test_what_hangs_above_heads_is_not_in_the_way():
    lamp = np.random.default_rng(0).uniform([3.0, -0.3, 2.2], [3.6, 0.3, 2.5], (500, 3))
    cloud = cloud_of(scenery(ceiling=np.inf))
    hung = np.concatenate([cloud.points, (lamp - [0.0, 0.0, 1.3]).astype(np.float32)])
    detector = CloudClusters()
    plain = detector.detect((cloud,), HERE[None], hall()[1])
    seen = detector.detect((dataclasses.replace(cloud, points=hung),), HERE[None], hall()[1])
    assert len(seen.points) == len(plain.points)


def test_the_order_of_points_does_not_matter():
    cloud = cloud_of(
        scenery((3.0, 1.0, (1.0, 0.5), 0.8)), HumanBodies.standing(np.array([[3.0, -2.0]]))
    )
    order = np.random.default_rng(1).permutation(len(cloud.points))
    detector, walls = CloudClusters(), hall()[1]
    one = detector.detect((cloud,), HERE[None], walls)
    shuffled = dataclasses.replace(cloud, points=cloud.points[order])
    other = detector.detect((shuffled,), HERE[None], walls)
    assert np.array_equal(one.points, other.points)
    assert np.array_equal(one.detection_of_return, other.detection_of_return)
    assert np.allclose(one.position, other.position, atol=1e-6)


def test_moving_and_turning_the_world_moves_what_is_seen():
    bodies = HumanBodies.standing(np.array([[3.0, -2.0], [-4.0, 1.0]]))
    cloud, walls = cloud_of(scenery(), bodies), hall()[1]
    X = np.array([12.0, -5.0, 2.2])
    moved = dataclasses.replace(walls, X_MG=compose(X, walls.X_MG))
    detector = CloudClusters()
    here = detector.detect((cloud,), HERE[None], walls)
    there = detector.detect((cloud,), compose(X, HERE)[None], moved)
    assert np.allclose(there.position, transform(X, here.position), atol=1e-6)
    assert np.allclose(there.points, transform(X, here.points), atol=1e-6)
    assert np.allclose(there.confidence, here.confidence)


def test_clouds_of_two_sensors_are_one():
    # the camera sees the box of 0.2 m beside the footrest that lies below the LiDAR's lowest ring
    scene = scenery((1.3, 0.0, (0.2, 0.2), 0.2))
    bodies = HumanBodies.standing(np.array([[4.0, 0.5]]))
    clouds = tuple(cloud_of(scene, bodies, mount) for mount in (LIDAR, DepthCameraMount()))
    detector, walls = CloudClusters(), hall()[1]

    def box(seen):
        return (np.hypot(*(seen.points - [1.3, 0.0]).T) < 0.3).any()

    alone = detector.detect(clouds[:1], np.zeros((1, 3)), walls)
    both = detector.detect(clouds, np.zeros((2, 3)), walls)
    assert not box(alone)
    assert box(both)
    assert (both.confidence > SURE).sum() == 1
    assert off(both, bodies)[0] < 0.1


def test_a_tilted_sensor_sees_the_same_place():
    # a sensor pitched by 0.2 rad and told so: the cloud is turned back
    turn = np.array([[np.cos(0.2), 0, np.sin(0.2)], [0, 1, 0], [-np.sin(0.2), 0, np.cos(0.2)]])
    cloud = cloud_of(scenery(), HumanBodies.standing(np.array([[3.0, 1.0]])))
    level = merge_clouds((cloud,), HERE[None], 15.0).points
    tilted = bare(cloud.points @ turn, mount=(0.0, 0.0, 1.3, 0.0, 0.2, 0.0))
    assert np.allclose(merge_clouds((tilted,), HERE[None], 15.0).points, level, atol=1e-4)


def test_directions_are_free_as_far_as_the_ground_was_seen_and_blind_ones_are_not():
    cloud = cloud_of(scenery(ceiling=np.inf))
    behind = cloud.points[:, 0] > 0.0
    points = np.where(behind[:, None], cloud.points, np.nan).astype(np.float32)
    wide = open_floor()
    seen = CloudClusters().detect((dataclasses.replace(cloud, points=points),), HERE[None], wide)
    assert (seen.free_ends[:, 0] > -0.1).all()
    open_hall = bare(ring_of_ground(6.0))
    free = CloudClusters().detect((open_hall,), HERE[None], wide).free_ends
    assert len(free) == 360
    assert np.allclose(np.hypot(*free.T), 6.0, atol=0.05)


def ring_of_ground(radius):
    angle = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
    ring = [np.stack([r * np.cos(angle), r * np.sin(angle)], axis=-1) for r in (3.0, 4.5, radius)]
    flat = np.concatenate(ring)
    return np.column_stack([flat, np.full(len(flat), -1.3)])


@pytest.mark.parametrize(
    "points",
    [
        np.empty((0, 3)),
        np.full((100, 3), np.nan),
        np.full((100, 3), np.inf),
        np.full((100, 3), 1e30),
        [[2.0, 0.0, 0.5]],
        np.zeros((1000, 3)),
        [[2.0, 0.0, 0.5]] * 1000,
    ],
    ids=["empty", "nan", "inf", "huge", "one", "zeros", "same"],
)
@pytest.mark.parametrize("height", [1.3, np.nan])
def test_nobody_is_made_of_nothing(points, height):
    cloud = bare(points, mount=(0.0, 0.0, height, 0.0, 0.0, 0.0))
    seen = CloudClusters().detect((cloud,), HERE[None], open_floor())
    assert len(seen.position) == 0
    assert len(seen.free_ends) == 0


@pytest.mark.parametrize("bad", [3, 0, "pose", "reach"])
def test_a_pose_or_a_reach_that_is_no_number_shows_nothing(bad):
    cloud, pose = cloud_of(scenery(), HumanBodies.standing(np.array([[3.0, 1.0]]))), HERE.copy()
    if bad == "pose":
        pose[1] = np.nan
    elif bad == "reach":
        cloud = dataclasses.replace(cloud, range_max=np.nan)
    else:
        mount = cloud.mount.copy()
        mount[bad] = np.inf
        cloud = dataclasses.replace(cloud, mount=mount)
    seen = CloudClusters().detect((cloud,), pose[None], open_floor())
    assert len(seen.position) == len(seen.points) == 0


def test_a_million_points_take_a_moment_and_make_no_crash():
    rng = np.random.default_rng(0)
    points = rng.uniform([-12.0, -12.0, -1.5], [12.0, 12.0, 2.0], (1_000_000, 3))
    cloud = bare(points)
    detector = CloudClusters()
    detector.detect((bare(points[:1000]),), HERE[None], open_floor())
    start = time.thread_time()
    seen = detector.detect((cloud,), HERE[None], open_floor())
    assert time.thread_time() - start < 5.0
    assert (seen.confidence < SURE).all()


def test_one_sweep_of_32_by_1024_is_quick():
    bodies = HumanBodies.standing(np.array([[2.0, 0.5], [-1.0, 4.0], [5.0, -3.0]]))
    cloud, walls = cloud_of(scenery((3.0, -2.0, (1.0, 0.5), 0.8)), bodies), hall()[1]
    detector, times = CloudClusters(), []
    for _ in range(20):
        start = time.thread_time()
        detector.detect((cloud,), HERE[None], walls)
        times.append(time.thread_time() - start)
    assert np.median(times) < 0.012


def test_beyond_the_reach_of_one_sensor_the_view_is_the_other_s():
    def slopes(low, high):
        return [[4.0, 0.0, 4.0 * low], [4.0, 0.0, 4.0 * high]]

    steep = bare(slopes(-0.5, 0.25), (0.0, 0.0, 1.3, 0.0, 0.0, 0.0), range_max=6.0)
    flat = bare(slopes(-0.75, 0.1), (1.0, 0.0, 0.8, 0.0, 0.0, 0.0), range_max=10.0)
    seen = merge_clouds((steep, flat), np.zeros((2, 3)), 15.0)
    places = np.array([[4.0, 0.0], [9.0, 0.0], [30.0, 0.0]])
    low, high = seen.in_view(places)
    assert np.allclose(low, [0.8 - 0.75 * 3.0, 0.8 - 0.75 * 8.0, 0.8 - 0.75 * 29.0])
    assert np.allclose(high, [1.3 + 0.25 * 4.0, 0.8 + 0.1 * 8.0, 1.3 + 0.25 * 30.0])


def test_a_sensor_with_returns_at_its_lens_alone_has_no_view():
    seen = merge_clouds((bare([[0.2, 0.0, 0.0]]),), HERE[None], 15.0)
    assert np.isfinite(seen.in_view(np.array([[0.0, 0.0], [3.0, 0.0]]))).all()


@pytest.mark.parametrize(("away", "proves"), [(4.0, True), (5.7, False)])
def test_what_the_end_of_the_reach_cuts_is_no_person_for_sure(away, proves):
    lidar = LIDAR.model_copy(update={"range_max": 6.0})
    cloud = cloud_of(scenery(ceiling=np.inf), HumanBodies.standing(np.array([[away, 0.0]])), lidar)
    seen = CloudClusters().detect((cloud,), HERE[None], open_floor())
    assert len(seen.position) == 1
    assert (seen.confidence[0] > 0.5) == proves


@pytest.mark.data
def test_the_pedestrian_of_a_street_is_found():
    folder = Path(os.environ.get("COHELM_DATA", "/nowhere")) / "lidar"
    if not folder.exists():
        pytest.skip("COHELM_DATA does not name the data sets")
    points = np.fromfile(folder / "kitti_obj_000000.bin", np.float32).reshape(-1, 4)[:, :3]
    calibration = {
        key: np.array(numbers.split(), dtype=float)
        for key, _, numbers in (
            line.partition(":")
            for line in (folder / "kitti_obj_000000.calib.txt").read_text().splitlines()
            if line
        )
    }
    to_camera, rectified = np.eye(4), np.eye(4)
    to_camera[:3] = calibration["Tr_velo_to_cam"].reshape(3, 4)
    rectified[:3, :3] = calibration["R0_rect"].reshape(3, 3)
    words = (folder / "kitti_obj_000000.label.txt").read_text().split()
    truth = np.linalg.solve(rectified @ to_camera, [*map(float, words[11:14]), 1.0])[:2]
    for height in (1.73, np.nan):
        cloud = bare(points, mount=(0.0, 0.0, height, 0.0, 0.0, 0.0), range_max=120.0)
        walls = distance_field(dataclasses.replace(hall()[0], data=hall()[0].data * 0))
        seen = CloudClusters().detect((cloud,), HERE[None], walls)
        apart = np.hypot(*(seen.position - truth).T)
        assert apart.min() < 0.3
        assert seen.confidence[apart.argmin()] > SURE
