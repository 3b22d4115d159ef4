"""KITTI, nuScenes, and folders of sweeps."""

import math

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording

from .clouds import pcd

CALIBRATION = """P0: 7 0 6 0 0 7 1 0 0 0 1 0
R0_rect: 1 0 0 0 1 0 0 0 1
Tr_velo_to_cam: 0 -1 0 0.1 0 0 -1 -0.2 1 0 0 -0.3
"""
LABELS = """Car 0.00 0 1.85 387.63 181.54 423.81 203.12 1.67 1.87 3.69 -16.53 2.39 58.49 1.57
Pedestrian 0.00 0 -0.20 712.40 143.00 810.73 307.92 1.89 0.48 1.20 1.84 1.47 8.41 0.01
Person_sitting 0.50 1 -0.2 712.4 143.0 810.7 307.9 1.0 0.4 0.4 -2.0 1.0 5.0 0.0
Cyclist 0.00 3 -1.65 676.60 163.95 688.98 193.93 1.86 0.60 2.02 4.59 1.32 45.84 -1.55
DontCare -1 -1 -10 503.89 169.71 590.61 190.13 -1 -1 -1 -1000 -1000 -1000 -10
"""


def sweep(rng, count=50):
    """x, y, z, reflectance."""
    return np.column_stack([rng.uniform(-40.0, 40.0, (count, 3)), rng.uniform(0.0, 1.0, count)])


def write(file, rows):
    file.write_bytes(np.asarray(rows, "<f4").tobytes())
    return file


def test_a_sweep_of_kitti(tmp_path, rng):
    rows = sweep(rng)
    rows[7, 1] = np.nan
    recording = open_recording(write(tmp_path / "000000.bin", rows))
    assert recording.frames == 1
    (frame,) = recording
    (cloud,) = frame.observation.clouds
    np.testing.assert_array_equal(cloud.points, rows[:, :3].astype(np.float32))
    assert cloud.mount.tolist() == [0.0, 0.0, 1.73, 0.0, 0.0, 0.0]
    assert frame.labels is None
    assert recording.warnings == []


@pytest.mark.parametrize("beside", [True, False])
def test_the_people_of_kitti_are_told_in_the_frame_of_the_sensor(tmp_path, rng, beside):
    if beside:
        file = write(tmp_path / "000003.bin", sweep(rng))
        places = [tmp_path / "000003.calib.txt", tmp_path / "000003.label.txt"]
    else:
        for folder in ("velodyne", "calib", "label_2"):
            (tmp_path / folder).mkdir()
        file = write(tmp_path / "velodyne" / "000003.bin", sweep(rng))
        places = [tmp_path / "calib" / "000003.txt", tmp_path / "label_2" / "000003.txt"]
    places[0].write_text(CALIBRATION)
    places[1].write_text(LABELS)
    (frame,) = open_recording(file)
    # the camera sees x_c = −y + 0.1 and z_c = x − 0.3; the height does not turn in here
    expected = [[8.41 + 0.3, 0.1 - 1.84], [5.0 + 0.3, 0.1 + 2.0]]
    assert frame.labels.position == pytest.approx(np.array(expected))
    assert frame.labels.visible.tolist() == [1.0, pytest.approx(0.3)]


def test_a_tilted_camera_tells_the_centre_of_the_box_and_not_its_foot(tmp_path, rng):
    # the camera looks down by 0.2 rad: half the height of 2 m moves the place by sin 0.2
    s, c = math.sin(0.2), math.cos(0.2)
    tilted = f"R0_rect: 1 0 0 0 {c} {-s} 0 {s} {c}\nTr_velo_to_cam: 0 -1 0 0 0 0 -1 0 1 0 0 0\n"
    label = "Pedestrian 0 0 0 0 0 0 0 2.0 0.5 0.5 0.0 0.0 10.0 0.0\n"
    file = write(tmp_path / "a.bin", sweep(rng))
    (tmp_path / "a.calib.txt").write_text(tilted)
    (tmp_path / "a.label.txt").write_text(label)
    (frame,) = open_recording(file)
    # the centre (0, −1, 10) in the camera, turned back: z = s·(0 − 1)·(−1)... = c·10 + s·1
    assert frame.labels.position[0] == pytest.approx([10.0 * c + s, 0.0])


