"""SQLite files of ROS 2 bags: the messages in the order in which they were written."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.records import Message

MAGIC = b"SQLite format 3\0"

_LARGEST_ROW = 1 << 28
"""Bytes: a message is smaller."""
_PATIENCE = 10_000_000
"""Steps of SQLite's machine that one row may take: a stored one takes a dozen."""
_KIND = "SELECT type FROM sqlite_master WHERE lower(name) = ?"
_TOPICS = "SELECT id, name, type FROM topics"
_MESSAGES = "SELECT topic_id, timestamp, data FROM messages"


def read_sqlite(file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    """The messages up to the first that cannot be read.

    Args:
        file: the database.
        damage: takes the fault that ends the reading.
    """
    where = f"{file.absolute().as_uri()}?mode=ro&immutable=1"
    try:
        with closing(sqlite3.connect(where, uri=True)) as database:
            # else a file that lacks its end is refused as a whole
            database.execute("PRAGMA writable_schema=ON")
            database.execute("PRAGMA trusted_schema=OFF")
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _LARGEST_ROW)
            late = _Patience()
            database.set_progress_handler(late, _PATIENCE)
            database.text_factory = lambda text: text.decode("utf-8", "replace")
            _check_tables(database)
            topics = {number: (name, type_) for number, name, type_ in database.execute(_TOPICS)}
            for number, time, data in database.execute(_MESSAGES):
                late.rows += 1
                known = topics.get(number)
                if known is None or not isinstance(time, int) or not isinstance(data, bytes):
                    raise sqlite3.DatabaseError("a row makes no sense")
                yield Message(str(known[0]), str(known[1]), 1e-9 * time, data, None)
    except sqlite3.Error as error:
        damage.append(
            RecordingError(f"the database cannot be read, or not any further: {error}", file=file)
        )


class _Patience:
    """Ends a query, by being true, if no row came since it was last asked."""

    def __init__(self) -> None:
        self.rows = 0
        self._before = -1

    def __call__(self) -> bool:
        waits, self._before = self.rows == self._before, self.rows
        return waits


def _check_tables(database: sqlite3.Connection) -> None:
    """A view computes its rows, and may do so for ever."""
    for name in ("topics", "messages"):
        kinds = [kind for (kind,) in database.execute(_KIND, (name,))]
        if kinds and "table" not in kinds:
            raise sqlite3.DatabaseError(f"{name!r} is no table")
