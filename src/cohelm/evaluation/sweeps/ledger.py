"""The ledger of a sweep: what came of each task, kept at once and for good.

``ledger.jsonl`` begins with a line that says what the sweep is; each task that is done adds a line
with its rows. Arrays lie in ``arrays/``, a file for each task, written before the line that names
it. A line is written by one call and ends with its digest: what was cut short by a crash or a full
disk is known as such, and its task is done again.
"""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from cohelm.errors import ConfigError
from cohelm.evaluation.sweeps.asked import ASKED, Asked, write_asked
from cohelm.evaluation.sweeps.identity import differences
from cohelm.evaluation.sweeps.tasks import Fault, Result

LEDGER, ARRAYS = "ledger.jsonl", "arrays"
OURS = (LEDGER, "rows.csv", "summary.json")
"""Files in a folder that are of a sweep."""
EPISODES = "episodes.parquet"
"""The rows once more, for programs; where it is older than they are, it is worse than none."""
_REPORTS = (EPISODES, "summary.csv", "report.html", ASKED)
_FORMAT = 1
_BAD_ZIP = (zipfile.BadZipFile, zlib.error)
_MEGABYTE = 1 << 20


@dataclass(frozen=True)
class Header:
    """What a sweep is."""

    bench: str
    options: Mapping[str, str]
    code: Mapping[str, str]
    format: int = _FORMAT


@dataclass(frozen=True)
class Record:
    """What came of one task."""

    results: tuple[Result, ...]
    fault: Fault | None = None


class Ledger:
    """A folder's ledger, open for more; one process at a time.

    Args:
        folder: of the sweep; there.
        header: what is swept.
        resume: go on with what is there, instead of beginning.
        overwrite: throw away what is there, once nobody else is found to write to it.

    Attributes:
        records: what is there, by the key of the task.
        changed: what of the code is not as it was when the sweep began; empty: nothing.

    Raises:
        ConfigError: if the folder is of another sweep, cannot be written to, is being written, or
            has results that are neither to be gone on with nor to be thrown away.
    """

    def __init__(
        self, folder: Path, header: Header, *, resume: bool = False, overwrite: bool = False
    ) -> None:
        self.folder = folder
        self.records: dict[str, Record] = {}
        self.changed = ""
        if resume:
            read_header(folder)  # what is refused stays as it is
        try:
            flags = os.O_RDWR | os.O_CREAT | os.O_APPEND
            self._stream = os.open(folder / LEDGER, flags, 0o644)
        except OSError as cause:
            raise _unwritable(folder, cause) from None
        try:
            _lock(self._stream, folder)  # only now it is certain what is there
            if overwrite:
                _discard(folder)
            elif not resume:
                check_new(folder)
            self._begin(header, resume=resume)
        except BaseException as cause:
            os.close(self._stream)
            if isinstance(cause, OSError):
                raise _unwritable(folder, cause) from None
            raise

    def ask(self, asked: Asked) -> None:
        """Say beside the results how much is to be done.

        Raises:
            ConfigError: if it cannot be written.
        """
        try:
            write_asked(asked, self.folder)
        except OSError as cause:
            raise _unwritable(self.folder, cause) from None

    def add(self, key: str, results: Sequence[Result], fault: Fault | None = None) -> Record:
        """Keep what came of a task; returns it as it will be read again.

        Raises:
            ConfigError: if it cannot be written: no space is left, say.
            TypeError: if a row holds what is neither a word nor a number.
        """
        said = {
            "task": key,
            "rows": [dict(each.row) for each in results],
            "arrays": any(each.arrays for each in results),
            "fault": None if fault is None else asdict(fault),
        }
        text = json.dumps(said, default=_plain)
        arrays = [{k: np.asarray(v) for k, v in each.arrays.items()} for each in results]
        try:
            if said["arrays"]:
                _write_arrays(self.folder / ARRAYS / f"{key}.npz", arrays)
            self._append(text)
        except OSError as cause:
            raise _unwritable(self.folder, cause) from None
        rows = json.loads(text)["rows"]
        kept = tuple(Result(row, each) for row, each in zip(rows, arrays, strict=True))
        self.records[key] = Record(kept, fault)
        return self.records[key]

    def _begin(self, header: Header, *, resume: bool) -> None:
        there = read_header(self.folder) if resume else None
        if there is None:
            os.ftruncate(self._stream, 0)
            self._append(json.dumps(asdict(header), sort_keys=True))
            return
        _same_sweep(there, header, self.folder)
        self.changed = differences(there.code, header.code)
        self.records = read_records(self.folder)
        os.ftruncate(self._stream, _whole_lines(self.folder / LEDGER))

    def __enter__(self) -> Ledger:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        os.close(self._stream)

    def _append(self, text: str) -> None:
        line = f"{text}\t{_digest(text)}\n".encode()
        end = os.lseek(self._stream, 0, os.SEEK_END)
        try:
            while line:
                line = line[os.write(self._stream, line) :]  # short where little space is left
            os.fsync(self._stream)
        except OSError:
            os.ftruncate(self._stream, end)
            raise


