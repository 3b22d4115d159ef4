"""Messages of bag files, in the order of the file: ROS 1 bags, MCAP, and SQLite of ROS 2.

The libraries read a ROS 1 bag by its index (``rosbags``), MCAP from its start and without an index
(``mcap``), a database with its write-ahead log (``sqlite3``). A file is read up to its first
damage. ROS 2's ``metadata.yaml`` is not needed: it repeats what the files hold.
"""

from __future__ import annotations

import importlib
import os
import shutil
import sqlite3
import struct
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.exceptions import EndOfFile
from mcap.records import Channel, Chunk, McapRecord, Message, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from cohelm.errors import RecordingError
from cohelm.recordings.api import natural_order

MCAP = b"\x89MCAP0\r\n"
_ROS1, _SQLITE, _ZSTD = b"#ROSBAG V", b"SQLite format 3\0", b"\x28\xb5\x2f\xfd"
_PACKED = (".mcap.zstd", ".db3.zstd")
_ZSTD_MODULE = "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd"
_DECOMPRESSORS = {
    _ZSTD: (_ZSTD_MODULE, "ZstdDecompressor"),
    b"\x04\x22\x4d\x18": ("lz4.frame", "LZ4FrameDecompressor"),
    b"BZh": ("bz2", "BZ2Decompressor"),
}
"""By the first bytes of compressed data; a message in CDR begins with 0. rosbags needs them too."""

_RATIO = 100
"""Maximum plausible compression of sensor data: scans reach 10, black images 100."""
_ALLOWED = 1 << 24
"""Bytes to which any data may grow, also small ones."""
_LARGEST = 1 << 28
"""Maximum size of a record, chunk or row, bytes; usual chunks have about a million."""
_STEP = 1 << 20

_TABLES = "SELECT name FROM sqlite_master WHERE type = 'table'"
_TOPICS = "SELECT id, name, type, serialization_format FROM topics"
_MESSAGES = "SELECT topic_id, timestamp, data FROM messages"


class BagMessage(NamedTuple):
    """A message as stored in a bag."""

    topic: str
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    time: float
    """Time of reception, s."""
    data: bytes
    encoding: str = "cdr"
    """``cdr``, ``ros1``, or one that is not read."""


def is_bag(file: Path, start: bytes) -> bool:
    """Check by its first bytes that a file holds messages."""
    packed = start.startswith(_ZSTD) and file.name.endswith(_PACKED)
    return packed or start.startswith((_ROS1, MCAP, _SQLITE))


def message_files(folder: Path) -> list[Path]:
    """Files of a ROS 2 bag by number; of a file and its compressed copy the plain one."""
    endings = (".mcap", ".db3", *_PACKED)
    files = [f for f in folder.iterdir() if f.name.endswith(endings) and f.is_file()]
    there = {file.name for file in files}
    kept = [f for f in files if f.suffix != ".zstd" or f.stem not in there]
    return sorted(kept, key=natural_order)


