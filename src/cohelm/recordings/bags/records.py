"""Messages of bags as stored, and the error of a damaged record."""

from __future__ import annotations

from typing import NamedTuple


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
        super().__init__(problem)
        self.offset = offset
