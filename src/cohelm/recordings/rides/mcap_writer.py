"""MCAP file that grows during a ride and can be read up to its last second at any time."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from cohelm.errors import RecordingError
from cohelm.recordings.rides import ros_messages as ros

FLUSH = 1.0
"""Interval of chunks, s of the ride; a killed recorder loses at most this."""


class McapWriter:
    """Writer of ROS 2 messages in chunks, each written when it is full or a second has passed.

    Args:
        file: File to write; it must not exist, its folder must.

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
        """Write a message at a time, s, that never decreases.

        Raises:
            RecordingError: if the disk is full.
        """
        self._now = max(self._now, ros.nanoseconds(time))
        channel = self._channels.get(topic)
        if channel is None:
            channel = self._channel(topic, message.__msgtype__)
        self._call(self._writer.add_message, channel, self._now, ros.serialised(message), self._now)
        if self._now - self._flushed >= FLUSH * 1e9:
            self.flush()

    def flush(self) -> None:
        """Write the messages since the last chunk.

        Raises:
            RecordingError: if the disk is full.
        """
        self._flushed = self._now
        self._call(self._writer.flush)

    def note(self, name: str, facts: Mapping[str, str]) -> None:
        """Write metadata, which viewers list.

        Raises:
            RecordingError: if the disk is full.
        """
        self._call(self._writer.add_metadata, name, dict(facts))

    def attach(self, name: str, kind: str, data: bytes) -> None:
        """Attach a file; ``kind`` is its media type.

        Raises:
            RecordingError: if the disk is full.
        """
        self._call(self._writer.add_attachment, 0, self._now, name, kind, data)

    def close(self) -> None:
        """Write the rest and the index.

        Raises:
            RecordingError: if the disk is full; what was written before can be read.
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


@contextlib.contextmanager
def delayed_interrupt() -> Iterator[None]:
    """Delay Ctrl-C until the end of a block, so that it cannot tear a write apart.

    Only Python's own handler is delayed, and only in the main thread.

    Raises:
        KeyboardInterrupt: at the end, if there was one.
    """
    main = threading.current_thread() is threading.main_thread()
    before = signal.getsignal(signal.SIGINT)
    if not main or before is not signal.default_int_handler:
        yield
        return
    signals: list[int] = []
    signal.signal(signal.SIGINT, lambda number, frame: signals.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if signals:
        raise KeyboardInterrupt
