"""Bags of ROS 1 and ROS 2, written by rosbags."""

import math
import sqlite3
from contextlib import closing

import numpy as np
import pytest

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, walk, write

KINDS = [
    ("bag", None),
    ("bag", "BZ2"),
    ("bag", "LZ4"),
    ("mcap", None),
    ("mcap", "STORAGE"),
    ("mcap", "MESSAGE"),
    ("db3", None),
    ("db3", "MESSAGE"),
    ("db3", "FILE"),
]
AUTHORS = {"bag": ROS1, "mcap": ROS2, "db3": ROS2}


@pytest.fixture(params=KINDS, ids=lambda kind: "-".join(map(str, kind)))
def bag(request, tmp_path):
    kind, compression = request.param
    path = tmp_path / ("walk.bag" if kind == "bag" else "walk")
    return write(path, walk(AUTHORS[kind]), kind, compression)


def test_every_kind_and_compression_gives_the_same_frames(bag):
    recording = open_recording(bag)
    assert recording.frames == 5
    for _ in range(2):  # as often as one likes
        frames = list(recording)
        assert len(frames) == 5
        for k, frame in enumerate(frames):
            (scan,) = frame.observation.scans
            # the header's time, not that of reception
            assert frame.observation.time == scan.time == pytest.approx(50.0 + 0.1 * k)
            assert scan.ranges == pytest.approx([1.0, 1.0, 2.0 + 0.1 * k, 1.0, 1.0])
            assert scan.angle_min == -0.5
            assert frame.labels is None


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_a_file_of_messages_alone_is_a_recording(tmp_path, kind):
    write(tmp_path / "walk", walk(ROS2), kind)
    file = tmp_path / "walk" / f"walk.{kind}"
    assert len(list(open_recording(file))) == 5
    # recognised by its content
    renamed = file.rename(tmp_path / "walk.dat")
    assert len(list(open_recording(renamed))) == 5


def test_ranges_are_returns_dropouts_or_nothing(tmp_path):
    given = [np.nan, 0.0, 0.05, -np.inf, -1.0, 0.1, 3.0, 10.0, 11.0, np.inf]
    file = write(tmp_path / "a.bag", [("/scan", 1.0, ROS1.scan(1.0, given))])
    (frame,) = open_recording(file)
    ranges = frame.observation.scans[0].ranges
    # range_min 0.1, range_max 10
    assert np.isnan(ranges[:5]).all()
    assert ranges[5:7] == pytest.approx([0.1, 3.0])
    assert np.isposinf(ranges[7:]).all()


def test_a_scan_of_nothing_but_nan_is_a_frame(tmp_path):
    file = write(tmp_path / "a.bag", [("/scan", 1.0, ROS1.scan(1.0, [np.nan] * 5))])
    assert len(list(open_recording(file))) == 1


def test_a_scan_that_turns_clockwise_is_turned_round(tmp_path):
    scan = ROS1.scan(1.0, [1, 2, 3, 4, 5], angle_min=0.5, angle_increment=-0.25)
    (frame,) = open_recording(write(tmp_path / "a.bag", [("/scan", 1.0, scan)]))
    (scan,) = frame.observation.scans
    assert (scan.angle_min, scan.angle_increment) == (-0.5, 0.25)
    assert scan.ranges.tolist() == [5, 4, 3, 2, 1]


