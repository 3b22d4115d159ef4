"""PCD files of the Point Cloud Library: a text header, then the points.

The header lists the fields of a point with sizes, types and counts. The points follow as text
(``ascii``), one after the other (``binary``), or field by field and compressed with LZF
(``binary_compressed``). VIEWPOINT is the pose of the sensor in the frame of the points, as in PCL's
estimation of normals.

LZF: a byte c below 32 begins a literal of c + 1 bytes. Otherwise its upper three bits are a length
(7: the next byte is added), and its lower five with the following byte a distance back; length + 2
bytes are copied from there, one by one, so that they may overlap.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from cohelm.arrays import Bytes, Floats, Floats32
from cohelm.errors import RecordingError
from cohelm.recordings.api import max_range
from cohelm.recordings.clouds.sweep import (
    AT_REST,
    POINT_LIMIT,
    UNKNOWN_MOUNT,
    CloudSweep,
    read_bytes,
)
from cohelm.recordings.transforms import fixed_axes, matrix, planar

_MAX_FILE = 1 << 31
_MAX_HEADER = 1 << 16
_LZF_RATIO = 265 / 3
"""Maximum number of bytes per compressed byte: three can copy 7 + 255 + 2 and one more."""
_TYPES = {
    *(("F", size) for size in (4, 8)),
    *((kind, size) for kind in "IU" for size in (1, 2, 4, 8)),
}


class _Field(NamedTuple):
    """Position of x, y or z within a point."""

    type: np.dtype[Any]
    before: int
    """Offset within a point, bytes."""
    stride: int
    """Distance between its numbers in field-by-field storage, bytes."""
    column: int
    """Index of its word in a line."""


class _Header(NamedTuple):
    points: int
    step: int
    """Size of a point, bytes."""
    columns: int
    """Number of words in a line."""
    axes: tuple[_Field, _Field, _Field]
    viewpoint: tuple[float, ...]
    encoding: str
    start: int
    """Offset of the points, bytes."""


class _Cut(NamedTuple):
    """Fault that ends the reading of points."""

    problem: str
    offset: int


def looks_like_pcd(start: bytes) -> bool:
    """Check that a file with this beginning is a PCD file."""
    words = start.lstrip().split()
    return b".PCD" in start[:200] or (bool(words) and words[0] in {b"VERSION", b"FIELDS"})


def read_pcd(file: Path) -> CloudSweep:
    """Read a PCD file; the range is that of its farthest point.

    Raises:
        RecordingError: if it is not a PCD file, or no point can be read; names the byte.
    """
    data = read_bytes(file, _MAX_FILE)
    try:
        header = _header(data)
        points, cut = _DECODERS[header.encoding](data, header)
    except _Malformed as error:
        raise RecordingError(error.problem, file=file, offset=error.offset) from None
    if len(points) == 0 and cut is not None:
        raise RecordingError(cut.problem, file=file, offset=cut.offset)
    damage = [RecordingError(cut.problem, file=file, offset=cut.offset)] if cut else []
    pose, mount = AT_REST, UNKNOWN_MOUNT
    v = header.viewpoint
    if v and np.isfinite(v).all() and 1e-3 < np.linalg.norm(v[3:]) < 1e3:
        X_MS = matrix((*v[:3], *v[4:], v[3]))
        pose = planar(X_MS)
        mount = np.array([0.0, 0.0, np.nan, *fixed_axes(X_MS)[3:5], 0.0])
        points = _seen_from(X_MS, points)
    elif v:
        damage.append(RecordingError("VIEWPOINT is not a pose, ignored", file=file))
    return CloudSweep(
        points=points, range_max=max_range(points), mount=mount, pose=pose, damage=tuple(damage)
    )


class _Malformed(Exception):
    def __init__(self, problem: str, offset: int = 0) -> None:
        self.problem = problem
        self.offset = offset
        super().__init__(problem)


def _header(data: bytes) -> _Header:
    words: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in words:
        end = data.find(b"\n", at, _MAX_HEADER)
        if end < 0:
            raise _Malformed("is not a PCD file, or cut within its header: DATA is missing", at)
        line = data[at:end].decode("latin-1").split("#")[0].split()
        at = end + 1
        if line:
            words[line[0].upper()] = line[1:]
    try:
        names = words["FIELDS"] if "FIELDS" in words else words["COLUMNS"]
        sizes = [int(word) for word in words["SIZE"]]
        counts = [int(word) for word in words.get("COUNT", ["1"] * len(names))]
        kinds = [word.upper() for word in words["TYPE"]]
        points = int(words["WIDTH"][0]) * int(words.get("HEIGHT", ["1"])[0])
        points = min(points, int(words["POINTS"][0])) if "POINTS" in words else points
        viewpoint = tuple(float(word) for word in words.get("VIEWPOINT", []))
        encoding = words["DATA"][0].lower()
    except (KeyError, ValueError, IndexError) as error:
        raise _Malformed(f"the header is incomplete or damaged: {error}") from None
    if not len(names) == len(sizes) == len(kinds) == len(counts) or min(counts, default=0) < 0:
        raise _Malformed("FIELDS, SIZE, TYPE and COUNT have different lengths")
    if not set(zip(kinds, sizes, strict=True)) <= _TYPES:
        raise _Malformed("has a field whose TYPE and SIZE do not match")
    if not 0 <= points <= POINT_LIMIT:
        raise _Malformed(f"claims {points} points; up to {POINT_LIMIT} are read")
    if encoding not in _DECODERS:
        raise _Malformed(f"DATA {encoding[:20]!r} is unknown")
    if len(viewpoint) not in {0, 7}:
        raise _Malformed("VIEWPOINT needs seven numbers")
    fields = list(zip(names, kinds, sizes, counts, strict=True))
    return _Header(
        points=points,
        step=sum(size * count for _, _, size, count in fields),
        columns=sum(counts),
        axes=(_axis("x", fields), _axis("y", fields), _axis("z", fields)),
        viewpoint=viewpoint,
        encoding=encoding,
        start=at,
    )


def _axis(name: str, fields: list[tuple[str, str, int, int]]) -> _Field:
    before = column = 0
    for called, kind, size, count in fields:
        if called == name and count > 0:
            return _Field(np.dtype(f"<{kind.lower()}{size}"), before, size * count, column)
        before += size * count
        column += count
    raise _Malformed(f"has no field {name}")


def _ascii(data: bytes, header: _Header) -> tuple[Floats32, _Cut | None]:
    columns = [field.column for field in header.axes]
    rows: list[tuple[float, ...]] = []
    at = header.start
    while len(rows) < header.points:
        end = data.find(b"\n", at)
        line = data[at : end if end >= 0 else len(data)]
        words = line.split()
        if words:
            if len(words) != header.columns:
                return _table(rows), _Cut(
                    f"a line of {len(words)} numbers instead of "
                    f"{header.columns}; {len(rows)} points are read",
                    at,
                )
            try:
                rows.append(tuple(float(words[k]) for k in columns))
            except ValueError:
                return _table(rows), _Cut(
                    f"a word is not a number; {len(rows)} points are read", at
                )
        if end < 0:
            break
        at = end + 1
    return _table(rows), _missing(len(rows), header, len(data))


def _table(rows: list[tuple[float, ...]]) -> Floats32:
    with np.errstate(over="ignore"):
        return np.array(rows, dtype=np.float64).reshape(-1, 3).astype(np.float32)


def _binary(data: bytes, header: _Header) -> tuple[Floats32, _Cut | None]:
    there = min((len(data) - header.start) // header.step, header.points)
    block = np.frombuffer(data, dtype=np.uint8, count=there * header.step, offset=header.start)
    points = np.empty((there, 3), dtype=np.float32)
    for k, field in enumerate(header.axes):
        points[:, k] = _numbers(block, field, there, field.before, header.step)
    return points, _missing(there, header, header.start + there * header.step)


def _compressed(data: bytes, header: _Header) -> tuple[Floats32, _Cut | None]:
    if len(data) < header.start + 8:
        raise _Malformed("is cut before its points", len(data))
    packed, size = struct.unpack_from("<II", data, header.start)
    begin = header.start + 8
    if size < header.points * header.step or size > _LZF_RATIO * packed + 1:
        raise _Malformed(
            f"{packed} bytes cannot be {header.points} points of {header.step}", header.start
        )
    block = decompress_lzf(data[begin : begin + packed], size)
    there = header.points
    for field in header.axes:
        have = (len(block) - field.before * header.points) // field.stride
        there = min(there, max(have, 0))
    points = np.empty((there, 3), dtype=np.float32)
    for k, field in enumerate(header.axes):
        points[:, k] = _numbers(block, field, there, field.before * header.points, field.stride)
    return points, _missing(there, header, min(begin + packed, len(data)))


_DECODERS: dict[str, Callable[[bytes, _Header], tuple[Floats32, _Cut | None]]] = {
    "ascii": _ascii,
    "binary": _binary,
    "binary_compressed": _compressed,
}


def _numbers(
    block: NDArray[np.uint8], field: _Field, count: int, first: int, stride: int
) -> NDArray[Any]:
    if count == 0:
        return np.empty(0)
    column: NDArray[Any] = np.ndarray(
        count, dtype=field.type, buffer=block, offset=first, strides=(stride,)
    )
    with np.errstate(over="ignore", invalid="ignore"):
        return column.astype(np.float32)


def _missing(there: int, header: _Header, offset: int) -> _Cut | None:
    if there == header.points:
        return None
    return _Cut(f"ends or is damaged after {there} of {header.points} points", offset)


def _seen_from(X_MS: Floats, points: Floats32) -> Floats32:
    """Transform points from the map's frame to the sensor's."""
    if np.array_equal(X_MS, np.eye(4)):
        return points
    with np.errstate(over="ignore", invalid="ignore"):
        return ((points - X_MS[:3, 3]) @ X_MS[:3, :3]).astype(np.float32)


def decompress_lzf(data: bytes, size: int) -> Bytes:
    """Decompress LZF: the first ``size`` bytes, or those before the first fault."""
    out = np.empty(min(size, int(_LZF_RATIO * len(data)) + 1), dtype=np.uint8)
    return out[: _decompress(np.frombuffer(data, dtype=np.uint8), out)]


@njit(cache=True)
def _decompress(data: Bytes, out: Bytes) -> int:
    """Decompress into ``out``; returns the number of bytes written."""
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
