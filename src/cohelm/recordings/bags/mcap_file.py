"""MCAP files, read from the start as far as they are sound.

The ``mcap`` library decodes the records. Its readers are not used: they need the summary at the
end, stop at the first damaged length, and decompress chunks whole. Here the records are walked by
their lengths, so that a damaged chunk loses only its own rest.
"""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Message, Schema, Statistics

from cohelm.errors import RecordingError
from cohelm.recordings.bags.records import BagMessage, BrokenRecord, RecordStream, unpack_chunk

MAGIC = b"\x89MCAP0\r\n"

_LAST_OPCODE = 15
_DAMAGED = (McapError, struct.error, ValueError, OverflowError)
"""Errors of the library on damaged bytes."""
_HEAD = struct.Struct("<BQ")


@dataclass(slots=True)
class _Met:
    """Schemas and channels met so far, by id, and the number of messages."""

    types: dict[int, str] = field(default_factory=dict)
    topics: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    """Topic, type and encoding."""
    messages: int = 0


def read_mcap(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages in the order of the file.

    Args:
        file: The MCAP file.
        damage: Takes what could not be read: after a damaged chunk reading goes on with the next
            one, after any other damage it ends.
    """
    with file.open("rb") as stream:
        records = RecordStream(stream, os.fstat(stream.fileno()).st_size)
        stream.seek(len(MAGIC))
        try:
            yield from _records(records, file, damage)
        except BrokenRecord as fault:
            damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))


def _records(
    records: RecordStream, file: Path, damage: list[RecordingError]
) -> Iterator[BagMessage]:
    met = _Met()
    while records.begin():
        if records.length - records.at == len(MAGIC):
            if records.take(len(MAGIC)) == MAGIC:
                return
            raise records.broken("the file does not end with the MCAP magic")
        opcode, length = records.unpack(_HEAD)
        end = records.stream.tell() + length
        if not 0 < opcode <= _LAST_OPCODE:
            raise records.broken("no record begins here; nothing is read from here on")
        if opcode == Opcode.CHUNK:
            there = records.take(min(length, records.length - records.stream.tell()))
            try:
                yield from _chunk(there, met, records.at)
            except BrokenRecord as fault:
                if end <= records.length:
                    damage.append(RecordingError(fault.problem, file=file, offset=fault.offset))
        elif opcode in {Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE}:
            yield from _record(opcode, records.take(length), met, records.at)
        elif opcode == Opcode.STATISTICS and not damage:
            _check_count(records.take(length), met.messages, records)
        if end > records.length:
            raise records.broken("the file is cut off within this record")
        records.stream.seek(end)
    raise records.broken("the file is cut off here: its end is missing")


def _chunk(data: bytes, met: _Met, offset: int) -> Iterator[BagMessage]:
    """Read the messages of a chunk up to its first fault."""
    try:
        chunk = Chunk.read(ReadDataStream(io.BytesIO(data)))
    except _DAMAGED:
        raise BrokenRecord("the head of this chunk is damaged", offset) from None
    size = chunk.uncompressed_size
    plain = unpack_chunk(chunk.data, chunk.compression, size, offset)
    # 0: the writer computed none. A chunk that is cut has no checksum either.
    checked = chunk.uncompressed_crc != 0 and len(plain) == size
    if checked and zlib.crc32(plain) != chunk.uncompressed_crc:
        raise BrokenRecord("the checksum of this chunk is wrong; it is not read", offset)
    inside = RecordStream.of(plain, offset)
    while inside.begin():
        opcode, length = inside.unpack(_HEAD)
        if opcode == 0:
            raise inside.broken("no record begins here; the chunk is read up to there")
        yield from _record(opcode, inside.take(length), met, offset)
    if len(plain) < size:
        raise BrokenRecord("this chunk is damaged, and read up to there", offset)


def _record(opcode: int, data: bytes, met: _Met, offset: int) -> Iterator[BagMessage]:
    """The message of a record; schemas and channels are remembered instead."""
    stream = ReadDataStream(io.BytesIO(data))
    try:
        if opcode == Opcode.SCHEMA:
            schema = Schema.read(stream)
            # ROS 1 has no "msg" in the names of types.
            parts = schema.name.split("/")
            met.types[schema.id] = "/msg/".join(parts) if len(parts) == 2 else schema.name
        elif opcode == Opcode.CHANNEL:
            channel = Channel.read(stream)
            type_ = met.types.get(channel.schema_id, "")
            met.topics[channel.id] = channel.topic, type_, channel.message_encoding or "cdr"
        elif opcode == Opcode.MESSAGE:
            message = Message.read(stream, len(data))
            topic, type_, encoding = met.topics[message.channel_id]
            met.messages += 1
            time = 1e-9 * message.log_time
            yield BagMessage(topic, type_, time, message.data, offset, encoding)
    except KeyError:
        raise BrokenRecord("a message belongs to no topic", offset) from None
    except _DAMAGED:
        raise BrokenRecord("is cut off or damaged within this record", offset) from None


def _check_count(data: bytes, count: int, records: RecordStream) -> None:
    """Compare the number of messages with that of the summary."""
    try:
        declared = Statistics.read(ReadDataStream(io.BytesIO(data))).message_count
    except _DAMAGED:
        raise records.broken("the statistics are damaged") from None
    if declared != count:
        raise records.broken(f"{declared} messages are declared, {count} were found")
