"""Records of bag files: bounded reads from a stream, and chunks that may be damaged."""

from __future__ import annotations

import io
import struct
from typing import Any, BinaryIO, NamedTuple

from cohelm.recordings.bags.compression import MAX_CHUNK, decompress, max_unpacked


class BagMessage(NamedTuple):
    """A message as stored in a bag."""

    topic: str
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    time: float
    """Time of reception, s."""
    data: bytes
    offset: int | None
    """Offset of the record, or of its chunk, in the file, bytes; None where there is none."""
    encoding: str = "cdr"
    """``cdr``, ``ros1``, or one that is not read."""


class BrokenRecord(Exception):
    """Bytes that are not a valid record.

    Args:
        problem: Description.
        offset: Of the record in the file, bytes.
    """

    def __init__(self, problem: str, offset: int) -> None:
        self.problem = problem
        self.offset = offset
        super().__init__(problem)


class RecordStream:
    """A stream of known length that is never read beyond its end.

    Args:
        stream: At its start.
        length: Bytes.
        offset: Reported with every fault; None: the position of the current record.
    """

    def __init__(self, stream: BinaryIO, length: int, offset: int | None = None) -> None:
        self.stream = stream
        self.length = length
        self.at = 0
        """Position where the current record begins."""
        self._offset = offset

    @classmethod
    def of(cls, data: bytes, offset: int) -> RecordStream:
        """Stream over the content of a chunk that lies at ``offset`` in the file."""
        return cls(io.BytesIO(data), len(data), offset)

    def begin(self) -> bool:
        """Begin a record at the current position; False at the end."""
        self.at = self.stream.tell()
        return self.at < self.length

    def take(self, length: int) -> bytes:
        """Read the next ``length`` bytes.

        Raises:
            BrokenRecord: if fewer are left.
        """
        if length > self.length - self.stream.tell():
            raise self.broken("is cut off or damaged within this record")
        return self.stream.read(length)

    def unpack(self, layout: struct.Struct) -> tuple[Any, ...]:
        """Read the next numbers in a layout."""
        return layout.unpack(self.take(layout.size))

    def skip(self, length: int) -> None:
        """Skip the next ``length`` bytes, or those that are left."""
        self.stream.seek(min(self.stream.tell() + length, self.length))

    @property
    def offset(self) -> int:
        """Offset of the current record, or of its chunk, in the file."""
        return self.at if self._offset is None else self._offset

    def broken(self, problem: str) -> BrokenRecord:
        """Error with the offset of the current record."""
        return BrokenRecord(problem, self.offset)


def unpack_chunk(data: bytes, kind: str, size: int, offset: int) -> bytes:
    """Decompress the records of a chunk, or the bytes before a fault.

    Raises:
        BrokenRecord: if the claimed size is implausible, or the compression is unknown.
    """
    if size > MAX_CHUNK or (kind not in {"", "none"} and size > max_unpacked(len(data))):
        problem = f"a chunk claims {size} bytes from {len(data)}: implausible, not read"
        raise BrokenRecord(problem, offset)
    try:
        return decompress(data, kind, size)
    except ValueError as error:
        raise BrokenRecord(f"a chunk {error}", offset) from None
