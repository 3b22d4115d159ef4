"""The axes of a cloud from the floor that it shows."""

import numpy as np
import pytest

from cohelm.evaluation.perception.level import NO_FLOOR, OPTICAL, Leveller, find_level, is_unknown
from cohelm.evaluation.perception.recording_view import perceive_frames, perception_of
from cohelm.messages import PointCloud, Sensing
from cohelm.recordings import open_recording
from cohelm.recordings.clouds.kitti import HEIGHT
from cohelm.recordings.clouds.sweep import UNKNOWN_MOUNT


def hall(camera):
    """Floor 1 m below a sensor, a wall 4 m ahead and a body 2 m ahead; z up."""
    rng = np.random.default_rng(0)
    wide = 1.0 if camera else 4.0
    floor = rng.uniform([1.5 if camera else -4.0, -wide, -1.0], [4.0, wide, -1.0], (3000, 3))
    wall = rng.uniform([4.0, -wide, -1.0], [4.0, wide, 1.2], (2000, 3))
    body = rng.uniform([2.0, 0.2, -1.0], [2.1, 0.6, 0.7], (1000, 3))
    return np.concatenate([floor, wall, body])


def pitched(degrees):
    """Rotation of a sensor that looks so far down, as seen from it."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])


Y_UP = np.array([[0.0, -1, 0], [0, 0, 1], [-1, 0, 0]])
"""To x right, y up and z backwards, as in OpenGL."""


@pytest.mark.parametrize("pitch", [-20.0, 0.0, 20.0, 30.0])
@pytest.mark.parametrize(
    ("axes", "camera"),
    [
        (np.eye(3), False),
        (OPTICAL.T, True),
        (Y_UP, True),
        (Y_UP, False),
        (np.diag([1.0, -1.0, -1.0]), False),
    ],
    ids=["z up", "optical", "y up", "y up, all around", "upside down"],
)
def test_the_floor_shows_where_up_is(axes, camera, pitch):
    X = axes @ pitched(pitch)
    level = find_level((hall(camera) @ X.T).astype(np.float32))
    assert level is not None
    up = level.rotation @ X @ [0.0, 0.0, 1.0]
    assert up[2] > np.cos(np.radians(2.0))
    assert np.linalg.det(level.rotation) == pytest.approx(1.0)
    if camera:  # what is ahead of it stays ahead
        assert (level.rotation @ X @ [1.0, 0.0, 0.0])[0] > 0.99


def test_a_level_cloud_stays_as_it_is():
    cloud = PointCloud(
        time=0.0, mount=UNKNOWN_MOUNT, points=hall(camera=False).astype(np.float32), range_max=10.0
    )
    level = Leveller("velodyne")
    after, warning = level(cloud)
    assert (after.points == cloud.points).all()
    assert warning == ""
    assert not is_unknown(np.array([0.0, 0.0, HEIGHT, 0.0, 0.0, 0.0]))  # KITTI


@pytest.mark.parametrize("normal", [0, 1, 2])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_wall_alone_is_no_floor(normal, side):
    points = np.random.default_rng(1).uniform(-1.5, 1.5, (5000, 3))
    points[:, normal] = 2.5 * side
    level = find_level(points.astype(np.float32))
    # Below a sensor with z up it cannot be told from a floor.
    assert (level is not None) == (normal == 2 and side < 0.0)


def test_a_frame_s_name_gives_the_axes_of_a_camera():
    wall = np.random.default_rng(1).uniform([-1.0, -1.0, 3.0], [1.0, 1.0, 3.0], (3000, 3))
    cloud = PointCloud(time=0.0, mount=UNKNOWN_MOUNT, points=wall.astype(np.float32), range_max=5.0)
    after, warning = Leveller("camera_depth_optical_frame")(cloud)
    assert after.points[:, 0] == pytest.approx(3.0)
    assert warning == NO_FLOOR


def test_no_floor_is_said(tmp_path):
    file = tmp_path / "wall.pcd"
    wall = np.random.default_rng(1).uniform([3.0, -1.5, -1.0], [3.0, 1.5, 1.0], (2000, 3))
    head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2000\nHEIGHT 1\n"
    rows = "\n".join(" ".join(f"{each:.3f}" for each in row) for row in wall)
    file.write_text(f"{head}VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2000\nDATA ascii\n{rows}\n")
    recording = open_recording(file)
    (seen,) = perceive_frames(recording, perception_of(), still=True)
    assert seen.perceived.sensing is Sensing.NO_FLOOR
    assert seen.warning == NO_FLOOR
    assert recording.warnings == []


def test_people_before_a_camera_without_a_mount_are_found(data):
    recording = open_recording(data / "lidar" / "pcl_five_people.pcd")
    (seen,) = perceive_frames(recording, perception_of(), still=True)
    assert seen.perceived.sensing is Sensing.OK
    # The nearest of the five is cut off by the picture's edge.
    assert len(seen.perceived.people) >= 4
    assert "-y up" in seen.warning