def read_bag(files: Sequence[Path], damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages of files one after the other, each up to its first damage.

    Args:
        files: Parts of one recording.
        damage: Takes the damage of each file.
    """
    for file in files:
        try:
            yield from _read(file)
        except RecordingError as error:  # of this file, or of a copy that is not compressed
            damage.append(RecordingError(error.problem, file=file, offset=error.offset))
        except OSError as error:
            damage.append(RecordingError(error.strerror or str(error), file=file))
        except Exception as error:  # each library has its own errors; all mean damaged data
            damage.append(RecordingError(_ended(error), file=file))


def _read(file: Path) -> Iterator[BagMessage]:
    with file.open("rb") as stream:
        start = stream.read(len(_SQLITE))
        stream.seek(0)
        if start.startswith(MCAP):
            yield from _read_mcap(file, stream)
        elif start.startswith(_ROS1):
            yield from _read_ros1(file)
        elif start.startswith(_SQLITE):
            yield from _read_sqlite(file)
        elif is_bag(file, start):
            yield from _read_packed(file, stream)
        else:
            problem = "is neither MCAP, SQLite nor a ROS 1 bag" if start else "is empty"
            raise RecordingError(problem, file=file, offset=0)


def _read_ros1(file: Path) -> Iterator[BagMessage]:
    from rosbags.rosbag1 import Reader, ReaderError  # noqa: PLC0415  # only for such bags

    try:
        with Reader(file) as reader:
            for position, chunk in reader.chunks.items():  # rosbags decompresses without a limit
                reader.chunks[position] = chunk._replace(decompressor=_unpacked)
            for connection, time, data in reader.messages():
                yield BagMessage(connection.topic, connection.msgtype, 1e-9 * time, data, "ros1")
    except ReaderError as error:
        raise RecordingError(str(error), file=file) from None


def _read_mcap(file: Path, stream: BinaryIO) -> Iterator[BagMessage]:
    """Read the messages; checksums are compared where the writer has computed them."""
    reader = StreamReader(stream, emit_chunks=True, validate_crcs=True, record_size_limit=_LARGEST)
    types: dict[int, str] = {}
    topics: dict[int, tuple[str, str, str]] = {}
    offset = 0
    try:
        for record in reader.records:
            for each in _records(record) if isinstance(record, Chunk) else [record]:
                if isinstance(each, Schema):
                    # ROS 1 has no "msg" in the names of types.
                    package, _, name = each.name.rpartition("/")
                    ros1 = package and "/" not in package
                    types[each.id] = f"{package}/msg/{name}" if ros1 else each.name
                elif isinstance(each, Channel):
                    encoding = each.message_encoding or "cdr"
                    topics[each.id] = each.topic, types.get(each.schema_id, ""), encoding
                elif isinstance(each, Message):
                    topic, type_, encoding = topics[each.channel_id]
                    data = _unpacked(each.data) if encoding == "cdr" else each.data
                    yield BagMessage(topic, type_, 1e-9 * each.log_time, data, encoding)
            offset = stream.tell()
    except (EndOfFile, struct.error):
        raise RecordingError("is cut off here", file=file, offset=offset) from None
    except Exception as error:  # as above
        raise RecordingError(_ended(error), file=file, offset=offset) from None


def _records(chunk: Chunk) -> list[McapRecord]:
    plain = _unpacked(chunk.data)
    if len(plain) != chunk.uncompressed_size:
        raise EndOfFile
    return breakup_chunk(replace(chunk, data=plain, compression=""), validate_crc=True)


def _read_sqlite(file: Path) -> Iterator[BagMessage]:
    file = file.resolve()  # the log lies beside the database, not beside a link to it
    log = file.with_name(f"{file.name}-wal")
    # Without a log a database is also read in a folder where SQLite may create nothing.
    more = "" if log.is_file() and log.stat().st_size else "&immutable=1"
    with closing(sqlite3.connect(f"{file.as_uri()}?mode=ro{more}", uri=True)) as database:
        database.execute("PRAGMA trusted_schema=OFF")
        database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LARGEST)
        tables = {name for (name,) in database.execute(_TABLES)}
        if not {"topics", "messages"} <= tables:  # a view computes its rows, perhaps without end
            raise RecordingError("has no tables of topics and messages", file=file)
        topics = {number: tuple(map(str, about)) for number, *about in database.execute(_TOPICS)}
        for number, time, data in database.execute(_MESSAGES):
            topic, type_, encoding = topics[number]
            yield BagMessage(topic, type_, 1e-9 * time, _unpacked(data), encoding)


def _read_packed(file: Path, stream: BinaryIO) -> Iterator[BagMessage]:
    """Read a compressed file, of whose content at most a plausible size is unpacked."""
    size = max(_ALLOWED, _RATIO * os.fstat(stream.fileno()).st_size)
    with tempfile.TemporaryDirectory() as folder:
        free = shutil.disk_usage(folder).free // 2
        plain = Path(folder) / file.stem
        with plain.open("wb") as out:
            content = importlib.import_module(_ZSTD_MODULE).open(stream)
            for _ in range(min(size, free) // _STEP):
                out.write(content.read(_STEP))
            if content.read(1):
                raise RecordingError("unpacks to an implausible size", file=file)
        yield from _read(plain)


def _unpacked(data: bytes) -> bytes:
    """Decompress a message or chunk; other data are returned as they are.

    Raises:
        ValueError: if they are cut off, or grow beyond a plausible size: a decompression bomb.
    """
    found = next((names for start, names in _DECOMPRESSORS.items() if data.startswith(start)), None)
    if found is None:
        return data
    stream = getattr(importlib.import_module(found[0]), found[1])()
    most = min(_LARGEST, max(_ALLOWED, _RATIO * len(data)))
    plain: bytes = stream.decompress(data, most)
    if not stream.eof:
        raise ValueError(f"{len(data)} compressed bytes are cut off, or grow beyond {most}")
    return plain


def _ended(error: Exception) -> str:
    text = " ".join(str(error).split())[:200] or type(error).__name__
    return f"cannot be read from here on: {text}"
