"""Check that a PNG holds all its rows: the decoder fills what is missing with black."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_CHANNELS = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}
"""Number of channels by colour type (PNG specification, 11.2.2)."""


def missing_rows(file: Path) -> int:
    """Number of rows that the pixel data of a PNG lacks; 0 for an interlaced one.

    Raises:
        ValueError, struct.error: if it is damaged otherwise.
    """
    data = file.read_bytes()
    if not data.startswith(_SIGNATURE):
        raise ValueError("no PNG")
    at, held, header = len(_SIGNATURE), [], b""
    while at + 8 <= len(data):
        length, kind = struct.unpack(">I4s", data[at : at + 8])
        if kind == b"IHDR":
            header = data[at + 8 : at + 8 + length]
        if kind == b"IDAT":
            held.append(data[at + 8 : at + 8 + length])
        at += 12 + length
    width, height, bits, colour, _, _, interlaced = struct.unpack(">IIBBBBB", header)
    if interlaced or colour not in _CHANNELS:
        return 0
    row = 1 + (width * bits * _CHANNELS[colour] + 7) // 8
    try:
        pixels = zlib.decompressobj().decompress(b"".join(held), row * height)
    except zlib.error as fault:
        raise ValueError(f"{fault}") from None
    return int(height - len(pixels) // row)
