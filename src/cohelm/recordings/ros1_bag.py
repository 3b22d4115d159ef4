"""ROS 1 bags, format 2.0: the records one after the other, as far as they go.

The index at a bag's end is not used, so a bag that lacks it, because its recorder was killed or its
end is lost, is read as any other. A record is the length of its header, the header (fields
``name=value``, each with its length), the length of its data, and the data.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.records import BrokenRecord, Message, Reach, unpack_chunk

MAGIC = b"#ROSBAG V"

_VERSION = b"#ROSBAG V2.0\n"
_MESSAGE, _BAG, _INDEX, _CHUNK, _CHUNK_INFO, _CONNECTION = (bytes([k]) for k in range(2, 8))
_WORD = struct.Struct("<I")
_LARGEST_HEADER = 1 << 20

_Connections = dict[int, tuple[str, str]]
"""Topic and type by number."""


def read_ros1(file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    """The messages in the order of the file.

    Args:
        file: the bag.
        damage: takes what could not be read: a damaged chunk is left at its fault and the next one
            read; behind other damage nothing is found again.

    Raises:
        RecordingError: if it is no bag of format 2.0, or encrypted.
    """
    with file.open("rb") as stream:
        version = stream.read(len(_VERSION))
        if version != _VERSION:
            raise RecordingError(
                f"is a bag of another format, {version[8:12]!r}: run rosbag migrate on it",
                file=file,
                offset=0,
            )
        reach = Reach(stream, os.fstat(stream.fileno()).st_size)
        try:
            yield from _records(reach, file, damage)
        except BrokenRecord as fault:
            damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))


def _records(reach: Reach, file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    connections: _Connections = {}
    if reach.stream.tell() == reach.length:
        raise BrokenRecord("the bag ends after its first line", reach.length)
    while reach.begin():
        head = _header(reach)
        (length,) = reach.unpack(_WORD)
        end = reach.stream.tell() + length
        kind = head.get("op")
        if kind == _CHUNK:
            data = reach.take(min(length, reach.length - reach.stream.tell()))
            try:
                yield from _chunk(head, data, connections, reach.at)
            except BrokenRecord as fault:
                if end <= reach.length:
                    damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))
        elif kind in {_MESSAGE, _CONNECTION}:
            yield from _message(head, reach.take(length), connections, reach)
        elif kind == _BAG:
            _check_bag(head, reach, file, damage)
        elif kind not in {_INDEX, _CHUNK_INFO}:
            raise reach.broken("no record of a bag begins here; nothing is read from here on")
        if end > reach.length:
            raise reach.broken("the bag is cut off within this record")
        reach.stream.seek(end)


def _check_bag(
    head: dict[str, bytes], reach: Reach, file: Path, damage: list[RecordingError]
) -> None:
    if head.get("encryptor"):
        raise RecordingError("is encrypted", file=file, offset=reach.at)
    index = int.from_bytes(head.get("index_pos", b""), "little")
    if not 0 < index <= reach.length:
        problem = "the bag lacks its index and perhaps its end; read without (rosbag reindex)"
        damage.append(RecordingError(problem, file=file, offset=reach.at))


def _chunk(
    head: dict[str, bytes], data: bytes, connections: _Connections, offset: int
) -> Iterator[Message]:
    """The messages of a chunk up to its first fault."""
    size = _number(head.get("size", b""), 0, offset)
    plain = unpack_chunk(data, head.get("compression", b"").decode("latin-1"), size, offset)
    reach = Reach(io.BytesIO(plain), len(plain), offset)
    while reach.begin():
        inner = _header(reach)
        (length,) = reach.unpack(_WORD)
        yield from _message(inner, reach.take(length), connections, reach)
    if len(plain) < size:
        raise BrokenRecord("this chunk is damaged, and read up to there", offset)


def _message(
    head: dict[str, bytes], data: bytes, connections: _Connections, reach: Reach
) -> Iterator[Message]:
    """The message that a record holds; nothing where it holds a connection, which is noted."""
    kind = head.get("op")
    offset = reach.offset
    if kind is None:
        raise reach.broken("a record does not say what it is")
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
        yield Message(*connections[number], time, data, offset)
    else:
        raise reach.broken("a message belongs to no topic")


def _header(reach: Reach) -> dict[str, bytes]:
    (length,) = reach.unpack(_WORD)
    if length > _LARGEST_HEADER:
        raise reach.broken("no record of a bag begins here; nothing is read from here on")
    return _fields(reach.take(length), reach.offset)


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
        raise BrokenRecord("a record lacks what it must say", offset)
    return int(_WORD.unpack_from(block, at)[0])
