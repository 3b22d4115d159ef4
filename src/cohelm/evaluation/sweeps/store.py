"""Store of a sweep: an SQLite file with a row for each task that is done.

``sweep.sqlite`` has the identity and the size of the sweep. Each task is written by one
transaction, with a digest of its rows and arrays. A task that was interrupted by a crash or a full
disk is missing, a damaged one is ignored, and both are done again.
"""

from __future__ import annotations

import io
import json
import sqlite3
from collections.abc import Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO, Any

import numpy as np

from cohelm.errors import ConfigError
from cohelm.evaluation.code_version import differences, digest
from cohelm.evaluation.sweeps.tasks import Result, TaskError

STORE, LOCK = "sweep.sqlite", "sweep.lock"
ROWS, EPISODES = "rows.csv", "episodes.parquet"
"""Tables of the rows; the Parquet file is removed when it is older than the rows."""
_RESULTS = (ROWS, "summary.json", EPISODES, "summary.csv", "report.html")
_FORMAT = 2
_SCHEMA = """
CREATE TABLE IF NOT EXISTS sweep (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE IF NOT EXISTS task (
    key TEXT PRIMARY KEY, rows TEXT NOT NULL, arrays BLOB NOT NULL, error TEXT, digest TEXT NOT NULL
);
"""
_WAIT = 30.0  # s, for another process that writes


@dataclass(frozen=True)
class SweepHeader:
    """Identity of a sweep."""

    bench: str
    options: Mapping[str, str]
    code: Mapping[str, str]


@dataclass(frozen=True)
class SweepSize:
    """Size that a sweep is to have, as of its last start."""

    tasks: int
    rides: int
    """Rides in the tasks; 0 where they are not of rides."""


@dataclass(frozen=True)
class Record:
    """Results of one task."""

    results: tuple[Result, ...]
    error: TaskError | None = None


class SweepStore:
    """The store of a folder, open for writing by one process at a time.

    Args:
        folder: existing folder of the sweep.
        header: identity of the sweep.
        resume: continue what is there.
        overwrite: remove the results that are there.

    Attributes:
        records: results that are there, by the key of the task.
        changed: names of code that has changed since the sweep began; empty: none.

    Raises:
        ConfigError: if the folder belongs to another sweep, cannot be written to, is open in
            another process, or has results that are neither to be continued nor removed.
    """

    def __init__(
        self, folder: Path, header: SweepHeader, *, resume: bool = False, overwrite: bool = False
    ) -> None:
        self.folder = folder
        self.records: dict[str, Record] = {}
        self.changed = ""
        there = read_header(folder) if resume else None  # a refused folder stays as it is
        with _as_config_error(folder):
            self._lock: IO[bytes] = (folder / LOCK).open("ab")
        try:
            _lock(self._lock, folder)  # only now the content is certain
            if overwrite:
                _remove_results(folder)
            elif not resume:
                check_new(folder)
            if there is not None:
                self._continue(there, header)
            with _as_config_error(folder):
                if there is None:
                    (folder / STORE).unlink(missing_ok=True)
                self._database = sqlite3.connect(folder / STORE, timeout=_WAIT)
                self._database.executescript(_SCHEMA)
                if there is None:
                    self._set({**_as_text(header), "format": str(_FORMAT)})
        except BaseException:
            self._lock.close()
            raise

    def set_size(self, size: SweepSize) -> None:
        """Store the size that the sweep is to have.

        Raises:
            ConfigError: if it cannot be written.
        """
        with _as_config_error(self.folder):
            self._set({"size": json.dumps(asdict(size))})

    def add(self, key: str, results: Sequence[Result], error: TaskError | None = None) -> Record:
        """Store the results of a task; returns them as they will be read again.

        Raises:
            ConfigError: if they cannot be written, as on a full disk.
            TypeError: if a row holds neither text nor numbers.
        """
        rows = json.dumps([dict(each.row) for each in results], default=_plain)
        groups = [{k: np.asarray(v) for k, v in each.arrays.items()} for each in results]
        arrays = _packed(groups)
        said = None if error is None else json.dumps(asdict(error))
        with _as_config_error(self.folder), self._database:
            self._database.execute(
                "INSERT OR REPLACE INTO task VALUES (?, ?, ?, ?, ?)",
                (key, rows, arrays, said, _checksum(rows, arrays)),
            )
        stored = zip(json.loads(rows), groups, strict=True)
        self.records[key] = Record(tuple(Result(row, each) for row, each in stored), error)
        return self.records[key]

    def __enter__(self) -> SweepStore:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        self._database.close()
        self._lock.close()

    def _continue(self, there: SweepHeader, header: SweepHeader) -> None:
        _check_same(there, header, self.folder)
        self.changed = differences(there.code, header.code)
        self.records = read_records(self.folder)

    def _set(self, values: Mapping[str, str]) -> None:
        with self._database:
            self._database.executemany(
                "INSERT OR REPLACE INTO sweep VALUES (?, ?)", list(values.items())
            )


def is_begun(folder: Path) -> bool:
    """Check that a folder holds results; a store without a task is none."""
    if any((folder / name).exists() for name in (ROWS, "summary.json")):
        return True
    if not (folder / STORE).exists():
        return False
    try:
        with _reading(folder) as database:
            return database.execute("SELECT 1 FROM task").fetchone() is not None
    except sqlite3.OperationalError as cause:
        return "no such table" not in str(cause)
    except sqlite3.Error:  # present, but not readable
        return True