@pytest.mark.parametrize(
    ("calibration", "labels"),
    [
        (None, LABELS),
        ("R0_rect: 1 0 0\n", LABELS),
        ("R0_rect: x\n", LABELS),
        (CALIBRATION, "Pedestrian 0 0 zero\n"),
        (CALIBRATION, "Pedestrian 0 0\n"),
        (CALIBRATION.replace("1", "0"), LABELS),
    ],
)
def test_labels_that_make_no_sense_are_told_and_the_sweep_is_read(
    tmp_path, rng, calibration, labels
):
    file = write(tmp_path / "a.bin", sweep(rng))
    if calibration is not None:
        (tmp_path / "a.calib.txt").write_text(calibration)
    (tmp_path / "a.label.txt").write_text(labels)
    recording = open_recording(file)
    (frame,) = recording
    assert frame.labels is None
    assert len(recording.warnings) == 1


@pytest.mark.parametrize("name", ["sweep.pcd.bin", "sweep.bin"])
def test_a_sweep_of_nuscenes_is_known_by_its_rings(tmp_path, rng, name):
    rows = np.column_stack([sweep(rng, 96), np.arange(96) % 32])
    rows[:, 3] = np.round(255.0 * rows[:, 3])
    (frame,) = open_recording(write(tmp_path / name, rows))
    (cloud,) = frame.observation.clouds
    np.testing.assert_array_equal(cloud.points, rows[:, :3].astype(np.float32))
    # y of the sensor is ahead
    assert cloud.mount == pytest.approx([0.0, 0.0, 1.84, 0.0, 0.0, -math.pi / 2.0])


@pytest.mark.parametrize(("columns", "name"), [(4, "a.bin"), (5, "a.pcd.bin")])
def test_a_sweep_that_is_cut_is_read_up_to_there(tmp_path, rng, columns, name):
    data = rng.uniform(1.0, 20.0, (30, columns)).astype("<f4").tobytes()
    (tmp_path / name).write_bytes(data[:-5])
    recording = open_recording(tmp_path / name)
    (frame,) = recording
    assert len(frame.observation.clouds[0].points) == 29
    (text,) = recording.warnings
    assert f"at byte {29 * columns * 4}" in text


@pytest.mark.parametrize("name", ["a.bin", "a.pcd.bin"])
def test_a_sweep_of_nothing_but_nan_is_a_frame(tmp_path, name):
    (frame,) = open_recording(write(tmp_path / name, np.full((40, 20), np.nan)))
    assert np.isnan(frame.observation.clouds[0].points).all()


def test_a_folder_of_sweeps_is_a_row_in_the_order_of_names(tmp_path):
    for k in (10, 9, 1):
        write(tmp_path / f"{k}.bin", np.full((20, 4), float(k)))
    (tmp_path / "notes.txt").write_text("not a sweep")
    recording = open_recording(tmp_path)
    assert recording.frames == 3
    (warning,) = recording.warnings
    assert "10 sweeps per second" in warning
    frames = list(recording)
    assert [f.observation.clouds[0].points[0, 0] for f in frames] == [1.0, 9.0, 10.0]
    assert [f.observation.time for f in frames] == pytest.approx([0.0, 0.1, 0.2])
    times = [f.observation.time for f in open_recording(tmp_path, rate=2.0)]
    assert times == pytest.approx([0.0, 0.5, 1.0])


def test_recordings_of_other_kinds_in_a_folder_are_named(tmp_path):
    for name in ("2.pcd", "1.pcd"):
        (tmp_path / name).write_bytes(pcd(np.ones((4, 3)), "binary"))
    (tmp_path / "walk.bag").write_bytes(b"x")
    recording = open_recording(tmp_path)
    assert len(list(recording)) == 2
    assert any("ignored: walk.bag" in text for text in recording.warnings)


def test_a_folder_of_kitti_is_found_by_its_sweeps(tmp_path, rng):
    (tmp_path / "velodyne_points" / "data").mkdir(parents=True)
    write(tmp_path / "velodyne_points" / "data" / "0.bin", sweep(rng))
    assert open_recording(tmp_path).frames == 1


def test_what_cannot_be_read_of_a_folder_is_left_out_and_told(tmp_path):
    for k in range(3):
        (tmp_path / f"{k}.pcd").write_bytes(pcd(np.ones((4, 3)), "binary"))
    (tmp_path / "1.pcd").write_bytes(b"")
    recording = open_recording(tmp_path)
    assert [f.observation.time for f in recording] == pytest.approx([0.0, 0.2])
    assert any("1.pcd" in text for text in recording.warnings)
    for k in range(3):
        (tmp_path / f"{k}.pcd").write_bytes(b"")
    with pytest.raises(RecordingError, match="empty"):
        list(open_recording(tmp_path))


