"""An MCAP file that grows while a ride goes on, and is whole up to its last second at any time."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cohelm.errors import RecordingError
from cohelm.recordings import ros_writing as ros

FLUSH = 1.0
"""Between two chunks, s of the ride: what a recorder that is killed may lose."""


class RideFile:
    """Messages of ROS 2 in chunks, each written to disk when it is full or a second is over.

    Args:
        file: to write; its folder must exist, and it must not.

    Raises:
        RecordingError: if it exists or cannot be written.
    """

    def __init__(self, file: Path) -> None:
        from mcap.writer import CompressionType, Writer  # noqa: PLC0415  # only to record

        self._file = file
        try:
            self._stream = file.open("xb")
        except FileExistsError:
            problem = "exists already; remove it or name another file"
            raise RecordingError(problem, file=file) from None
        except OSError as cause:
            raise self._unwritable(cause) from None
        self._writer = Writer(self._stream, compression=CompressionType.ZSTD)
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._flushed = 0
        self._now = 0
        try:
            self._call(self._writer.start, profile="ros2", library="cohelm")
        except RecordingError:
            self._stream.close()
            raise

    def write(self, topic: str, message: Any, time: float) -> None:
        """One message, at a time that never runs back, s.

        Raises:
            RecordingError: if the disk takes no more.
        """
        self._now = max(self._now, ros.nanoseconds(time))
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channel(topic, message.__msgtype__)
        self._call(self._writer.add_message, channel, self._now, ros.serialised(message), self._now)
        if self._now - self._flushed >= FLUSH * 1e9:
            self.flush()

    def flush(self) -> None:
        """Write what has come since the last chunk.

        Raises:
            RecordingError: if the disk takes no more.
        """
        self._flushed = self._now
        self._call(self._writer.flush)

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Facts for people, which viewers list.

        Raises:
            RecordingError: if the disk takes no more.
        """
        self._call(self._writer.add_metadata, name, dict(facts))

    def attach(self, name: str, kind: str, data: bytes) -> None:
        """A file within the file; ``kind`` is its media type.

        Raises:
            RecordingError: if the disk takes no more.
        """
        self._call(self._writer.add_attachment, 0, self._now, name, kind, data)

    def close(self) -> None:
        """Write what is left and the index.

        Raises:
            RecordingError: if the disk takes no more; what was written before can be read.
        """
        try:
            self._call(self._writer.finish)
        finally:
            with contextlib.suppress(OSError):
                self._stream.close()

    def _channel(self, topic: str, type_: str) -> int:
        if type_ not in self._schemas:
            self._schemas[type_] = self._call(
                self._writer.register_schema, type_, "ros2msg", ros.schema(type_)
            )
        self._channels[topic] = self._call(
            self._writer.register_channel, topic, "cdr", self._schemas[type_]
        )
        return self._channels[topic]

    def _call(self, write: Any, *what: Any, **named: Any) -> Any:
        try:
            return write(*what, **named)
        except OSError as cause:
            raise self._unwritable(cause) from None

    def _unwritable(self, cause: OSError) -> RecordingError:
        return RecordingError(f"cannot be written ({cause.strerror or cause})", file=self._file)
