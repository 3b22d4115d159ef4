"""ROS 1 bags, format 2.0, read from the start as far as they are sound.

rosbags needs the index at the end and refuses a bag without one. Here the records are walked, so
that a bag of a killed recorder, or a cut one, is read like any other. A record is the length of its
header, the header (fields ``name=value``, each with its length), the length of its data, the data.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import BinaryIO, NamedTuple

from cohelm.errors import RecordingError
from cohelm.recordings.bags.compression import unpack_chunk
from cohelm.recordings.bags.records import BagMessage, BrokenRecord

MAGIC = b"#ROSBAG V"

_VERSION = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = (bytes([k]) for k in range(2, 8))
_WORD = struct.Struct("<I")
_MAX_HEADER = 1 << 20

_Connections = dict[int, tuple[str, str]]
"""Topic and type by number."""


def read_ros1(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages in the order of the file.

    Args:
        file: The bag.
        damage: Takes what could not be read: after a damaged chunk reading goes on with the next
            one, after any other damage it ends.

    Raises:
        RecordingError: if it is not a bag of format 2.0, or is encrypted.
    """
    with file.open("rb") as stream:
        version = stream.read(len(_VERSION))
        if version != _VERSION:
            other = f"is a bag of another format, {version[8:12]!r}: convert it with rosbag migrate"
            raise RecordingError(other if version else "is empty", file=file, offset=0)
        connections: _Connections = {}
        try:
            for record in _records(stream, os.fstat(stream.fileno()).st_size):
                if record.kind == _BAG:
                    _check_bag(record, file, damage)
                elif record.kind != _CHUNK:
                    yield from _message(record, connections)
                else:
                    try:
                        yield from _chunk(record, connections)
                    except BrokenRecord as fault:
                        if record.is_whole:  # else the end of the file is reported
                            problem = RecordingError(str(fault), file=file, offset=fault.offset)
                            damage.append(problem)
        except BrokenRecord as fault:
            damage.append(RecordingError(str(fault), file=file, offset=fault.offset))


def read_split(files: Sequence[Path], damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages of the files into which ``rosbag record --split`` divides a recording."""
    for file in files:
        try:
            yield from read_ros1(file, damage)
        except RecordingError as error:
            damage.append(error)


class _Record(NamedTuple):
    head: dict[str, bytes]
    data: bytes
    """Of a record at the end of a cut file, what is left."""
    is_whole: bool
    offset: int
    """Of the record, or of its chunk, in the file."""

    @property
    def kind(self) -> bytes:
        return self.head.get("op", b"")

    def number(self, field: str, at: int = 0) -> int:
        """Number that begins at a byte of a field of the header."""
        return _number(self.head.get(field, b""), at, self.offset)


def _records(stream: BinaryIO, size: int, chunk: int | None = None) -> Iterator[_Record]:
    """Records up to the end of a file, or of the content of a chunk at an offset in the file.

    Raises:
        BrokenRecord: at the first bytes that are no record.
    """
    if chunk is None and stream.tell() == size:
        raise BrokenRecord("the bag ends after its first line", size)
    while (at := stream.tell()) < size:
        offset = at if chunk is None else chunk
        length = _number(stream.read(4), 0, offset)
        head = _fields(stream.read(min(length, _MAX_HEADER)), offset)
        known = {_MESSAGE, _CONNECTION} if chunk is not None else _KINDS
        if length > _MAX_HEADER or head.get("op") not in known:
            raise BrokenRecord(_NO_RECORD, offset)
        length = _number(stream.read(4), 0, offset)
        data = stream.read(min(length, size - stream.tell()))
        record = _Record(head, data, len(data) == length, offset)
        if record.is_whole or record.kind == _CHUNK:
            yield record
        if not record.is_whole:
            raise BrokenRecord("is cut off or damaged within this record", offset)


_KINDS = frozenset({_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION})
_NO_RECORD = "no record of a bag begins here; nothing is read from here on"


def _check_bag(record: _Record, file: Path, damage: list[RecordingError]) -> None:
    if record.head.get("encryptor"):
        raise RecordingError("is encrypted", file=file, offset=record.offset)
    index = int.from_bytes(record.head.get("index_pos", b""), "little")
    if not 0 < index <= file.stat().st_size:
        problem = "the bag lacks its index and perhaps its end; read without (rosbag reindex)"
        damage.append(RecordingError(problem, file=file, offset=record.offset))


def _chunk(record: _Record, connections: _Connections) -> Iterator[BagMessage]:
    """Read the messages of a chunk up to its first fault."""
    size, compression = record.number("size"), record.head.get("compression", b"")
    plain = unpack_chunk(record.data, compression.decode("latin-1"), size, record.offset)
    for inner in _records(io.BytesIO(plain), len(plain), record.offset):
        yield from _message(inner, connections)
    if len(plain) < size:
        raise BrokenRecord("this chunk is damaged, and read up to there", record.offset)


def _message(record: _Record, connections: _Connections) -> Iterator[BagMessage]:
    """The message of a record; a connection is remembered instead."""
    if record.kind == _CONNECTION:
        about = _fields(record.data, record.offset)
        topic = record.head.get("topic", b"").decode("utf-8", "replace")
        type_ = about.get("type", b"").decode("utf-8", "replace")
        connections[record.number("conn")] = topic, type_.replace("/", "/msg/")
    elif record.kind == _MESSAGE:
        if record.number("conn") not in connections:
            raise BrokenRecord("a message belongs to no topic", record.offset)
        topic, type_ = connections[record.number("conn")]
        time = record.number("time") + 1e-9 * record.number("time", 4)
        yield BagMessage(topic, type_, time, record.data, record.offset, "ros1")


def _fields(block: bytes, offset: int) -> dict[str, bytes]:
    found, at = {}, 0
    while at < len(block):
        length = _number(block, at, offset)
        name, equals, value = block[at + 4 : at + 4 + length].partition(b"=")
        if not equals or at + 4 + length > len(block):
            raise BrokenRecord("the header of a record is damaged", offset)
        found[name.decode("latin-1")] = value
        at += 4 + length
    return found


def _number(block: bytes, at: int, offset: int) -> int:
    if at + 4 > len(block):
        raise BrokenRecord("is cut off or damaged within this record", offset)
    return int(_WORD.unpack_from(block, at)[0])
