"""ROS 2 bags: a folder with a metadata.yaml and files of messages, or such a file alone.

The files are MCAP or SQLite. Metadata that are missing or damaged are reported and not needed.
"""

from __future__ import annotations

import os
import sqlite3
import tempfile
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import yaml

from cohelm.errors import RecordingError
from cohelm.recordings.api import natural_order
from cohelm.recordings.bags.compression import (
    MAX_CHUNK,
    ZSTD_MAGIC,
    decompress,
    max_unpacked,
    unpack_zstd,
)
from cohelm.recordings.bags.mcap_file import MAGIC as MCAP
from cohelm.recordings.bags.mcap_file import read_mcap
from cohelm.recordings.bags.records import BagMessage

SQLITE = b"SQLite format 3\0"
METADATA = "metadata.yaml"
PACKED = (".mcap.zstd", ".db3.zstd")
"""Endings of compressed files of messages."""
MESSAGE_FILES = ("*.mcap", "*.db3", *(f"*{ending}" for ending in PACKED))
"""Names of files of messages."""

_MAX_METADATA = 1 << 21
_YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # safe, and ten times as fast
_MAX_ROW = 1 << 28
"""Maximum size of a row, bytes."""
_MAX_STEPS = 10_000_000
"""Maximum steps of SQLite's virtual machine per row; a stored row takes a dozen."""
_KIND = "SELECT type FROM sqlite_master WHERE lower(name) = ?"
_TOPICS = "SELECT id, name, type FROM topics"
_MESSAGES = "SELECT topic_id, timestamp, data FROM messages"


def read_ros2(path: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages, file by file.

    Args:
        path: The folder, or a file of messages.
        damage: Takes what could not be read.

    Raises:
        RecordingError: if there is no file of messages, or its compression is unknown.
    """
    if path.is_file():
        yield from _file(path, damage)
        return
    about = _metadata(path / METADATA, damage)
    by_message = _text(about, "compression_mode").lower() == "message"
    kind = _text(about, "compression_format")
    for file in _files(path, about, damage):
        for message in _file(file, damage):
            yield message._replace(data=_plain(message, kind, file)) if by_message else message


def _file(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    with file.open("rb") as stream:
        start = stream.read(max(len(MCAP), len(SQLITE)))
    if start.startswith(MCAP):
        yield from read_mcap(file, damage)
    elif start.startswith(SQLITE):
        yield from read_sqlite(file, damage)
    elif start.startswith(ZSTD_MAGIC) and file.suffix == ".zstd":
        yield from _packed(file, damage)
    else:
        problem = "is empty" if not start else "is neither MCAP nor SQLite"
        damage.append(RecordingError(problem, file=file, offset=0))


def _packed(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read a compressed file; faults name this file, with offsets in its content."""
    inside: list[RecordingError] = []
    try:
        with tempfile.TemporaryDirectory() as folder:
            plain = Path(folder) / file.stem
            unpack_zstd(file, plain)
            if plain.suffix == ".zstd":
                raise RecordingError("is compressed more than once", file=file)
            yield from _file(plain, inside)
    except ValueError as error:
        raise RecordingError(str(error), file=file) from None
    finally:
        damage += [
            RecordingError(f"unpacked: {f.problem}", file=file, offset=f.offset) for f in inside
        ]


def _plain(message: BagMessage, kind: str, file: Path) -> bytes:
    try:
        return decompress(message.data, kind, min(MAX_CHUNK, max_unpacked(len(message.data))))
    except ValueError as error:
        raise RecordingError(f"a message {error}", file=file, offset=message.offset) from None


def _metadata(file: Path, damage: list[RecordingError]) -> dict[str, Any]:
    """Content of the metadata; empty, with a warning, where they cannot be read."""
    try:
        if file.stat().st_size > _MAX_METADATA:
            raise ValueError("too large")  # noqa: TRY301  # reported like the other faults
        read = yaml.load(file.read_text(encoding="utf-8"), _YAML)
        found = read["rosbag2_bagfile_information"]
        if isinstance(found, dict):
            return found
        problem = "no mapping"
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, RecursionError) as error:
        problem = " ".join(str(error).split())[:200]
    damage.append(RecordingError(f"cannot be read and is not used: {problem}", file=file))
    return {}


