"""SQLite database of a data folder: settings, riders, audit log, and the index of the rides.

Each call opens the file anew, so that any thread and process may use it. A transaction is on disk,
flushed, or has not happened. What is deleted is overwritten with zeros.
"""

from __future__ import annotations

import sqlite3
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

from cohelm.errors import StoreError
from cohelm.live.sessions.files import make_private_folder, unwritable

FILE = "cohelm.sqlite"
OTHER_VERSION = "another version of cohelm has written it"
_VERSION = 1
_PATIENCE = 10.0
"""Maximum time to wait for another writer, s."""
_PRAGMAS = "PRAGMA secure_delete=ON; PRAGMA synchronous=EXTRA;"
_SCHEMA = f"""
BEGIN IMMEDIATE;
CREATE TABLE IF NOT EXISTS setting (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS rider (id TEXT PRIMARY KEY, record TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS audit (number INTEGER PRIMARY KEY AUTOINCREMENT, entry TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS ride (
    id TEXT PRIMARY KEY, session TEXT NOT NULL, rider TEXT, state TEXT NOT NULL,
    info TEXT NOT NULL, summary TEXT NOT NULL, png BLOB, timeline BLOB
);
PRAGMA user_version={_VERSION};
COMMIT;
"""


class Database:
    """Database in a folder; every method may be called from any thread, and waits for the disk.

    Args:
        folder: Data folder; created, as the file, by the first write.
    """

    def __init__(self, folder: Path) -> None:
        self.folder, self.file = folder, folder / FILE

    def rows(self, query: str, *values: Any) -> list[tuple[Any, ...]]:
        """Return the rows of a query; none if there is no file.

        Raises:
            StoreError: The file cannot be read.
        """
        try:
            if not self.file.is_file():
                return []
            with self._connected("rw") as database:
                return database.execute(query, values).fetchall()
        except (OSError, sqlite3.OperationalError) as cause:  # as of a disk, or a lock
            raise StoreError(f"cannot be read now ({cause})", file=self.file) from None
        except sqlite3.Error as cause:
            raise self.unreadable(str(cause)) from None

    @contextmanager
    def transaction(self) -> Iterator[sqlite3.Connection]:
        """Open the database for changes, which take effect together at the end of the block.

        Raises:
            StoreError: The file cannot be read or written, as on a full disk; nothing has changed.
        """
        make_private_folder(self.folder)
        try:
            self.file.touch(mode=0o600)
            with self._connected("rw") as database, database:
                database.execute("BEGIN IMMEDIATE")
                yield database
        except sqlite3.OperationalError as cause:
            raise StoreError(f"cannot be written ({cause})", file=self.file) from None
        except sqlite3.DatabaseError as cause:
            raise self.unreadable(str(cause)) from None
        except OSError as cause:
            raise unwritable(self.file, cause) from None

    def write(self, statement: str, *values: Any) -> None:
        """Make one change; errors as in :meth:`transaction`."""
        with self.transaction() as database:
            database.execute(statement, values)

    def setting(self, name: str) -> str | None:
        """Return a stored text; None: there is none. Errors as in :meth:`rows`."""
        found = self.rows("SELECT value FROM setting WHERE name = ?", name)
        return found[0][0] if found else None

    def set(self, name: str, value: str) -> None:
        """Store a text; errors as in :meth:`transaction`."""
        self.write("INSERT OR REPLACE INTO setting VALUES (?, ?)", name, value)

    @contextmanager
    def _connected(self, mode: str) -> Iterator[sqlite3.Connection]:
        uri = f"{self.file.absolute().as_uri()}?mode={mode}"
        opened = sqlite3.connect(uri, uri=True, timeout=_PATIENCE, isolation_level=None)
        with closing(opened) as database:
            (version,) = database.execute("PRAGMA user_version").fetchone()
            if version not in {0, _VERSION}:
                raise self.unreadable(OTHER_VERSION)
            database.executescript(_PRAGMAS)
            if version == 0:
                database.executescript(_SCHEMA)
            yield database

    def unreadable(self, why: str) -> StoreError:
        """Return the error for a file, or something in it, that cannot be read."""
        problem = (
            f"cannot be read ({why}); move it away to begin anew: rides are read again, limits "
            "and riders are not"
        )
        return StoreError(problem, file=self.file)