def check_new(folder: Path) -> None:
    """Check that a sweep may begin in a folder.

    Raises:
        ConfigError: if it holds results.
    """
    if is_begun(folder):
        raise ConfigError(
            f"{folder} has results; --resume continues them, --overwrite removes them, or choose "
            "another folder",
            key="--out",
        )


def read_header(folder: Path) -> SweepHeader | None:
    """Read the identity of the sweep in a folder; None where none has begun.

    Raises:
        ConfigError: if the folder holds something else.
    """
    if not (folder / STORE).exists():
        if is_begun(folder):
            raise ConfigError(
                f"{folder} has results but no {STORE}: their sweep is unknown", key="--resume"
            )
        return None
    try:
        with _reading(folder) as database:
            values = dict(database.execute("SELECT name, value FROM sweep").fetchall())
    except sqlite3.OperationalError as cause:
        if "no such table" in str(cause):  # interrupted before the sweep had begun
            return None
        raise _unwritable(folder, cause) from None
    except sqlite3.DatabaseError:
        values = {"format": ""}
    if not values:
        return None
    if values.get("format") != str(_FORMAT):
        raise ConfigError("is damaged, or of another version", file=folder / STORE)
    return SweepHeader(values["bench"], json.loads(values["options"]), json.loads(values["code"]))


def read_size(folder: Path) -> SweepSize | None:
    """Read the size that the sweep in a folder is to have; None where it is not known."""
    try:
        with _reading(folder) as database:
            found = database.execute("SELECT value FROM sweep WHERE name = 'size'").fetchone()
    except sqlite3.Error:
        return None
    return None if found is None else SweepSize(**json.loads(found[0]))


def read_records(folder: Path) -> dict[str, Record]:
    """Read the results of all tasks by key, without damaged ones; also while a sweep runs.

    Raises:
        ConfigError: if the store cannot be read.
    """
    out: dict[str, Record] = {}
    try:
        with _reading(folder) as database:
            for key, rows, arrays, error, checksum in database.execute("SELECT * FROM task"):
                if checksum != _checksum(rows, arrays):
                    continue
                said = json.loads(rows)
                results = zip(said, _unpacked(arrays, len(said)), strict=True)
                found = None if error is None else TaskError(**json.loads(error))
                out[key] = Record(tuple(Result(*each) for each in results), found)
    except sqlite3.DatabaseError as cause:
        raise ConfigError(f"cannot be read ({cause})", file=folder / STORE) from None
    return out


@contextmanager
def _reading(folder: Path) -> Iterator[sqlite3.Connection]:
    file = (folder / STORE).absolute().as_uri()
    # Writable, because an interrupted transaction is rolled back by its next reader.
    with closing(sqlite3.connect(f"{file}?mode=rw", uri=True, timeout=_WAIT)) as database:
        yield database


def _remove_results(folder: Path) -> None:
    """Remove the results of a sweep; all other files stay, as ratings, which name their ride."""
    for name in (STORE, *_RESULTS):
        (folder / name).unlink(missing_ok=True)


def _check_same(there: SweepHeader, header: SweepHeader, folder: Path) -> None:
    if there.bench != header.bench:
        raise ConfigError(
            f"{folder} is of 'cohelm bench {there.bench}'; choose another folder by --out",
            key="--resume",
        )
    if changed := differences(there.options, header.options):
        raise ConfigError(
            f"{folder} has other options ({changed}); "
            "give the same, or choose another folder by --out",
            key="--resume",
        )


def _as_text(header: SweepHeader) -> dict[str, str]:
    return {
        "bench": header.bench,
        "options": json.dumps(dict(header.options), sort_keys=True),
        "code": json.dumps(dict(header.code), sort_keys=True),
    }


def _packed(groups: Sequence[Mapping[str, Any]]) -> bytes:
    """Arrays of all rows as one compressed NumPy file."""
    flat = {f"{i}/{name}": each for i, group in enumerate(groups) for name, each in group.items()}
    out = io.BytesIO()
    np.savez_compressed(out, allow_pickle=False, **flat)
    return out.getvalue()


def _unpacked(arrays: bytes, count: int) -> list[dict[str, Any]]:
    out: list[dict[str, Any]] = [{} for _ in range(count)]
    with np.load(io.BytesIO(arrays), allow_pickle=False) as content:
        for name in content:
            i, _, key = name.partition("/")
            out[int(i)][key] = content[name]
    return out


def _checksum(rows: str, arrays: bytes) -> str:
    return digest(rows.encode() + arrays)


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"a row may hold text and numbers, not {type(value).__name__}")


@contextmanager
def _as_config_error(folder: Path) -> Iterator[None]:
    try:
        yield
    except (OSError, sqlite3.Error) as cause:
        raise _unwritable(folder, cause) from None


def _unwritable(folder: Path, cause: Exception) -> ConfigError:
    why = getattr(cause, "strerror", None) or cause
    return ConfigError(
        f"{folder} cannot be written to ({why}); its results are kept, and --resume continues them",
        key="--out",
    )


def _lock(stream: IO[bytes], folder: Path) -> None:
    """Lock the folder against other processes, where the system has locks."""
    try:
        import fcntl  # noqa: PLC0415 # not on every system
    except ImportError:
        return
    try:
        fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise ConfigError(f"another process writes to {folder}", key="--out") from None
    except OSError:  # a network folder without locks
        return
