"""MCAP files of ROS 2: the records one after the other, as far as they go.

The summary at a file's end is not used, so a file that lacks it, because its recorder was killed or
its end is lost, is read as any other. A record is a byte that says what it is, its length in eight,
and its content.
"""

from __future__ import annotations

import io
import os
import struct
from collections.abc import Iterator
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.records import BrokenRecord, Message, Reach, unpack_chunk

MAGIC = b"\x89MCAP0\r\n"

_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK = 3, 4, 5, 6
_LAST_KIND = 15
_HEAD = struct.Struct("<BQ")
_CHUNK_HEAD = struct.Struct("<QQQI")
_MESSAGE_HEAD = struct.Struct("<HIQQ")
_TWO = struct.Struct("<HH")
_SHORT = struct.Struct("<H")
_WORD = struct.Struct("<I")
_LONG = struct.Struct("<Q")


class _Topics:
    """What the schemas and channels that were met so far say."""

    def __init__(self) -> None:
        self.types: dict[int, str] = {}
        self.channels: dict[int, tuple[str, str]] = {}


def read_mcap(file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    """The messages in the order of the file.

    Args:
        file: the MCAP file.
        damage: takes what could not be read: a damaged chunk is left at its fault and the next one
            read; behind other damage nothing is found again.
    """
    with file.open("rb") as stream:
        reach = Reach(stream, os.fstat(stream.fileno()).st_size)
        stream.seek(len(MAGIC))
        try:
            yield from _records(reach, file, damage)
        except BrokenRecord as fault:
            damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))


def _records(reach: Reach, file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    topics = _Topics()
    while reach.begin():
        if reach.length - reach.at == len(MAGIC):
            if reach.take(len(MAGIC)) == MAGIC:
                return
            raise reach.broken("the file does not end as it must")
        kind, length = reach.unpack(_HEAD)
        end = reach.stream.tell() + length
        if not 0 < kind <= _LAST_KIND:
            raise reach.broken("no record begins here; nothing is read from here on")
        if kind == _CHUNK:
            there = reach.take(min(length, reach.length - reach.stream.tell()))
            try:
                yield from _chunk(there, topics, reach.at)
            except BrokenRecord as fault:
                if end <= reach.length:
                    damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))
        elif kind in {_SCHEMA, _CHANNEL, _MESSAGE}:
            yield from _record(kind, reach.take(length), topics, reach.at)
        if end > reach.length:
            raise reach.broken("the file is cut off within this record")
        reach.stream.seek(end)
    raise reach.broken("the file is cut off here: it lacks its end")


def _chunk(data: bytes, topics: _Topics, offset: int) -> Iterator[Message]:
    """The messages of a chunk up to its first fault."""
    reach = Reach(io.BytesIO(data), len(data), offset)
    _, _, size, _ = reach.unpack(_CHUNK_HEAD)
    compression = _text(reach)
    reach.unpack(_LONG)
    plain = unpack_chunk(data[reach.stream.tell() :], compression, size, offset)
    inside = Reach(io.BytesIO(plain), len(plain), offset)
    while inside.begin():
        kind, length = inside.unpack(_HEAD)
        if kind == 0:
            raise inside.broken("no record begins here; the chunk is read up to there")
        yield from _record(kind, inside.take(length), topics, offset)
    if len(plain) < size:
        raise BrokenRecord("this chunk is damaged, and read up to there", offset)


def _record(kind: int, data: bytes, topics: _Topics, offset: int) -> Iterator[Message]:
    """The message that a record holds; nothing where it says what others hold, which is noted."""
    reach = Reach(io.BytesIO(data), len(data), offset)
    if kind == _SCHEMA:
        (number,) = reach.unpack(_SHORT)
        topics.types[number] = _text(reach)
    elif kind == _CHANNEL:
        number, schema = reach.unpack(_TWO)
        topics.channels[number] = _text(reach), topics.types.get(schema, "")
    elif kind == _MESSAGE:
        number, _, time, _ = reach.unpack(_MESSAGE_HEAD)
        if number not in topics.channels:
            raise BrokenRecord("a message belongs to no topic", offset)
        yield Message(*topics.channels[number], 1e-9 * time, data[_MESSAGE_HEAD.size :], offset)


def _text(reach: Reach) -> str:
    (length,) = reach.unpack(_WORD)
    return reach.take(length).decode("utf-8", "replace")