@pytest.mark.parametrize(
    ("first", "step", "count", "last", "says"),
    [
        (-1.5, 0.01, 301, 1.5, ""),
        (1.5, -0.01, 301, -1.5, ""),
        (-1.5, 0.01, 301, 1.51, ""),  # drivers that add the step behind the last beam
        (-math.pi, math.tau / 720, 720, math.pi, ""),
        (-math.pi, -math.tau / 720, 720, math.pi, ""),  # all round, clockwise
        (0.0, math.tau / 360, 360, 6.266, ""),
        (-1.5, -0.01, 301, 1.5, "end at -4.50 rad, angle_max is 1.50"),
        (-1.5, 0.01, 151, 1.5, "angle_max is 1.50"),
        (-1.5, 0.01, 301, math.nan, "end at 1.50 rad, angle_max is nan"),
        (-1.5, 0.01, 301, math.inf, "end at 1.50 rad, angle_max is inf"),
    ],
)
def test_a_scan_whose_angles_contradict_each_other_is_said(
    tmp_path, first, step, count, last, says
):
    scan = ROS2.scan(
        1.0,
        np.ones(count),
        angle_min=first,
        angle_increment=step,
        angle_max=last,
        frame="base_link",
    )
    recording = open_recording(write(tmp_path / "a", [("/scan", 1.0, scan)], "mcap"))
    assert len(list(recording)) == 1
    told = [text for text in recording.warnings if "angle_max" in text]
    assert len(told) == bool(says)
    assert all(says in text for text in told)


@pytest.mark.parametrize("author", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_cloud_of_any_layout_gives_its_points(tmp_path, author, order):
    # z first as int16, y as float64, x as float32; 5 bytes of padding, rows padded by 7
    layout = np.dtype(
        {
            "names": ["z", "y", "x"],
            "formats": [f"{order}i2", f"{order}f8", f"{order}f4"],
            "offsets": [1, 4, 14],
            "itemsize": 23,
        }
    )
    points = np.zeros((2, 3), layout)
    points["x"] = [[1.5, np.nan, 3.0], [4.0, 5.0, 0.0]]
    points["y"] = [[-1.0, 0.0, 2.0], [0.25, 7.0, 0.0]]
    points["z"] = [[1, 0, -2], [3, 4, 0]]
    data = b"".join(row.tobytes() + b"\x55" * 7 for row in points)
    cloud = author.cloud(
        2.0, data, [("z", 1, 3), ("y", 4, 8), ("x", 14, 7)],
        height=2, width=3, point_step=23, row_step=76, is_bigendian=order == ">", is_dense=False,
    )  # fmt: skip
    kind = "bag" if author is ROS1 else "mcap"
    (frame,) = open_recording(write(tmp_path / "a.bag", [("/points", 2.0, cloud)], kind))
    (cloud,) = frame.observation.clouds
    expected = [[1.5, -1, 1], [np.nan, 0, 0], [3, 2, -2], [4, 0.25, 3], [5, 7, 4], [np.nan] * 3]
    np.testing.assert_array_equal(cloud.points, np.array(expected, np.float32))
    assert cloud.points.dtype == np.float32
    # √(5² + 7² + 4²)
    assert cloud.range_max == pytest.approx(np.sqrt(90.0))
    assert np.isnan(cloud.mount[2])


def test_a_cloud_that_does_not_fit_its_data_is_left_out_and_told(tmp_path):
    good = ROS1.plain_cloud(1.0, [[1, 2, 3]])
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)]
    bad = [
        ROS1.cloud(2.0, bytes(12), fields, width=10**9, point_step=12, row_step=12),
        ROS1.cloud(2.0, bytes(12), fields, width=1, height=2**31, point_step=12),
        ROS1.cloud(2.0, bytes(12), fields[:2], width=1, point_step=12),
        ROS1.cloud(2.0, bytes(12), [*fields[:2], ("z", 10, 7)], width=1, point_step=12),
        ROS1.cloud(2.0, bytes(12), [*fields[:2], ("z", 8, 99)], width=1, point_step=12),
    ]
    for k, cloud in enumerate(bad):
        messages = [("/points", 1.0, good), ("/points", 2.0, cloud)]
        recording = open_recording(write(tmp_path / f"{k}.bag", messages))
        assert len(list(recording)) == 1
        assert any("skipped" in text for text in recording.warnings)
        with pytest.raises(RecordingError, match="can be read"):
            list(open_recording(write(tmp_path / f"{k}_alone.bag", messages[1:])))


