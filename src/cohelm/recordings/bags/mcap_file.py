"""MCAP files, read from the start as far as they are sound.

``mcap.stream_reader`` walks the records. Its seeking reader, and rosbags', need the summary at the
end, which a recorder that was killed has not written. Chunks are unpacked here, one by one, so that
a damaged one does not end the reading and none grows beyond what is plausible.
"""

from __future__ import annotations

import dataclasses
import os
import struct
import zlib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import BinaryIO, cast

from mcap.exceptions import EndOfFile, McapError
from mcap.records import Channel, Chunk, McapRecord, Message, Schema, Statistics
from mcap.stream_reader import StreamReader, breakup_chunk

from cohelm.errors import RecordingError
from cohelm.recordings.bags.compression import unpack_chunk
from cohelm.recordings.bags.records import BagMessage, BrokenRecord

MAGIC = b"\x89MCAP0\r\n"

_DAMAGED = (McapError, struct.error, ValueError, OverflowError)
"""Errors of the library on damaged bytes."""


def read_mcap(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages in the order of the file.

    Args:
        file: The MCAP file.
        damage: Takes what could not be read: after a damaged chunk reading goes on with the next
            one, after any other damage it ends.
    """
    topics = _Topics()
    with file.open("rb") as stream:
        size = os.fstat(stream.fileno()).st_size
        exact = cast(BinaryIO, _ExactReads(stream, size))
        reader = StreamReader(exact, emit_chunks=True, record_size_limit=size)
        offset = 0
        try:
            for record in reader.records:
                try:
                    if isinstance(record, Statistics) and not damage:
                        topics.check_count(record, offset)
                    yield from topics.messages(_unpacked(record, offset), offset)
                except BrokenRecord as fault:
                    damage.append(RecordingError(str(fault), file=file, offset=offset))
                    if not isinstance(record, Chunk):
                        return
                offset = stream.tell()
        except EndOfFile:
            text = "the file is cut off here: its end is missing"
            damage.append(RecordingError(text, file=file, offset=offset))
        except _DAMAGED as error:
            text = f"is damaged, and read up to here: {error}"
            damage.append(RecordingError(text, file=file, offset=offset))


class _Topics:
    """Schemas and channels so far, and the number of messages."""

    def __init__(self) -> None:
        self._types: dict[int, str] = {}
        self._channels: dict[int, tuple[str, str, str]] = {}
        """Topic, type and encoding."""
        self._count = 0

    def messages(self, records: Iterable[McapRecord], offset: int) -> Iterator[BagMessage]:
        """Messages among records that lie at ``offset`` in the file."""
        for record in records:
            if isinstance(record, Schema):
                # ROS 1 has no "msg" in the names of types.
                parts = record.name.split("/")
                name = "/msg/".join(parts) if len(parts) == 2 else record.name
                self._types[record.id] = name
            elif isinstance(record, Channel):
                type_ = self._types.get(record.schema_id, "")
                encoding = record.message_encoding or "cdr"
                self._channels[record.id] = record.topic, type_, encoding
            elif isinstance(record, Message):
                if record.channel_id not in self._channels:
                    raise BrokenRecord("a message belongs to no topic", offset)
                self._count += 1
                topic, type_, encoding = self._channels[record.channel_id]
                time = 1e-9 * record.log_time
                yield BagMessage(topic, type_, time, record.data, offset, encoding)

    def check_count(self, summary: Statistics, offset: int) -> None:
        """Compare the number of messages with that of the summary."""
        if summary.message_count != self._count:
            text = f"{summary.message_count} messages are declared, {self._count} were found"
            raise BrokenRecord(text, offset)


def _unpacked(record: McapRecord, offset: int) -> list[McapRecord]:
    """The records of a chunk, or the record itself."""
    if not isinstance(record, Chunk):
        return [record]
    size = record.uncompressed_size
    plain = unpack_chunk(record.data, record.compression, size, offset)
    # A checksum of 0: the writer computed none.
    if len(plain) < size or record.uncompressed_crc not in {0, zlib.crc32(plain)}:
        raise BrokenRecord("this chunk is damaged; it is not read", offset)
    try:
        return breakup_chunk(dataclasses.replace(record, compression="", data=plain))
    except _DAMAGED:
        raise BrokenRecord("this chunk is damaged; it is not read", offset) from None


class _ExactReads:
    """Stream whose reads give all bytes or fail; the library takes a short read for a whole one.

    Args:
        stream: The file.
        size: Its size, bytes; a damaged length reserves no more.
    """

    def __init__(self, stream: BinaryIO, size: int) -> None:
        self._stream, self._size = stream, size

    def read(self, length: int) -> bytes:
        data = self._stream.read(min(length, self._size))
        if len(data) < length:
            raise EndOfFile
        return data
