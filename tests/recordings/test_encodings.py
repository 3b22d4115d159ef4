"""Messages in other encodings and compressions: they are read, or the reason is given."""

import importlib
import json
import sqlite3

import pytest
from mcap.writer import Writer

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording

from .bags import ROS1, ROS2, walk, write

SHORT = "sensor_msgs/LaserScan"
LONG = "sensor_msgs/msg/LaserScan"
RANGES = pytest.approx([2.0, 2.1, 2.2, 2.3, 2.4])


def middle(recording):
    return [frame.observation.scans[0].ranges[2] for frame in recording]


def mcap(file, *channels):
    """An MCAP file of channels (topic, type, schema's encoding, encoding, messages)."""
    with file.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        for topic, type_, schema, encoding, messages in channels:
            number = writer.register_schema(type_, schema, b"")
            channel = writer.register_channel(topic, encoding, number)
            for k, data in enumerate(messages):
                time = 100_000_000_000 + 100_000_000 * k
                writer.add_message(channel, time, data, time)
        writer.finish()
    return file


def scans(author):
    return [author.bytes(message) for _, _, message in walk(author)]


@pytest.mark.parametrize(
    ("author", "type_", "schema", "encoding"),
    [
        (ROS1, SHORT, "ros1msg", "ros1"),
        (ROS1, LONG, "ros1msg", "ros1"),
        (ROS2, LONG, "ros2msg", "cdr"),
        (ROS2, LONG, "ros2idl", "cdr"),
    ],
)
def test_messages_of_ros_1_and_2_in_mcap_are_read(tmp_path, author, type_, schema, encoding):
    file = mcap(tmp_path / "a.mcap", ("/scan", type_, schema, encoding, scans(author)))
    assert middle(open_recording(file)) == RANGES


def test_poses_of_ros_1_in_mcap_are_read(tmp_path):
    moved = ROS1.transforms((50.0, "odom", "laser", (3.0, 4.0, 0.0), (0.0, 0.0, 0.5)))
    file = mcap(
        tmp_path / "a.mcap",
        ("/tf", "tf2_msgs/TFMessage", "ros1msg", "ros1", [ROS1.bytes(moved)]),
        ("/scan", SHORT, "ros1msg", "ros1", scans(ROS1)),
    )
    assert next(iter(open_recording(file))).observation.pose == pytest.approx([3.0, 4.0, 0.5])


@pytest.mark.parametrize("encoding", ["json", "protobuf", "cbor", "flatbuffer"])
@pytest.mark.parametrize("type_", [SHORT, LONG, "foxglove.LaserScan"])
def test_an_encoding_that_is_not_read_is_named(tmp_path, encoding, type_):
    other = "/other", type_, "jsonschema", encoding, [json.dumps({"ranges": [1.0]}).encode()] * 7
    with pytest.raises(RecordingError, match=f"/other.*{encoding}"):
        list(open_recording(mcap(tmp_path / "a.mcap", other)))
    both = mcap(tmp_path / "b.mcap", ("/scan", LONG, "ros2msg", "cdr", scans(ROS2)), other)
    recording = open_recording(both)
    assert middle(recording) == RANGES
    (text,) = [text for text in recording.warnings if "/other" in text]
    assert encoding in text


def test_scans_of_a_type_that_is_not_read_are_named(tmp_path):
    file = mcap(
        tmp_path / "a.mcap",
        ("/scan", LONG, "ros2msg", "cdr", scans(ROS2)),
        ("/echoes", "sensor_msgs/msg/MultiEchoLaserScan", "ros2msg", "cdr", [b"\0\1\0\0"]),
        ("/image", "sensor_msgs/msg/Image", "ros2msg", "cdr", [b"\0\1\0\0"]),
    )
    texts = " ".join(open_recording(file).warnings)
    assert "/echoes (MultiEchoLaserScan)" in texts
    assert "/image" not in texts


@pytest.mark.parametrize("kind", ["mcap", "db3"])
@pytest.mark.parametrize("compression", ["zstd", "lz4", "bz2"])
def test_compressed_messages_are_read(tmp_path, kind, compression):
    bag = write(tmp_path / "bag", walk(ROS2), kind, "MESSAGE")
    repack(bag, kind, compression)
    assert middle(open_recording(bag)) == RANGES


def repack(bag, kind, compression):
    """Compress the messages otherwise."""
    module = {"zstd": "backports.zstd", "lz4": "lz4.frame", "bz2": "bz2"}[compression]
    compress = importlib.import_module(module).compress
    messages = [compress(data) for data in scans(ROS2)]
    file = bag / f"bag.{kind}"
    if kind == "mcap":
        mcap(file, ("/scan", LONG, "ros2msg", "cdr", messages))
        return
    with sqlite3.connect(file) as database:
        for k, data in enumerate(messages):
            database.execute("UPDATE messages SET data = ? WHERE id = ?", (data, k + 1))


def test_a_database_in_another_encoding_names_it(tmp_path):
    bag = write(tmp_path / "bag", walk(ROS2), "db3")
    with sqlite3.connect(bag / "bag.db3") as database:
        database.execute("UPDATE topics SET serialization_format = 'protobuf'")
    with pytest.raises(RecordingError, match="protobuf"):
        list(open_recording(bag))


def test_every_topic_of_which_nothing_is_read_has_its_reason(tmp_path):
    file = mcap(
        tmp_path / "a.mcap",
        ("/scan", LONG, "ros2msg", "cdr", [b"\0\1\0\0" + bytes([k]) * 9 for k in range(30)]),
        ("/points", "sensor_msgs/msg/PointCloud2", "ros2msg", "json", [b"{}"] * 20),
    )
    with pytest.raises(RecordingError, match=r"/scan, first at .*not a LaserScan") as error:
        list(open_recording(file))
    assert "/points, first at" in str(error.value)
    assert "json" in str(error.value)
    assert "\n" not in str(error.value)


def test_messages_that_are_skipped_are_told_once_for_each_topic_and_reason(tmp_path):
    messages = [data for whole in scans(ROS2) for data in (whole, whole[:13])]
    recording = open_recording(
        mcap(tmp_path / "a.mcap", ("/scan", LONG, "ros2msg", "cdr", messages))
    )
    for _ in range(2):
        assert middle(recording) == RANGES
        (text,) = [text for text in recording.warnings if "/scan" in text]
        assert "/scan, first at 100.100 s: skipped: not a LaserScan" in text


def test_that_warnings_are_left_out_is_said(tmp_path):
    messages = [(f"/scan_{k}", 100.0, ROS1.scan(50.0, [1.0], f"laser_{k}")) for k in range(150)]
    recording = open_recording(write(tmp_path / "a.bag", messages))
    assert len(list(recording)) == 150
    assert len(recording.warnings) == 101  # no pose of any of them
    assert "further warnings are left out" in recording.warnings[-1]
