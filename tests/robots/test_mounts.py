"""Sensors on robots: what their files may say, and where their rays go."""

import numpy as np
import pytest
from pydantic import ValidationError

from cohelm.robots import (
    BlindSector,
    DepthCameraMount,
    LaserMount,
    LidarMount,
    Robot,
    load_robot,
)


@pytest.mark.parametrize(
    ("kind", "wrong"),
    [
        (LidarMount, {"elevation_deg": (10.0, -10.0)}),
        (LidarMount, {"elevation_deg": (-95.0, 10.0)}),
        (LidarMount, {"rings": 0}),
        (LidarMount, {"range_min": 5.0, "range_max": 4.0}),
        (LidarMount, {"pose": (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)}),  # in the floor
        (LidarMount, {"pose": (0.0, 0.0, 1.0)}),
        (LidarMount, {"blind": [{"azimuth_deg": (0.0, 361.0)}]}),
        (LidarMount, {"blind": [{"azimuth_deg": (-10.0, 10.0)}]}),
        (LidarMount, {"blind": [{"azimuth_deg": (20.0, 20.0)}]}),
        (LidarMount, {"blind": [{"azimuth_deg": (0.0, 9.0), "elevation_deg": (5.0, 5.0)}]}),
        (LidarMount, {"beams": 5}),
        (DepthCameraMount, {"field_of_view_deg": (180.0, 58.0)}),
        (DepthCameraMount, {"range_min": 10.0}),
        (DepthCameraMount, {"noise": float("nan")}),
    ],
)
def test_what_makes_no_sense_is_refused(kind, wrong):
    with pytest.raises(ValidationError):
        kind.model_validate(wrong)


def test_rings_and_azimuths_are_evenly_spread_over_the_field_of_view():
    rays = LidarMount(rings=16, azimuths=360, elevation_deg=(-15.0, 15.0)).rays()
    assert rays.shape == (360, 16, 3)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1.0)
    elevation = np.degrees(np.arcsin(rays[..., 2]))
    np.testing.assert_allclose(elevation[0], np.linspace(-15.0, 15.0, 16))
    azimuth = np.degrees(np.unwrap(np.arctan2(rays[:, 0, 1], rays[:, 0, 0])))
    np.testing.assert_allclose(np.diff(azimuth), 1.0)
    np.testing.assert_allclose(rays[180, :, 1], 0.0, atol=1e-12)  # straight ahead
    assert (rays[180, :, 0] > 0.0).all()


@pytest.mark.parametrize(
    ("sector", "hidden"),
    [
        ((10.0, 20.0), {10, 15, 20}),
        ((350.0, 10.0), {350, 355, 0, 5, 10}),
        ((0.0, 360.0), set(range(0, 360, 5))),
    ],
)
def test_a_blind_sector_may_pass_through_straight_ahead(sector, hidden):
    azimuth = np.radians(np.arange(0, 360, 5.0))
    hides = BlindSector(azimuth_deg=sector).hides(azimuth, np.zeros(72))
    assert set(np.arange(0, 360, 5)[hides].tolist()) == hidden


def test_sensors_have_names_of_their_own(chair):
    plain = chair.model_dump()
    both = {"lidars": [LidarMount(name="eye")], "depth_cameras": [DepthCameraMount(name="eye")]}
    with pytest.raises(ValidationError, match="two sensors are called 'eye'"):
        Robot.model_validate({**plain, **both})
    with pytest.raises(ValidationError, match="two sensors are called 'laser'"):
        Robot.model_validate({**plain, "lidars": [LidarMount(name="laser")]})
    front_and_rear = {"lasers": [LaserMount(), LaserMount(pose=(-0.4, 0.0, np.pi))]}
    assert len(Robot.model_validate({**plain, **front_and_rear}).lasers) == 2


def test_the_camera_of_the_lidar_chair_covers_what_the_lidar_passes_over():
    """From the footrests on, the camera sees the floor that the lowest ring does not meet yet."""
    robot = load_robot("quantum_q6_edge_lidar")
    (lidar,), (camera,) = robot.lidars, robot.depth_cameras
    assert robot.cloud_mounts == (lidar, camera)
    assert 1.2 <= lidar.pose[2] <= 1.4
    passes = lidar.pose[0] + lidar.pose[2] / np.tan(np.radians(-lidar.elevation_deg[0]))
    half, down = np.radians(camera.field_of_view_deg[1] / 2.0), camera.pose[4]
    nearest = camera.pose[0] + camera.pose[2] / np.tan(down + half)
    assert nearest < 1.1 < passes
    assert down < half  # up to the horizon and above
    # who is hidden by the rider is hidden at the front right only
    hidden = lidar.hidden().any(axis=1)
    azimuth = np.degrees(np.arctan2(*lidar.rays()[hidden, 0, 1::-1].T)) % 360.0
    assert azimuth.min() > 240.0
    assert azimuth.max() < 350.0
