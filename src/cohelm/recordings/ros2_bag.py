"""ROS 2 bags: a folder with a metadata.yaml and files of messages, or such a file alone."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import yaml

from cohelm.errors import RecordingError
from cohelm.recordings.compression import (
    LARGEST,
    ZSTD_MAGIC,
    believed,
    decompress,
    unpack_zstd,
)
from cohelm.recordings.mcap_bag import MAGIC as MCAP
from cohelm.recordings.mcap_bag import read_mcap
from cohelm.recordings.ordering import natural
from cohelm.recordings.records import Message
from cohelm.recordings.sqlite_bag import MAGIC as SQLITE
from cohelm.recordings.sqlite_bag import read_sqlite

METADATA = "metadata.yaml"
PACKED = (".mcap.zstd", ".db3.zstd")
"""How compressed files of messages end."""
MESSAGES = ("*.mcap", "*.db3", *(f"*{ending}" for ending in PACKED))
"""How files of messages are called."""

_LARGEST_METADATA = 1 << 21
_YAML = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # safe; a megabyte in a second, not in ten


def read_ros2(path: Path, damage: list[RecordingError]) -> Iterator[Message]:
    """The messages, file by file, in the order of each.

    Args:
        path: the folder, or a file of messages.
        damage: takes what could not be read.

    Raises:
        RecordingError: if there is no file of messages, or it is compressed in an unknown way.
    """
    if path.is_file():
        yield from _file(path, damage)
        return
    about = _metadata(path / METADATA, damage)
    by_message = _word(about, "compression_mode").lower() == "message"
    kind = _word(about, "compression_format")
    for file in _files(path, about, damage):
        for message in _file(file, damage):
            yield message._replace(data=_plain(message, kind, file)) if by_message else message


def _file(file: Path, damage: list[RecordingError]) -> Iterator[Message]:
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


def _packed(file: Path, damage: list[RecordingError]) -> Iterator[Message]:
    """Of a compressed file; faults are told of the file itself, with places in what it holds."""
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


def _plain(message: Message, kind: str, file: Path) -> bytes:
    try:
        return decompress(message.data, kind, min(LARGEST, believed(len(message.data))))
    except ValueError as error:
        raise RecordingError(f"a message {error}", file=file, offset=message.offset) from None


def _metadata(file: Path, damage: list[RecordingError]) -> dict[str, Any]:
    """What it says of the bag; nothing where it makes no sense, which is noted."""
    try:
        if file.stat().st_size > _LARGEST_METADATA:
            raise ValueError("too large")  # noqa: TRY301  # told as the other faults
        read = yaml.load(file.read_text(encoding="utf-8"), _YAML)
        found = read["rosbag2_bagfile_information"]
        if isinstance(found, dict):
            return found
        problem = "no mapping"
    except (OSError, ValueError, yaml.YAMLError, KeyError, TypeError, RecursionError) as error:
        problem = " ".join(str(error).split())[:200]
    damage.append(RecordingError(f"makes no sense and is left aside: {problem}", file=file))
    return {}


def _word(about: dict[str, Any], key: str) -> str:
    found = about.get(key)
    return found if isinstance(found, str) else ""


def _files(folder: Path, about: dict[str, Any], damage: list[RecordingError]) -> list[Path]:
    """Those that the metadata name, or else all that are called so."""
    named = about.get("relative_file_paths")
    # anything but a word may be of any size: aliases multiply
    names = [entry for entry in named if isinstance(entry, str)] if isinstance(named, list) else []
    files = [folder / Path(entry).name for entry in names]
    missing = [file for file in files if not os.path.isfile(file)]  # noqa: PTH113  # never raises
    damage.extend(RecordingError("is missing", file=file) for file in missing)
    files = [file for file in files if file not in missing]
    if not files:
        files = sorted({f for pattern in MESSAGES for f in folder.glob(pattern)}, key=natural)
    if not files:
        raise RecordingError("has no file of messages, .mcap or .db3", file=folder)
    return files