def layered(pad=0, **changed):
    """A cloud of 2 × 3 points of 16 bytes in rows with padding, and its points."""
    points = np.arange(1.0, 19.0, dtype=np.float32).reshape(2, 3, 3)
    data = np.zeros((2, 48 + pad), np.uint8)
    for k in range(3):
        data[:, 16 * k : 16 * k + 12] = points[:, k].copy().view(np.uint8)
    about = {"height": 2, "width": 3, "point_step": 16, "row_step": 48 + pad} | changed
    if about["height"] == 1:
        about["width"] = 6
    fields = [("x", 0, 7), ("y", 4, 7), ("z", 8, 7)]
    return data.tobytes(), fields, about, points.reshape(6, 3)


@pytest.mark.parametrize("row", [0, 3, 6, 16, 47, 49, 96, 2**32 - 1])
@pytest.mark.parametrize("height", [1, 2])
@pytest.mark.parametrize("author", [ROS1, ROS2], ids=["ROS 1", "ROS 2"])
def test_a_wrong_row_step_of_a_cloud_without_padding_does_no_harm(tmp_path, author, height, row):
    data, fields, about, points = layered(height=height, row_step=row)
    cloud = author.cloud(2.0, data, fields, **about)
    kind = "bag" if author is ROS1 else "mcap"
    (frame,) = open_recording(write(tmp_path / "a.bag", [("/points", 2.0, cloud)], kind))
    np.testing.assert_array_equal(frame.observation.clouds[0].points, points)


def test_a_padded_cloud_is_read_by_its_row_step_and_a_wrong_one_is_refused(tmp_path):
    data, fields, about, points = layered(pad=16)
    file = write(tmp_path / "a.bag", [("/points", 2.0, ROS1.cloud(2.0, data, fields, **about))])
    (frame,) = open_recording(file)
    np.testing.assert_array_equal(frame.observation.clouds[0].points, points)
    for size, row, needed in [(128, 0, 96), (128, 128, 176), (127, 48, 96), (95, 48, 96)]:
        cloud = ROS1.cloud(2.0, data[:size], fields, **(about | {"row_step": row}))
        file = write(tmp_path / f"{size}_{row}.bag", [("/points", 2.0, cloud)])
        with pytest.raises(RecordingError, match=f"needs {needed} bytes and has {size}"):
            list(open_recording(file))


def test_an_empty_cloud_is_a_frame(tmp_path):
    cloud = ROS2.plain_cloud(1.0, np.empty((0, 3)))
    (frame,) = open_recording(write(tmp_path / "a", [("/points", 1.0, cloud)], "mcap"))
    assert frame.observation.clouds[0].points.shape == (0, 3)
    assert frame.observation.clouds[0].range_max == 0.0


def test_without_a_stamp_the_time_of_reception_counts(tmp_path):
    messages = [("/scan", 7.25 + k, ROS1.scan(0.0, [1.0])) for k in range(2)]
    frames = list(open_recording(write(tmp_path / "a.bag", messages)))
    assert [frame.observation.time for frame in frames] == pytest.approx([7.25, 8.25])


def test_several_sensors_come_in_the_order_of_time_or_one_is_chosen(tmp_path):
    # the second sensor's readings are received 0.15 s late
    messages = sorted(
        [("/front", 10.0 + 0.1 * k, ROS1.scan(10.0 + 0.1 * k, [1.0])) for k in range(8)]
        + [("/rear", 10.2 + 0.1 * k, ROS1.scan(10.05 + 0.1 * k, [2.0])) for k in range(8)],
        key=lambda message: message[1],
    )
    file = write(tmp_path / "a.bag", messages)
    times = [frame.observation.time for frame in open_recording(file)]
    assert len(times) == 16
    assert times == sorted(times)
    rear = open_recording(file, topic="/rear")
    assert rear.frames == 8
    assert {frame.observation.scans[0].ranges[0] for frame in rear} == {2.0}
    with pytest.raises(RecordingError, match="/front"):
        open_recording(file, topic="/top")


