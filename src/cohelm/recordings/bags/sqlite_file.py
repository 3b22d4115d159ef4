"""SQLite files of ROS 2, read in the order of writing, together with their write-ahead logs.

A recorder in WAL mode first appends messages to ``x.db3-wal``; those of a killed recorder, or of
one that still writes, are only there. https://sqlite.org/fileformat2.html describes both files.
"""

from __future__ import annotations

import shutil
import sqlite3
import struct
import tempfile
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from cohelm.errors import RecordingError
from cohelm.recordings.bags.records import BagMessage

SQLITE = b"SQLite format 3\0"

_MAX_ROW = 1 << 28
"""Maximum size of a row, bytes."""
_MAX_STEPS = 10_000_000
"""Maximum steps of SQLite's virtual machine per row; a stored row takes a dozen."""
_KIND = "SELECT type FROM sqlite_master WHERE lower(name) = ?"
_COLUMNS = "SELECT name FROM pragma_table_info('topics')"
_TOPICS = "SELECT id, name, type, {} FROM topics"
_ENCODING = "serialization_format"
_MESSAGES = "SELECT topic_id, timestamp, data FROM messages"

_WAL_HEAD = struct.Struct(">8I")
"""Magic, version, size of a page, number of checkpoints, two salts, two checksums."""
_FRAME = struct.Struct(">6I")
"""Page, size of the database after a commit or 0, two salts, two checksums."""
_WAL_MAGIC = 0x377F0682
"""Its lowest bit is set where the checksums are of big-endian words."""
_USUAL_PAGE = 4096
"""Size of a page where the log does not tell it, bytes."""


def read_sqlite(file: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages of a SQLite file, in the order of writing, up to the first fault.

    rosbags refuses a database that is cut; SQLite itself reads it as far as it goes.

    Args:
        file: The database.
        damage: Takes the fault that ends the reading, and what lacks in the file and its log.
    """
    missing = _missing_bytes(file)
    if missing > 0:
        damage.append(RecordingError(f"is cut: {missing} bytes are missing", file=file))
    try:
        with _opened(file, damage) as database:
            # Without it, a file that lacks its end is refused as a whole.
            database.execute("PRAGMA writable_schema=ON")
            database.execute("PRAGMA trusted_schema=OFF")
            database.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, _MAX_ROW)
            limit = _StepLimit()
            database.set_progress_handler(limit, _MAX_STEPS)
            database.text_factory = lambda text: text.decode("utf-8", "replace")
            _check_tables(database)
            topics = _topics(database)
            for number, time, data in database.execute(_MESSAGES):
                limit.rows += 1
                known = topics.get(number)
                if known is None or not isinstance(time, int) or not isinstance(data, bytes):
                    raise sqlite3.DatabaseError("a row is not a message")
                name, type_, encoding = known
                yield BagMessage(name, type_, 1e-9 * time, data, None, encoding)
    except sqlite3.Error as error:
        damage.append(
            RecordingError(f"the database cannot be read from here on: {error}", file=file)
        )


@contextmanager
def _opened(file: Path, damage: list[RecordingError]) -> Iterator[sqlite3.Connection]:
    """Open a database with its write-ahead log; neither is changed.

    SQLite reads a log only with its index, ``x.db3-shm``. Where that exists, a recorder may still
    write, and SQLite keeps to the locks. Otherwise copies are read: SQLite would create the index
    beside the database, or fail in a folder that is read-only.
    """
    file = file.resolve()  # the log lies beside the database, not beside a link to it
    log, index = (file.with_name(file.name + ending) for ending in ("-wal", "-shm"))
    if not log.is_file() or log.stat().st_size == 0:
        with closing(_connect(file, "&immutable=1")) as database:
            yield database
        return
    lost = _lost_pages(log)
    if lost:
        problem = f"{lost} pages at its end are damaged or not committed: they are not read"
        damage.append(RecordingError(problem, file=log))
    if index.is_file():
        with closing(_connect(file)) as database:
            yield database
        return
    with tempfile.TemporaryDirectory() as folder:
        for source in (file, log):
            shutil.copyfile(source, Path(folder) / source.name)
        with closing(_connect(Path(folder) / file.name)) as database:
            yield database


def _connect(file: Path, more: str = "") -> sqlite3.Connection:
    return sqlite3.connect(f"{file.absolute().as_uri()}?mode=ro{more}", uri=True)


def _topics(database: sqlite3.Connection) -> dict[int, tuple[str, str, str]]:
    """Name, type and encoding of each topic; files without encodings have CDR."""
    known = _ENCODING in {name for (name,) in database.execute(_COLUMNS)}
    rows = database.execute(_TOPICS.format(_ENCODING if known else "'cdr'"))
    return {number: (str(name), str(type_), str(how)) for number, name, type_, how in rows}


def _lost_pages(log: Path) -> int:
    """Number of pages in a write-ahead log after its last valid commit; SQLite ignores them.

    Pages with other salts are left from before a checkpoint, and are in the database.
    """
    with log.open("rb") as stream:
        head = stream.read(_WAL_HEAD.size).ljust(_WAL_HEAD.size, b"\0")
        magic, _, page, _, *salts, first, second = _WAL_HEAD.unpack(head)
        words = struct.Struct(">2I" if magic & 1 else "<2I")
        sums = _checksums(head[:24], words, (0, 0))
        sound = magic & ~1 == _WAL_MAGIC and sums == (first, second)
        if not sound:
            return max(1, log.stat().st_size // (_FRAME.size + _USUAL_PAGE))
        pages = committed = 0
        while frame := stream.read(_FRAME.size + page):
            _, commit, *frame_salts, first, second = _FRAME.unpack(frame[:24].ljust(24, b"\0"))
            if frame_salts != salts:
                break
            pages += 1
            if sound and len(frame) == _FRAME.size + page:
                sums = _checksums(frame[24:], words, _checksums(frame[:8], words, sums))
                sound = sums == (first, second)
                committed = pages if sound and commit else committed
            else:
                sound = False
    return pages - committed


def _checksums(data: bytes, words: struct.Struct, sums: tuple[int, int]) -> tuple[int, int]:
    a, b = sums
    for x, y in words.iter_unpack(data):
        a = (a + x + b) & 0xFFFFFFFF
        b = (b + y + a) & 0xFFFFFFFF
    return a, b


def _missing_bytes(file: Path) -> int:
    """Number of bytes that a database lacks by its own header; SQLite does not report it.

    Bytes 16 to 18 are the size of a page, 28 to 32 the number of pages, which is valid if the
    change counter (24) equals that of the writing (92).
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
