"""What bags are compressed with, undone as far as it goes."""

from __future__ import annotations

import bz2
import importlib
import shutil
import sys
from pathlib import Path
from typing import Protocol, cast

LARGEST = 1 << 28
"""Bytes beyond which a chunk is not believed: bags hold chunks of about a million."""

_RATIO = 100
"""How many times smaller what a sensor says may become: a scan to a tenth, a black image to a
hundredth."""
_ALLOWED = 1 << 24
"""Bytes that any chunk, however small, may grow to."""

ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"

_STEP = 1 << 16
"""Bytes that are undone at a time, so that what is whole before a fault is kept."""


class _Decompressor(Protocol):
    @property
    def eof(self) -> bool: ...

    @property
    def needs_input(self) -> bool: ...

    def decompress(self, data: bytes, max_length: int = -1) -> bytes: ...


def believed(packed: int) -> int:
    """How many bytes so many compressed ones may hold: fewer than a bomb's."""
    return max(_ALLOWED, _RATIO * packed)


def decompress(data: bytes, kind: str, size: int) -> bytes:
    """The first ``size`` bytes of what was compressed, or as many as can be undone.

    Args:
        data: compressed, possibly cut or damaged.
        kind: ``none`` or nothing at all, ``bz2``, ``lz4`` or ``zstd``.
        size: how many bytes there should be; more are never made.

    Raises:
        ValueError: if the kind is unknown, or nothing is installed for it.
    """
    if kind in {"", "none"}:
        return data[:size]
    stream = _stream(kind)
    done = bytearray()
    try:
        while len(done) < size and not stream.eof:
            some = stream.decompress(data, min(size - len(done), _STEP))
            if not some and not data:
                break
            done += some
            data = b""
    except Exception:  # each of the three has exceptions of its own; none says more than this:
        return bytes(done)
    return bytes(done)


def unpack_zstd(file: Path, to: Path) -> None:
    """Write what ``file`` holds, as far as it can be undone and believed, to another file.

    No more than half of what is free there is filled.

    Raises:
        ValueError: if nothing is installed for it.
    """
    with file.open("rb") as packed, to.open("wb") as plain:
        stream = _stream("zstd")
        left = min(believed(file.stat().st_size), shutil.disk_usage(to.parent).free // 2)
        while not stream.eof and left > 0:
            data = packed.read(_STEP) if stream.needs_input else b""
            if stream.needs_input and not data:
                return
            try:
                some = stream.decompress(data, min(left, _STEP))
            except Exception:  # as above; whoever reads the file sees that it is cut
                return
            left -= plain.write(some)


def _stream(kind: str) -> _Decompressor:
    if kind == "bz2":
        return bz2.BZ2Decompressor()
    if kind not in _MADE_BY:
        raise ValueError(f"is compressed with {kind[:20]!r}, known are bz2, lz4 and zstd")
    module, name = _MADE_BY[kind]
    try:
        return cast(_Decompressor, getattr(importlib.import_module(module), name)())
    except ImportError:
        raise ValueError(f"is compressed with {kind}: install {module.partition('.')[0]}") from None


# rosbags brings both along; they are wanted only where a bag is compressed so
_MADE_BY = {
    "lz4": ("lz4.frame", "LZ4FrameDecompressor"),
    "zstd": (
        "compression.zstd" if sys.version_info >= (3, 14) else "backports.zstd",
        "ZstdDecompressor",
    ),
}
