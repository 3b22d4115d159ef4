"""ROS 1 bags, format 2.0, read from the start as far as they are sound.

rosbags needs the index at the end and refuses a bag without one. Here the records are walked, so
that a bag of a killed recorder, or a cut one, is read like any other. A record is the length of its
header, the header (fields ``name=value``, each with its length), the length of its data, the data.
"""

from __future__ import annotations

import os
import struct
from collections.abc import Iterator, Sequence
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.bags.records import BagMessage, BrokenRecord, RecordStream, unpack_chunk

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
        records = RecordStream(stream, os.fstat(stream.fileno()).st_size)
        try:
            yield from _records(records, file, damage)
        except BrokenRecord as fault:
            damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))


def read_split(files: Sequence[Path], damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages of the files into which ``rosbag record --split`` divides a recording."""
    for file in files:
        try:
            yield from read_ros1(file, damage)
        except RecordingError as error:
            damage.append(error)


def _records(
    records: RecordStream, file: Path, damage: list[RecordingError]
) -> Iterator[BagMessage]:
    connections: _Connections = {}
    if records.stream.tell() == records.length:
        raise BrokenRecord("the bag ends after its first line", records.length)
    while records.begin():
        head = _header(records)
        (length,) = records.unpack(_WORD)
        end = records.stream.tell() + length
        kind = head.get("op")
        if kind == _CHUNK:
            data = records.take(min(length, records.length - records.stream.tell()))
            try:
                yield from _chunk(head, data, connections, records.at)
            except BrokenRecord as fault:
                if end <= records.length:
                    damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))
        elif kind in {_MESSAGE, _CONNECTION}:
            yield from _message(head, records.take(length), connections, records)
        elif kind == _BAG:
            _check_bag(head, records, file, damage)
        elif kind not in {_INDEX, _CHUNK_INFO}:
            raise records.broken("no record of a bag begins here; nothing is read from here on")
        if end > records.length:
            raise records.broken("the bag is cut off within this record")
        records.stream.seek(end)


def _check_bag(
    head: dict[str, bytes], records: RecordStream, file: Path, damage: list[RecordingError]
) -> None:
    if head.get("encryptor"):
        raise RecordingError("is encrypted", file=file, offset=records.at)
    index = int.from_bytes(head.get("index_pos", b""), "little")
    if not 0 < index <= records.length:
        problem = "the bag lacks its index and perhaps its end; read without (rosbag reindex)"
        damage.append(RecordingError(problem, file=file, offset=records.at))


def _chunk(
    head: dict[str, bytes], data: bytes, connections: _Connections, offset: int
) -> Iterator[BagMessage]:
    """Read the messages of a chunk up to its first fault."""
    size = _number(head.get("size", b""), 0, offset)
    plain = unpack_chunk(data, head.get("compression", b"").decode("latin-1"), size, offset)
    records = RecordStream.of(plain, offset)
    while records.begin():
        inner = _header(records)
        (length,) = records.unpack(_WORD)
        yield from _message(inner, records.take(length), connections, records)
    if len(plain) < size:
        raise BrokenRecord("this chunk is damaged, and read up to there", offset)


def _message(
    head: dict[str, bytes], data: bytes, connections: _Connections, records: RecordStream
) -> Iterator[BagMessage]:
    """The message of a record; a connection is remembered instead."""
    kind = head.get("op")
    offset = records.offset
    if kind is None:
        raise records.broken("a record has no opcode")
    if kind not in {_CONNECTION, _MESSAGE}:
        return
    number = _number(head.get("conn", b""), 0, offset)
    if kind == _CONNECTION:
        about = _fields(data, offset)
        topic = head.get("topic", b"").decode("utf-8", "replace")
        type_ = about.get("type", b"").decode("utf-8", "replace")
        connections[number] = topic, type_.replace("/", "/msg/")
    elif number in connections:
        when = head.get("time", b"")
        time = _number(when, 0, offset) + 1e-9 * _number(when, 4, offset)
        yield BagMessage(*connections[number], time, data, offset, "ros1")
    else:
        raise records.broken("a message belongs to no topic")


def _header(records: RecordStream) -> dict[str, bytes]:
    (length,) = records.unpack(_WORD)
    if length > _MAX_HEADER:
        raise records.broken("no record of a bag begins here; nothing is read from here on")
    return _fields(records.take(length), records.offset)


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
        raise BrokenRecord("a record lacks a field", offset)
    return int(_WORD.unpack_from(block, at)[0])
