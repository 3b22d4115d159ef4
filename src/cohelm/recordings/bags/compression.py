"""Decompression of bags, as far as the data is sound, and never to more than is plausible.

The libraries refuse damaged data as a whole; here everything before the damage is kept.
"""

from __future__ import annotations

import bz2
import importlib
import shutil
import sys
from pathlib import Path
from typing import Protocol, cast

MAX_CHUNK = 1 << 28
"""Maximum size of a chunk, bytes; usual ones have about a million."""

_RATIO = 100
"""Maximum plausible compression of sensor data: scans reach 10, black images 100."""
_ALLOWED = 1 << 24
"""Bytes to which any chunk may grow, also a small one."""

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"

_STEP = 1 << 16
"""Bytes decompressed at a time, so that those before a fault are kept."""

# Dependencies of rosbags; imported only where a bag is compressed with them.
_DECOMPRESSORS = {
    "lz4": ("lz4.frame", "LZ4FrameDecompressor"),
    "zstd": (
        "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd",
        "ZstdDecompressor",
    ),
}


_SIGNATURES = {ZSTD_MAGIC: "zstd", b"\x04\x22\x4d\x18": "lz4", b"BZh": "bz2"}
"""First bytes of compressed data; a message in CDR begins with 0."""


class _Decompressor(Protocol):
    @property
    def eof(self) -> bool: ...

    @property
    def needs_input(self) -> bool: ...

    def decompress(self, data: bytes, max_length: int = -1) -> bytes: ...


def max_unpacked(packed: int) -> int:
    """Maximum plausible size of so many compressed bytes; a decompression bomb claims more."""
    return max(_ALLOWED, _RATIO * packed)


def kind_of(data: bytes, declared: str) -> str:
    """Compression of a message: that of its first bytes, else one declared that has none known."""
    known = next((kind for first, kind in _SIGNATURES.items() if data.startswith(first)), "")
    return known or ("" if declared in _SIGNATURES.values() else declared)


def decompress(data: bytes, kind: str, size: int) -> bytes:
    """Decompress up to ``size`` bytes, or those before the first fault.

    Args:
        data: Compressed, possibly cut or damaged.
        kind: ``bz2``, ``lz4``, ``zstd``, ``none`` or empty.
        size: Expected and maximum size.

    Raises:
        ValueError: if the kind is unknown, or its library is not installed.
    """
    if kind in {"", "none"}:
        return data[:size]
    stream = _stream(kind)
    out = bytearray()
    try:
        while len(out) < size and not stream.eof:
            some = stream.decompress(data, min(size - len(out), _STEP))
            if not some and not data:
                break
            out += some
            data = b""
    except Exception:  # each library has its own errors; all mean damaged data
        return bytes(out)
    return bytes(out)


def unpack_zstd(file: Path, to: Path) -> None:
    """Decompress a file to another one, as far as it is sound and plausible.

    At most half of the free disk space is used.

    Raises:
        ValueError: if the library is not installed.
    """
    with file.open("rb") as packed, to.open("wb") as plain:
        stream = _stream("zstd")
        left = min(max_unpacked(file.stat().st_size), shutil.disk_usage(to.parent).free // 2)
        while not stream.eof and left > 0:
            data = packed.read(_STEP) if stream.needs_input else b""
            if stream.needs_input and not data:
                return
            try:
                some = stream.decompress(data, min(left, _STEP))
            except Exception:  # as above; the reader of the file reports that it is cut
                return
            left -= plain.write(some)


def _stream(kind: str) -> _Decompressor:
    if kind == "bz2":
        return bz2.BZ2Decompressor()
    if kind not in _DECOMPRESSORS:
        raise ValueError(f"is compressed with {kind[:20]!r}, known are bz2, lz4 and zstd")
    module, name = _DECOMPRESSORS[kind]
    try:
        return cast(_Decompressor, getattr(importlib.import_module(module), name)())
    except ImportError:
        raise ValueError(f"is compressed with {kind}: install {module.partition('.')[0]}") from None
