"""LZF, the compression of binary_compressed PCD files: short literals and references back.

A byte c below 32 begins a literal of c + 1 bytes. Else its upper three bits are a length (7: the
next byte is added), and its lower five with the byte that follows are a distance back; length + 2
bytes are copied from there, one by one, so that they may repeat themselves.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Bytes

MOST = 265 / 3
"""Bytes at most that one compressed byte can stand for: three can copy 7 + 255 + 2 and one more."""


def decompress_lzf(data: bytes, size: int) -> Bytes:
    """The first ``size`` bytes, or those before the first fault."""
    out = np.empty(min(size, int(MOST * len(data)) + 1), dtype=np.uint8)
    return out[: _undo(np.frombuffer(data, dtype=np.uint8), out)]


@njit(cache=True)
def _undo(data: Bytes, out: Bytes) -> int:
    """Fill ``out`` and return how far it is filled."""
    i, o = 0, 0
    n, m = data.shape[0], out.shape[0]
    while i < n and o < m:
        c = int(data[i])
        i += 1
        if c < 32:
            length = min(c + 1, n - i, m - o)
            for k in range(length):
                out[o + k] = data[i + k]
            i += c + 1
            o += length
            continue
        length = c >> 5
        if length == 7 and i < n:
            length += int(data[i])
            i += 1
        if i >= n:
            break
        back = ((c & 31) << 8) + int(data[i]) + 1
        i += 1
        if back > o:
            break
        for _ in range(min(length + 2, m - o)):
            out[o] = out[o - back]
            o += 1
    return o
