"""Decompression of bags, never to more than is plausible; data that is cut gives what is left."""

from __future__ import annotations

import importlib
import shutil
import sys
from pathlib import Path
from typing import Any, cast

from cohelm.recordings.bags.records import BrokenRecord

MAX_CHUNK = 1 << 28
"""Maximum size of a chunk, bytes; usual ones have about a million."""

_RATIO = 100
"""Maximum plausible compression of sensor data: scans reach 10, black images 100."""
_ALLOWED = 1 << 24
"""Bytes to which any chunk may grow, also a small one."""

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"

_STEP = 1 << 16
"""Bytes of a file decompressed at a time, so that those before a fault are kept."""

# Dependencies of rosbags; imported only where a bag is compressed with them.
_DECOMPRESSORS = {
    "bz2": ("bz2", "BZ2Decompressor"),
    "lz4": ("lz4.frame", "LZ4FrameDecompressor"),
    "zstd": (
        "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd",
        "ZstdDecompressor",
    ),
}


_SIGNATURES = {ZSTD_MAGIC: "zstd", b"\x04\x22\x4d\x18": "lz4", b"BZh": "bz2"}
"""First bytes of compressed data; a message in CDR begins with 0."""


def max_unpacked(packed: int) -> int:
    """Maximum plausible size of so many compressed bytes; a decompression bomb claims more."""
    return max(_ALLOWED, _RATIO * packed)


def kind_of(data: bytes, declared: str) -> str:
    """Compression of a message: that of its first bytes, else one declared that has none known."""
    known = next((kind for first, kind in _SIGNATURES.items() if data.startswith(first)), "")
    return known or ("" if declared in _SIGNATURES.values() else declared)


def decompress(data: bytes, kind: str, size: int) -> bytes:
    """Decompress up to ``size`` bytes; nothing where the data is damaged.

    Args:
        data: Compressed, possibly cut.
        kind: ``bz2``, ``lz4``, ``zstd``, ``none`` or empty.
        size: Expected and maximum size.

    Raises:
        ValueError: if the kind is unknown, or its library is not installed.
    """
    if kind in {"", "none"}:
        return data[:size]
    module, name = _library(kind)
    try:
        return cast(bytes, getattr(module, name)().decompress(data, size))
    except Exception:  # each library has its own errors; all mean damaged data
        return b""


def unpack_chunk(data: bytes, kind: str, size: int, offset: int) -> bytes:
    """Decompress the records of a chunk at ``offset`` in its file, as :func:`decompress` does.

    Raises:
        BrokenRecord: if the claimed size is implausible, or the compression is unknown.
    """
    if size > MAX_CHUNK or (kind not in {"", "none"} and size > max_unpacked(len(data))):
        problem = f"a chunk claims {size} bytes from {len(data)}: implausible, not read"
        raise BrokenRecord(problem, offset)
    try:
        return decompress(data, kind, size)
    except ValueError as error:
        raise BrokenRecord(f"a chunk {error}", offset) from None


def unpack_zstd(file: Path, to: Path) -> None:
    """Decompress a file to another one, as far as it is sound and plausible.

    At most half of the free disk space is used.

    Raises:
        ValueError: if the library is not installed.
    """
    library, _ = _library("zstd")
    left = min(max_unpacked(file.stat().st_size), shutil.disk_usage(to.parent).free // 2)
    with library.open(file) as packed, to.open("wb") as plain:
        try:
            while left > 0 and (some := packed.read(min(left, _STEP))):
                left -= plain.write(some)
        except (EOFError, library.ZstdError):
            return  # the reader of the file reports that it is cut


def _library(kind: str) -> tuple[Any, str]:
    """Module of a compression, and the name of its decompressor."""
    if kind not in _DECOMPRESSORS:
        raise ValueError(f"is compressed with {kind[:20]!r}, known are bz2, lz4 and zstd")
    module, name = _DECOMPRESSORS[kind]
    try:
        return importlib.import_module(module), name
    except ImportError:
        raise ValueError(f"is compressed with {kind}: install {module.partition('.')[0]}") from None