WRONG = {
    "picture.bin": b"\x89PNG\r\n\x1a\n" + np.random.default_rng(0).bytes(4000),
    "picture.bag": b"\x89PNG\r\n\x1a\n" + bytes(100),
    "picture.pcd": b"\x89PNG\r\n\x1a\n" + bytes(100),
    "text.bin": b"Nothing that anybody measured, only words. " * 40,
    "text.pcd.bin": b"Nothing that anybody measured, only words. " * 40,
    "text.pcd": b"Nothing that anybody measured, only words.\n" * 40,
    "text.bag": b"words\n",
    "empty.bag": b"",
    "empty.bin": b"",
    "empty.pcd": b"",
    "empty.mcap": b"",
    "short.bin": b"\x00\x00\x80",
    "short.bag": b"#ROSBAG V2.0\n",
    "short.mcap": b"\x89MCAP0\r\n",
    "short.db3": b"SQLite format 3\0",
}


@pytest.mark.parametrize("name", WRONG)
def test_what_is_no_recording_is_refused_by_name(tmp_path, name):
    file = tmp_path / name
    file.write_bytes(WRONG[name])
    with pytest.raises(RecordingError) as error:
        open_recording(file)
    assert str(file) in str(error.value)


def test_nothing_at_all_is_refused(tmp_path):
    with pytest.raises(RecordingError, match="holds no recording"):
        open_recording(tmp_path)
    with pytest.raises(RecordingError, match="No such file"):
        open_recording(tmp_path / "absent.bag")
    write(tmp_path / "a.bin", np.ones((20, 4)))
    for rate in (0.0, -1.0, math.nan):
        with pytest.raises(RecordingError, match="sweeps a second"):
            open_recording(tmp_path, rate=rate)


@pytest.mark.data
def test_the_frame_of_kitti_has_its_pedestrian(data):
    (frame,) = open_recording(data / "lidar" / "kitti_obj_000000.bin")
    assert frame.observation.clouds[0].points.shape == (115384, 3)
    # returns stand where the box is told
    assert frame.labels.position == pytest.approx(np.array([[8.736, -1.868]]), abs=1e-3)
    points = frame.observation.clouds[0].points
    near = np.hypot(*(points[:, :2] - frame.labels.position[0]).T) < 0.6
    assert np.sum(near & (points[:, 2] > -1.5)) > 100


@pytest.mark.data
@pytest.mark.parametrize(("number", "points"), [(0, 119978), (7, 114874)])
def test_the_published_pcd_files(data, number, points):
    (frame,) = open_recording(data / "lidar" / f"udacity_{number:010d}.pcd")
    assert frame.observation.clouds[0].points.shape == (points, 3)
    assert 70.0 < frame.observation.clouds[0].range_max < 120.0


@pytest.mark.data
@pytest.mark.parametrize(("number", "frames", "labels"), [(1, 197, 324), (2, 83, 116)])
def test_labelled_legs_lie_on_returns_of_their_scan(data, number, frames, labels):
    recording = open_recording(data / "lidar" / f"legtracker_positive_{number}_extracted.bag")
    assert recording.frames == frames
    distances, times = [], []
    for frame in recording:
        (scan,) = frame.observation.scans
        angle = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        ends = scan.ranges[:, None] * np.column_stack([np.cos(angle), np.sin(angle)])
        ends = ends[np.isfinite(ends).all(axis=1)]
        times.append(frame.observation.time)
        distances += [np.hypot(*(ends - at).T).min() for at in frame.labels.position]
    assert len(distances) == labels
    # the surface of a leg is as far from its middle as its radius
    assert max(distances) < 0.08
    # the headers' times: the bags were written within half a second
    assert np.median(np.diff(times)) == pytest.approx(0.1332, abs=1e-3)


@pytest.mark.data
def test_the_long_scan_of_a_hall(data):
    recording = open_recording(data / "lidar" / "legtracker_demo_stationary_simple.bag")
    times = [frame.observation.time for frame in recording]
    assert len(times) == recording.frames == 1265
    assert times[-1] - times[0] == pytest.approx(125.99, abs=0.01)
