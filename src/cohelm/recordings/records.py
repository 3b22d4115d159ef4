"""What the records of ROS 1 bags and of MCAP files have in common."""

from __future__ import annotations

import struct
from typing import Any, BinaryIO, NamedTuple

from cohelm.recordings.compression import LARGEST, believed, decompress


class Message(NamedTuple):
    """A message as it lies in a bag."""

    topic: str
    type: str
    """As ``sensor_msgs/msg/LaserScan``."""
    time: float
    """When it was received, s."""
    data: bytes
    offset: int | None
    """Of the record, or of the chunk that holds it, bytes from the start of the file; None where
    the file has no order of its own."""


class BrokenRecord(Exception):
    """Bytes that are no record.

    Args:
        problem: what is wrong.
        offset: of the record in the file.
    """

    def __init__(self, problem: str, offset: int) -> None:
        self.problem = problem
        self.offset = offset
        super().__init__(problem)


class Reach:
    """A stream of known length, of which never more is read than there is.

    Args:
        stream: at its start.
        length: bytes.
        offset: what a fault is said to be at; None: the place in the stream itself.
    """

    def __init__(self, stream: BinaryIO, length: int, offset: int | None = None) -> None:
        self.stream = stream
        self.length = length
        self.at = 0
        """Where the record begins that is being read."""
        self._offset = offset

    def begin(self) -> bool:
        """Note that a record begins here; False at the end."""
        self.at = self.stream.tell()
        return self.at < self.length

    def take(self, length: int) -> bytes:
        """The next ``length`` bytes.

        Raises:
            BrokenRecord: if there are not as many.
        """
        if length > self.length - self.stream.tell():
            raise self.broken("is cut off or damaged within this record")
        return self.stream.read(length)

    def unpack(self, layout: struct.Struct) -> tuple[Any, ...]:
        """The next numbers, laid out so."""
        return layout.unpack(self.take(layout.size))

    def skip(self, length: int) -> None:
        """Leave out the next ``length`` bytes, or what there is of them."""
        self.stream.seek(min(self.stream.tell() + length, self.length))

    @property
    def offset(self) -> int:
        """Of the record that is being read, or of the chunk that holds it, in the file."""
        return self.at if self._offset is None else self._offset

    def broken(self, problem: str) -> BrokenRecord:
        """That problem, with the place of the record."""
        return BrokenRecord(problem, self.offset)


def unpack_chunk(data: bytes, kind: str, size: int, offset: int) -> bytes:
    """The records of a chunk, or the whole bytes of them before a fault.

    Raises:
        BrokenRecord: if the chunk cannot be believed, or its compression is unknown.
    """
    if size > LARGEST or (kind not in {"", "none"} and size > believed(len(data))):
        problem = f"a chunk of {size} bytes, packed into {len(data)}, is not believed"
        raise BrokenRecord(problem, offset)
    try:
        return decompress(data, kind, size)
    except ValueError as error:
        raise BrokenRecord(f"a chunk {error}", offset) from None