def is_begun(folder: Path) -> bool:
    """Whether a folder holds results; a ledger without a task is none."""
    if any((folder / name).exists() for name in OURS if name != LEDGER):
        return True
    try:
        with (folder / LEDGER).open("rb") as stream:
            return len(stream.readlines(_MEGABYTE)) > 1
    except FileNotFoundError:
        return False
    except OSError:  # there is something that cannot be read
        return True


def check_new(folder: Path) -> None:
    """Whether a sweep may begin in a folder.

    Raises:
        ConfigError: if it holds results.
    """
    if is_begun(folder):
        raise ConfigError(
            f"{folder} has results; --resume goes on with them, --overwrite throws them away, "
            "or name another folder",
            key="--out",
        )


def read_header(folder: Path) -> Header | None:
    """What the sweep in a folder is; None where none has begun.

    Raises:
        ConfigError: if there is something else in its place.
    """
    try:
        with (folder / LEDGER).open("rb") as stream:
            line = stream.readline()
    except FileNotFoundError:
        if is_begun(folder):
            raise ConfigError(
                f"{folder} has results but no {LEDGER}: nothing tells what they are of",
                key="--resume",
            ) from None
        return None
    except OSError as cause:
        raise _unwritable(folder, cause) from None
    said = _parsed(line)
    if said is None and not line.endswith(b"\n"):
        return None  # it ended before it had begun
    if said is None or said.get("format") != _FORMAT:
        raise ConfigError("is no ledger that this version reads", file=folder / LEDGER)
    return Header(**said)


def read_records(folder: Path) -> dict[str, Record]:
    """What came of the tasks, by key, the last word on each; lines that are damaged do not count.

    Works while the sweep goes on.
    """
    out: dict[str, Record] = {}
    with (folder / LEDGER).open("rb") as stream:
        next(stream, None)
        for line in stream:
            said = _parsed(line)
            if said is None or "task" not in said:
                continue
            arrays = _read_arrays(folder / ARRAYS / f"{said['task']}.npz", said)
            if arrays is not None:
                results = zip(said["rows"], arrays, strict=True)
                fault = None if said["fault"] is None else Fault(**said["fault"])
                out[said["task"]] = Record(tuple(Result(*each) for each in results), fault)
    return out


def _discard(folder: Path) -> None:
    """Remove the results of a sweep, all but the ledger's file, which is the lock.

    Whatever else is there stays, ratings too: each says which ride it is of.
    """
    names = [name for name in (*OURS, *_REPORTS) if name != LEDGER]
    for file in [*(folder / name for name in names), *(folder / ARRAYS).glob("*.npz")]:
        file.unlink(missing_ok=True)


def _same_sweep(there: Header, asked: Header, folder: Path) -> None:
    if there.bench != asked.bench:
        raise ConfigError(
            f"{folder} is of 'cohelm bench {there.bench}'; name another folder by --out",
            key="--resume",
        )
    if changed := differences(there.options, asked.options):
        raise ConfigError(
            f"{folder} is of other options ({changed}); "
            "give the same, or name another folder by --out",
            key="--resume",
        )


def _write_arrays(file: Path, arrays: Sequence[Mapping[str, Any]]) -> None:
    file.parent.mkdir(exist_ok=True)
    flat = {f"{i}/{name}": each for i, group in enumerate(arrays) for name, each in group.items()}
    beside = file.with_suffix(".part")
    try:
        with beside.open("wb") as stream:
            np.savez_compressed(stream, allow_pickle=False, **flat)
        beside.replace(file)
    finally:
        beside.unlink(missing_ok=True)


def _read_arrays(file: Path, said: Mapping[str, Any]) -> list[dict[str, Any]] | None:
    """Those of each row; None where they are gone or damaged."""
    out: list[dict[str, Any]] = [{} for _ in said["rows"]]
    if not said["arrays"]:
        return out
    try:
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            for name in content:
                i, _, key = name.partition("/")
                out[int(i)][key] = content[name]
    except (OSError, ValueError, EOFError, LookupError, RuntimeError, *_BAD_ZIP):
        return None
    return out


def _parsed(line: bytes) -> dict[str, Any] | None:
    """What a line says; None: it is damaged."""
    try:
        text, _, digest = line.decode().rstrip("\n").rpartition("\t")
    except UnicodeDecodeError:
        return None
    if not line.endswith(b"\n") or digest != _digest(text):
        return None
    said: dict[str, Any] = json.loads(text)
    return said


def _whole_lines(file: Path) -> int:
    """Length of a file up to its last line's end, bytes."""
    return file.read_bytes().rfind(b"\n") + 1


def _digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:8]


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"a row may hold words and numbers, not {type(value).__name__}")


def _unwritable(folder: Path, cause: OSError) -> ConfigError:
    return ConfigError(
        f"{folder} cannot be written to ({cause.strerror}); what it holds is kept, and --resume "
        "goes on",
        key="--out",
    )


def _lock(stream: int, folder: Path) -> None:
    """Keep others from writing the same ledger; not where the system knows no locks."""
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