def _text(about: dict[str, Any], key: str) -> str:
    found = about.get(key)
    return found if isinstance(found, str) else ""


def _files(folder: Path, about: dict[str, Any], damage: list[RecordingError]) -> list[Path]:
    """Files that the metadata name, else all with such a name."""
    named = about.get("relative_file_paths")
    # Only strings: a YAML alias may expand to any size.
    names = [entry for entry in named if isinstance(entry, str)] if isinstance(named, list) else []
    files = [folder / Path(entry).name for entry in names]
    missing = [file for file in files if not os.path.isfile(file)]  # noqa: PTH113  # never raises
    damage.extend(RecordingError("is missing", file=file) for file in missing)
    files = [file for file in files if file not in missing]
    if not files:
        files = sorted(
            {f for pattern in MESSAGE_FILES for f in folder.glob(pattern)}, key=natural_order
        )
    if not files:
        raise RecordingError("has no file of messages, .mcap or .db3", file=folder)
    return files


def read_sqlite(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages of a SQLite file, in the order of writing, up to the first fault.

    rosbags refuses a database that is cut; SQLite itself reads it as far as it goes.

    Args:
        file: The database.
        damage: Takes the fault that ends the reading.
    """
    uri = f"{file.absolute().as_uri()}?mode=ro&immutable=1"
    missing = _missing_bytes(file)
    if missing > 0:
        damage.append(RecordingError(f"is cut: {missing} bytes are missing", file=file))
    try:
        with closing(sqlite3.connect(uri, uri=True)) as database:
            # Without it, a file that lacks its end is refused as a whole.
            database.execute("PRAGMA writable_schema=ON")
            database.execute("PRAGMA trusted_schema=OFF")
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MAX_ROW)
            limit = _StepLimit()
            database.set_progress_handler(limit, _MAX_STEPS)
            database.text_factory = lambda text: text.decode("utf-8", "replace")
            _check_tables(database)
            topics = {number: (name, type_) for number, name, type_ in database.execute(_TOPICS)}
            for number, time, data in database.execute(_MESSAGES):
                limit.rows += 1
                known = topics.get(number)
                if known is None or not isinstance(time, int) or not isinstance(data, bytes):
                    raise sqlite3.DatabaseError("a row is not a message")
                yield BagMessage(str(known[0]), str(known[1]), 1e-9 * time, data, None)
    except sqlite3.Error as error:
        damage.append(
            RecordingError(f"the database cannot be read from here on: {error}", file=file)
        )


def _missing_bytes(file: Path) -> int:
    """Number of bytes that a database lacks by its own header; SQLite does not report it.

    Bytes 16 to 18 are the size of a page, 28 to 32 the number of pages, which is valid if the
    change counter (24) equals that of the writing (92); https://sqlite.org/fileformat2.html.
    """
    with file.open("rb") as stream:
        head = stream.read(100)
    if len(head) < 100 or head[24:28] != head[92:96]:
        return 0
    page = int.from_bytes(head[16:18], "big")
    pages = int.from_bytes(head[28:32], "big")
    return pages * (65536 if page == 1 else page) - file.stat().st_size


class _StepLimit:
    """Progress handler that ends a query, by returning True, if no row came since the last call."""

    def __init__(self) -> None:
        self.rows = 0
        self._before = -1

    def __call__(self) -> bool:
        stuck, self._before = self.rows == self._before, self.rows
        return stuck


def _check_tables(database: sqlite3.Connection) -> None:
    """Refuse views: they compute their rows, perhaps without end."""
    for name in ("topics", "messages"):
        kinds = [kind for (kind,) in database.execute(_KIND, (name,))]
        if kinds and "table" not in kinds:
            raise sqlite3.DatabaseError(f"{name!r} is not a table")
