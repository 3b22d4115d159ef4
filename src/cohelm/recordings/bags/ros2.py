"""ROS 2 bags: a folder with a metadata.yaml and files of messages, or such a file alone.

The files are MCAP or SQLite. Metadata that are missing or damaged are reported and not needed.
"""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from cohelm.errors import RecordingError
from cohelm.recordings.api import natural_order
from cohelm.recordings.bags.compression import (
    MAX_CHUNK,
    ZSTD_MAGIC,
    decompress,
    kind_of,
    max_unpacked,
    unpack_zstd,
)
from cohelm.recordings.bags.mcap_file import MAGIC as MCAP
from cohelm.recordings.bags.mcap_file import read_mcap
from cohelm.recordings.bags.records import BagMessage
from cohelm.recordings.bags.sqlite_file import SQLITE, read_sqlite

METADATA = "metadata.yaml"
PACKED = (".mcap.zstd", ".db3.zstd")
"""Endings of compressed files of messages."""
MESSAGE_FILES = ("*.mcap", "*.db3", *(f"*{ending}" for ending in PACKED))
"""Names of files of messages."""

_MAX_METADATA = 1 << 21
_YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # safe, and ten times as fast


def read_ros2(path: Path, damage: list[RecordingError]) -> Iterator[BagMessage]:
    """Read the messages, file by file.

    Args:
        path: The folder, or a file of messages.
        damage: Takes what could not be read.

    Raises:
        RecordingError: if there is no file of messages, or its compression is unknown.
    """
    alone = path.is_file()
    # The metadata beside a file that is named itself may be of another bag, or missing.
    about = _metadata(path.with_name(METADATA), []) if alone else _metadata(path / METADATA, damage)
    by_message = _text(about, "compression_mode").lower() == "message"
    kind = _text(about, "compression_format") if by_message else ""
    for file in [path] if alone else _files(path, about, damage):
        for message in _file(file, damage):
            yield message._replace(data=_plain(message, kind, file))


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
    """Content of a message whose compression is told by its first bytes, else by ``kind``."""
    data, kind = message.data, kind_of(message.data, kind)
    try:
        return decompress(data, kind, min(MAX_CHUNK, max_unpacked(len(data)))) if kind else data
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
        text = error.strerror if isinstance(error, OSError) else str(error)
        problem = " ".join(str(text).split())[:200]
    damage.append(RecordingError(f"cannot be read and is not used: {problem}", file=file))
    return {}


def _text(about: dict[str, Any], key: str) -> str:
    found = about.get(key)
    return found if isinstance(found, str) else ""


def _files(folder: Path, about: dict[str, Any], damage: list[RecordingError]) -> list[Path]:
    """Files that the metadata name, else all with such a name; each only once."""
    there = {f for pattern in MESSAGE_FILES for f in folder.glob(pattern) if f.is_file()}
    # A file and its compressed copy hold the same. The plain one is whole where a recorder was
    # killed while compressing, which leaves no metadata.
    found: dict[str, Path] = {}
    for file in sorted(there, key=lambda file: (file.suffix == ".zstd", natural_order(file))):
        found.setdefault(_stem(file), file)
    named = about.get("relative_file_paths")
    # Only strings: a YAML alias may expand to any size.
    names = [entry for entry in named if isinstance(entry, str)] if isinstance(named, list) else []
    files: dict[str, Path] = {}
    for wanted in (folder / Path(entry).name for entry in names):
        choice = wanted if wanted in there else found.get(_stem(wanted))
        if choice is None:
            damage.append(RecordingError("is missing", file=wanted))
        else:
            files.setdefault(_stem(wanted), choice)
    files = files or {_stem(file): file for file in sorted(found.values(), key=natural_order)}
    if not files:
        raise RecordingError("has no file of messages, .mcap or .db3", file=folder)
    others = sorted(there - set(files.values()), key=natural_order)
    if others:
        listed = ", ".join(file.name for file in others)[:200]
        problem = f"not read beside {next(iter(files.values())).name}: {listed}"
        damage.append(RecordingError(problem, file=folder))
    return list(files.values())


def _stem(file: Path) -> str:
    """Name of a file of messages without its endings."""
    return Path(file.name.removesuffix(".zstd")).stem
