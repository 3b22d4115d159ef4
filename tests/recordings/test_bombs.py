"""Small files that would fill memory or disk, or take hours, are refused at once."""

import bz2
import os
import sqlite3
import time

import lz4.frame
import pytest
from mcap.writer import Writer

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording

from .bags import ROS1, walk, write

SOON = 2.0
"""s; without bounds each takes from half a minute to for ever."""
BOMB = bytes(1 << 28)


def refused(path):
    began = time.perf_counter()
    with pytest.raises(RecordingError) as told:
        list(open_recording(path))
    assert time.perf_counter() - began < SOON
    assert path.name in str(told.value)
    return str(told.value)


def test_a_chunk_of_a_ros_1_bag_that_grows_beyond_belief(tmp_path):
    data = write(tmp_path / "a.bag", walk(ROS1), "bag", "BZ2").read_bytes()
    at, bomb = data.index(b"BZh"), bz2.compress(BOMB, 9)
    packed = bytearray(data)
    packed[at : at + len(bomb)] = bomb[: len(data) - at]
    (tmp_path / "a.bag").write_bytes(packed)
    refused(tmp_path / "a.bag")


@pytest.mark.parametrize("compress", [bz2.compress, lz4.frame.compress])
def test_a_message_that_grows_beyond_belief(tmp_path, compress):
    with (tmp_path / "a.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        schema = writer.register_schema("sensor_msgs/msg/LaserScan", "ros2msg", b"")
        channel = writer.register_channel("/scan", "cdr", schema)
        writer.add_message(channel, 0, compress(BOMB), 0)
        writer.finish()
    assert "grow beyond" in refused(tmp_path / "a.mcap")


def test_a_compressed_file_that_grows_beyond_belief(tmp_path):
    zstd = pytest.importorskip("backports.zstd")
    file = tmp_path / "x.db3.zstd"
    file.write_bytes(zstd.compress(BOMB))
    assert "implausible" in refused(file)


TOPICS = "CREATE TABLE topics (id INTEGER, name TEXT, type TEXT, serialization_format TEXT)"
SCANS = "INSERT INTO topics VALUES (1, '/scan', 'sensor_msgs/msg/LaserScan', 'cdr')"
ENDLESS = """CREATE VIEW Messages AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)
    SELECT 1 AS topic_id, x AS timestamp, x'00' AS data FROM n WHERE x < 0"""
HUGE = """CREATE TABLE messages (topic_id INTEGER, timestamp INTEGER,
    data BLOB GENERATED ALWAYS AS (zeroblob(999999999)) VIRTUAL)"""


@pytest.mark.parametrize("statements", [(ENDLESS,), (HUGE, "INSERT INTO messages VALUES (1, 1)")])
def test_a_database_that_computes_its_rows(tmp_path, statements):
    with sqlite3.connect(tmp_path / "bag.db3") as made:
        for statement in (TOPICS, SCANS, *statements):
            made.execute(statement)
    refused(tmp_path / "bag.db3")


def test_what_is_no_file(tmp_path):
    os.mkfifo(tmp_path / "fifo.bin")
    (tmp_path / "zero.bin").symlink_to("/dev/zero")
    for name in ("fifo.bin", "zero.bin"):
        refused(tmp_path / name)
