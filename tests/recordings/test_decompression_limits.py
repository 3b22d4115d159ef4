"""Small files that would fill memory or disk, or take hours, are refused at once."""

import bz2
import os
import sqlite3
import struct
import time

import pytest

from cohelm.errors import RecordingError
from cohelm.recordings import open_recording
from cohelm.recordings.bags.compression import unpack_zstd
from cohelm.recordings.bags.ros1 import MAGIC

from .bags import ROS2, write
from .sound_files import everything

SOON = 2.0
"""s; without bounds each takes from half a minute to for ever."""


def refused(path):
    began = time.perf_counter()
    with pytest.raises(RecordingError) as told:
        list(open_recording(path))
    assert time.perf_counter() - began < SOON
    return str(told.value)


def field(name, data):
    return struct.pack("<I", len(name) + 1 + len(data)) + name + b"=" + data


def chunk(packed, size, kind=b"bz2"):
    head = field(b"op", b"\x05") + field(b"compression", kind)
    head += field(b"size", struct.pack("<I", size))
    return struct.pack("<I", len(head)) + head + struct.pack("<I", len(packed)) + packed


@pytest.mark.parametrize("size", [1 << 30, 1 << 24])
def test_a_chunk_that_grows_beyond_belief(tmp_path, size):
    file = tmp_path / "bomb.bag"
    file.write_bytes(MAGIC + 10 * chunk(bz2.compress(bytes(1 << 24)), size))
    assert "bomb.bag" in refused(file)


def database(file, *statements):
    with sqlite3.connect(file) as made:
        made.execute("CREATE TABLE topics (id INTEGER, name TEXT, type TEXT)")
        made.execute("INSERT INTO topics VALUES (1, '/scan', 'sensor_msgs/msg/LaserScan')")
        for statement in statements:
            made.execute(statement)
    return file


ENDLESS = """CREATE VIEW Messages AS WITH RECURSIVE n(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM n)
    SELECT 1 AS topic_id, x AS timestamp, x'00' AS data FROM n WHERE x < 0"""
HUGE = """CREATE TABLE messages (topic_id INTEGER, timestamp INTEGER,
    data BLOB GENERATED ALWAYS AS (zeroblob(999999999)) VIRTUAL)"""


@pytest.mark.parametrize(
    "statements",
    [(ENDLESS,), (HUGE, "INSERT INTO messages VALUES (1, 1)")],
    ids=["endless view", "huge row"],
)
def test_a_database_that_computes_its_rows(tmp_path, statements):
    assert "bag.db3" in refused(database(tmp_path / "bag.db3", *statements))


def test_metadata_whose_aliases_multiply(tmp_path):
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 10)}]" for k in range(1, 9)]
    lines += ["rosbag2_bagfile_information: {relative_file_paths: *a8, compression_mode: *a8}"]
    (tmp_path / "metadata.yaml").write_text("\n".join(lines))
    assert "no file of messages" in refused(tmp_path)


def test_a_name_too_long_for_any_file_is_missing_and_the_bag_is_read(tmp_path):
    bag = write(tmp_path / "bag", everything(ROS2), "mcap", None)
    about = bag / "metadata.yaml"
    about.write_text(about.read_text().replace("bag.mcap", "b" * 300 + ".mcap"))
    assert len(list(open_recording(bag))) == 6


def test_what_is_no_file(tmp_path):
    fifo = tmp_path / "fifo.bin"
    os.mkfifo(fifo)
    endless = tmp_path / "zero.bin"
    endless.symlink_to("/dev/zero")
    for path in (fifo, endless):
        assert path.name in refused(path)


def zstd(data):
    module = pytest.importorskip("backports.zstd")
    return module.compress(data)


def test_a_compressed_file_that_grows_beyond_belief(tmp_path):
    packed, plain = tmp_path / "x.db3.zstd", tmp_path / "x.db3"
    packed.write_bytes(zstd(bytes(1 << 26)))
    unpack_zstd(packed, plain)
    assert plain.stat().st_size == 1 << 24
    assert "x.db3.zstd" in refused(packed)


@pytest.mark.parametrize("kind", ["mcap", "db3"])
def test_a_compressed_file_alone_is_read_and_named(tmp_path, kind):
    bag = write(tmp_path / "bag", everything(ROS2), kind, None)
    whole = (bag / f"bag.{kind}").read_bytes()
    file = tmp_path / f"alone.{kind}.zstd"
    file.write_bytes(zstd(whole))
    assert len(list(open_recording(file))) == 6
    file.write_bytes(zstd(whole[: len(whole) * 3 // 4]))
    recording = open_recording(file)
    list(recording)
    assert recording.warnings
    assert all(f"alone.{kind}.zstd" in each for each in map(str, recording.warnings))
