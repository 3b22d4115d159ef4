"""Check where the pixels of a binary PGM, PPM or PBM begin and end.

Netpbm separates header and pixels by exactly one white space character. A header with CRLF line
ends, or with more white space, would otherwise shift every pixel.
"""

from __future__ import annotations

from pathlib import Path

from PIL import Image

_AFTER_HEADER = b" \t\r\n\v\f#"
_CHANNELS = {"L": 1, "I": 1, "RGB": 3}


def surplus_bytes(file: Path, image: Image.Image) -> int:
    """Move the start of the pixels behind a CRLF; return the number of bytes behind the last pixel.

    Args:
        file: the image file.
        image: the same, opened and not decoded; its tile is changed.

    Raises:
        ValueError: if it cannot be told where the pixels begin.
    """
    (tile,) = image.tile  # type: ignore[attr-defined]  # of every image from a file
    codec, offset, arguments = tile[0], int(tile[2]), tile[3]
    if codec == "ppm_plain" or image.mode not in {"1", *_CHANNELS}:
        return 0
    with file.open("rb") as stream:
        head = stream.read(offset + 1)
    crlf = head.endswith(b"\r\n") and b"\r\n" in head[:-2]
    if crlf:
        offset += 1
        image.tile = [(codec, tile[1], offset, arguments)]  # type: ignore[attr-defined]
    surplus = file.stat().st_size - offset - _pixel_bytes(image, arguments)
    if surplus > 0 and (crlf or head[-1:] in _AFTER_HEADER):
        raise ValueError(
            f"{surplus} bytes more than its pixels need, and white space or a comment behind the "
            f"header; save it again with one line end there"
        )
    return max(surplus, 0)


def _pixel_bytes(image: Image.Image, arguments: object) -> int:
    """Number of bytes of all pixels."""
    width, height = image.size
    if image.mode == "1":
        return (width + 7) // 8 * height
    maximum = arguments[-1] if isinstance(arguments, tuple) else 255
    deep = arguments == "I;16B" or (isinstance(maximum, int) and maximum > 255)
    return width * height * _CHANNELS[image.mode] * (2 if deep else 1)