def test_labels_belong_to_the_scan_that_follows(tmp_path):
    messages = [
        ("/leg_cluster_positions", 1.0, ROS1.poses(0.0, [(1.0, 0.5), (2.0, -0.5)])),
        ("/scan", 1.0, ROS1.scan(50.0, [1.0])),
        ("/scan", 1.1, ROS1.scan(50.1, [1.0])),
        ("/leg_cluster_positions", 1.2, ROS1.poses(0.0, [])),
        ("/scan", 1.2, ROS1.scan(50.2, [1.0])),
    ]
    recording = open_recording(write(tmp_path / "a.bag", messages))
    first, second, third = recording
    assert first.labels.position.tolist() == [[1.0, 0.5], [2.0, -0.5]]
    assert first.labels.id.tolist() == [-1, -1]
    assert first.labels.time == 50.0
    assert second.labels is None
    # somebody looked, and saw nobody
    assert third.labels.position.shape == (0, 2)


def test_a_bag_of_other_things_says_what_it_holds(tmp_path):
    file = write(tmp_path / "a.bag", [("/places", 1.0, ROS1.poses(1.0, []))])
    with pytest.raises(RecordingError, match=r"/places \(PoseArray\)"):
        open_recording(file)
    with pytest.raises(RecordingError, match="no messages"):
        open_recording(write(tmp_path / "b.bag", []))


def test_small_disorder_is_sorted_and_a_clock_that_runs_back_is_passed_on(tmp_path):
    times = [10.0, 10.2, 10.1, 10.3, 4.0, 4.1, 4.2]
    messages = [("/scan", 20.0 + k, ROS1.scan(t, [1.0])) for k, t in enumerate(times)]
    frames = open_recording(write(tmp_path / "a.bag", messages))
    got = [frame.observation.time for frame in frames]
    assert got == pytest.approx([10.0, 10.1, 10.2, 10.3, 4.0, 4.1, 4.2])


@pytest.mark.parametrize("kind", ["bag", "mcap", "db3"])
def test_a_bag_that_is_cut_is_read_up_to_there_or_refused_in_a_line(tmp_path, kind):
    scan = AUTHORS[kind].scan(1.0, np.full(2000, 2.0))
    messages = [("/scan", 1.0 + 0.1 * k, scan) for k in range(400)]
    path = write(tmp_path / ("a.bag" if kind == "bag" else "a"), messages, kind)
    file = path if kind == "bag" else path / f"a.{kind}"
    data = file.read_bytes()
    file.write_bytes(data[: len(data) // 2])
    if kind == "mcap":
        recording = open_recording(file)
        assert 100 < len(list(recording)) == recording.frames < 220
        (text,) = [text for text in recording.warnings if "cut off" in text]
        assert text.startswith(f"{file} at byte ")
        return
    with pytest.raises(RecordingError) as error:  # both are read by an index that is missing
        open_recording(file)
    assert str(error.value).startswith(f"{file}: ")
    assert len(str(error.value).splitlines()) == 1


def test_a_bag_of_a_killed_recorder_says_that_it_lacks_its_index(tmp_path):
    data = write(tmp_path / "a.bag", walk(ROS1)).read_bytes()
    at = data.index(b"index_pos=") + len(b"index_pos=")
    (tmp_path / "a.bag").write_bytes(data[:at] + bytes(8) + data[at + 8 :])
    with pytest.raises(RecordingError, match=r"a\.bag: .* reindex"):
        open_recording(tmp_path / "a.bag")


@pytest.mark.parametrize("checkpoint", [True, False])
def test_messages_in_a_write_ahead_log_are_read(tmp_path, checkpoint):
    file = write(tmp_path / "bag", walk(ROS2), "db3") / "bag.db3"
    with closing(sqlite3.connect(file, isolation_level=None)) as recorder:
        recorder.execute("PRAGMA journal_mode=WAL")
        recorder.execute("UPDATE messages SET data = data")
        if checkpoint:
            recorder.execute("PRAGMA wal_checkpoint(TRUNCATE)")
        assert len(list(open_recording(file))) == 5
