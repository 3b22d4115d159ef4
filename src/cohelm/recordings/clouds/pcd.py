"""PCD files of the Point Cloud Library: a text header, then the points.

The header lists the fields of a point with sizes, types and counts. The points follow as text
(``ascii``), one after the other (``binary``), or field by field and compressed with LZF
(``binary_compressed``). VIEWPOINT is the pose of the sensor in the frame of the points, as in PCL's
estimation of normals.

LZF: a byte c below 32 begins a literal of c + 1 bytes. Otherwise its upper three bits are a length
(7: the next byte is added), and its lower five with the following byte a distance back; length + 2
bytes are copied from there, one by one, so that they may overlap.

A header that contradicts itself is refused.
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
from cohelm.kernels import CACHED
from cohelm.maps import MAX_COORDINATE
from cohelm.recordings.api import max_range
from cohelm.recordings.clouds.sweep import (
    AT_REST,
    POINT_LIMIT,
    UNKNOWN_MOUNT,
    CloudSweep,
    checked_points,
    read_bytes,
)
from cohelm.recordings.transforms import fixed_axes, matrix, planar

ENCODINGS = ("ascii", "binary", "binary_compressed")
_MAX_HEADER = 1 << 16
_KEYS = frozenset(
    ("VERSION", "FIELDS", "COLUMNS", "SIZE", "TYPE", "COUNT", "WIDTH", "HEIGHT", "VIEWPOINT",
     "POINTS", "DATA")
)  # fmt: skip
_TYPES = {
    *(("F", size) for size in (4, 8)),
    *((kind, size) for kind in "IU" for size in (1, 2, 4, 8)),
}


_AXES = ("x", "y", "z")


class Field(NamedTuple):
    """Position of x, y or z within a point."""

    type: np.dtype[Any]
    before: int
    """Offset within a point, bytes."""
    stride: int
    """Distance between its numbers in field-by-field storage, bytes."""
    column: int
    """Index of its word in a line."""


class Header(NamedTuple):
    """Content of the header."""

    points: int
    """Number of points."""
    step: int
    """Size of a point, bytes."""
    columns: int
    """Number of words in a line."""
    axes: tuple[Field, Field, Field]
    viewpoint: tuple[float, ...]
    """Position, m, and quaternion (w, x, y, z) of the sensor; empty: not given."""
    encoding: str
    """One of :data:`ENCODINGS`."""
    start: int
    """Offset of the points, bytes."""
    doubts: tuple[str, ...]
    """Contradictions in the header."""


class Malformed(Exception):
    """A header, or the beginning of the points, from which nothing can be read.

    Args:
        problem: Description.
        offset: In the file, bytes.
    """

    def __init__(self, problem: str, offset: int = 0) -> None:
        self.problem = problem
        self.offset = offset
        super().__init__(problem)


def read_header(data: bytes) -> Header:
    """Read the header of a file.

    Raises:
        Malformed: It is incomplete or contradicts itself.
    """
    words, start, doubts = _entries(data)
    try:
        names = words["FIELDS"] if "FIELDS" in words else words["COLUMNS"]
        sizes = [int(word) for word in words["SIZE"]]
        counts = [int(word) for word in words.get("COUNT", ["1"] * len(names))]
        kinds = [word.upper() for word in words["TYPE"]]
        grid = int(words["WIDTH"][0]) * int(words.get("HEIGHT", ["1"])[0])
        points = min(grid, int(words["POINTS"][0])) if "POINTS" in words else grid
        viewpoint = tuple(float(word) for word in words.get("VIEWPOINT", []))
        encoding = words["DATA"][0].lower()
    except (KeyError, ValueError, IndexError) as error:
        raise Malformed(f"the header is incomplete or damaged: {error}") from None
    if not len(names) == len(sizes) == len(kinds) == len(counts) or min(counts, default=0) < 0:
        raise Malformed("FIELDS, SIZE, TYPE and COUNT have different lengths")
    if not set(zip(kinds, sizes, strict=True)) <= _TYPES:
        raise Malformed("has a field whose TYPE and SIZE do not match")
    if not 0 <= points <= POINT_LIMIT:
        raise Malformed(f"claims {points} points; up to {POINT_LIMIT} are read")
    if sum(name in _AXES for name in names) > len(_AXES):
        raise Malformed("names a field x, y or z twice")
    if "POINTS" in words and grid != int(words["POINTS"][0]):
        doubts += [f"WIDTH and HEIGHT are {grid} points, POINTS {words['POINTS'][0][:20]}"]
    if encoding not in ENCODINGS:
        raise Malformed(f"DATA {encoding[:20]!r} is unknown")
    if len(viewpoint) not in {0, 7}:
        raise Malformed("VIEWPOINT needs seven numbers")
    fields = list(zip(names, kinds, sizes, counts, strict=True))
    return Header(
        points=points,
        step=sum(size * count for _, _, size, count in fields),
        columns=sum(counts),
        axes=(_axis("x", fields), _axis("y", fields), _axis("z", fields)),
        viewpoint=viewpoint,
        encoding=encoding,
        start=start,
        doubts=tuple(doubts),
    )


def _entries(data: bytes) -> tuple[dict[str, list[str]], int, list[str]]:
    """Words of each entry of the header, the offset of the points, and contradictions."""
    words: dict[str, list[str]] = {}
    doubts: list[str] = []
    at = 0
    while "DATA" not in words:
        end = data.find(b"\n", at, _MAX_HEADER)
        if end < 0:
            raise Malformed("is not a PCD file, or cut within its header: DATA is missing", at)
        line = data[at:end].decode("latin-1").split("#")[0].split()
        at = end + 1
        if not line:
            continue
        key = line[0].upper()
        if key not in _KEYS:
            doubts.append(f"an entry {line[0][:20]!r} of the header is unknown")
        elif key in words:
            raise Malformed(f"the header has {key} twice")
        words[key] = line[1:]
    return words, at, doubts


def _axis(name: str, fields: list[tuple[str, str, int, int]]) -> Field:
    before = column = 0
    for called, kind, size, count in fields:
        if called == name and count > 0:
            return Field(np.dtype(f"<{kind.lower()}{size}"), before, size * count, column)
        before += size * count
        column += count
    raise Malformed(f"has no field {name}")


_MAX_FILE = 1 << 31
_LZF_RATIO = 265 / 3
"""Maximum number of bytes per compressed byte: three can copy 7 + 255 + 2 and one more."""
_UNIT = 0.01
"""Maximum deviation of the norm of VIEWPOINT's quaternion from 1."""


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
        header = read_header(data)
        points, cut = _DECODERS[header.encoding](data, header)
    except Malformed as error:
        raise RecordingError(error.problem, file=file, offset=error.offset) from None
    if len(points) == 0 and cut is not None:
        raise RecordingError(cut.problem, file=file, offset=cut.offset)
    damage = [RecordingError(doubt, file=file) for doubt in header.doubts]
    damage += [RecordingError(cut.problem, file=file, offset=cut.offset)] if cut else []
    pose, mount = AT_REST, UNKNOWN_MOUNT
    v = header.viewpoint
    if v and _is_pose(v):
        X_MS = matrix((*v[:3], *v[4:], v[3]))
        pose = planar(X_MS)
        mount = np.array([0.0, 0.0, np.nan, *fixed_axes(X_MS)[3:5], 0.0])
        points = _seen_from(X_MS, points)
    elif v:
        damage.append(RecordingError("VIEWPOINT is not a pose, ignored", file=file))
    points, far = checked_points(points, file)
    return CloudSweep(
        points=points,
        range_max=max_range(points),
        mount=mount,
        pose=pose,
        damage=(*damage, *far),
    )


def _is_pose(viewpoint: tuple[float, ...]) -> bool:
    position, turn = np.abs(viewpoint[:3]), np.abs(viewpoint[3:])
    # A large finite number overflows in the norm.
    within = bool(np.all(position <= MAX_COORDINATE) and np.all(turn <= 1.0 + _UNIT))
    return within and abs(float(np.linalg.norm(turn)) - 1.0) < _UNIT


def _ascii(data: bytes, header: Header) -> tuple[Floats32, _Cut | None]:
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
        at = end + 1 if end >= 0 else len(data)
        if end < 0:
            break
    return _table(rows), _missing(len(rows), header, len(data)) or _left(data[at:], header, at)


def _table(rows: list[tuple[float, ...]]) -> Floats32:
    return _single(np.array(rows, dtype=np.float64).reshape(-1, 3))


def _binary(data: bytes, header: Header) -> tuple[Floats32, _Cut | None]:
    there = min((len(data) - header.start) // header.step, header.points)
    block = np.frombuffer(data, dtype=np.uint8, count=there * header.step, offset=header.start)
    points = np.empty((there, 3), dtype=np.float32)
    for k, field in enumerate(header.axes):
        points[:, k] = _numbers(block, field, there, field.before, header.step)
    end = header.start + there * header.step
    return points, _missing(there, header, end) or _left(data[end:], header, end)


def _compressed(data: bytes, header: Header) -> tuple[Floats32, _Cut | None]:
    if len(data) < header.start + 8:
        raise Malformed("is cut before its points", len(data))
    packed, size = struct.unpack_from("<II", data, header.start)
    begin = header.start + 8
    needed = header.points * header.step
    if size < needed or size > _LZF_RATIO * packed + 1:
        problem = f"{packed} bytes, {size} unpacked, cannot be {header.points} points"
        raise Malformed(f"{problem} of {header.step}, {needed} bytes", header.start)
    block = decompress_lzf(data[begin : begin + packed], size)
    there = header.points
    for field in header.axes:
        have = (len(block) - field.before * header.points) // field.stride
        there = min(there, max(have, 0))
    points = np.empty((there, 3), dtype=np.float32)
    for k, field in enumerate(header.axes):
        points[:, k] = _numbers(block, field, there, field.before * header.points, field.stride)
    end = min(begin + packed, len(data))
    rest = block[needed:].tobytes() + data[end:]
    return points, _missing(there, header, end) or _left(rest, header, end)


_DECODERS: dict[str, Callable[[bytes, Header], tuple[Floats32, _Cut | None]]] = {
    "ascii": _ascii,
    "binary": _binary,
    "binary_compressed": _compressed,
}


def _numbers(
    block: NDArray[np.uint8], field: Field, count: int, first: int, stride: int
) -> NDArray[Any]:
    if count == 0:
        return np.empty(0)
    column: NDArray[Any] = np.ndarray(
        count, dtype=field.type, buffer=block, offset=first, strides=(stride,)
    )
    return _single(column)


def _single(numbers: NDArray[Any]) -> Floats32:
    """Single precision of numbers; finite ones stay finite, so that absurd ones are detected."""
    largest = np.finfo(np.float32).max
    with np.errstate(over="ignore", invalid="ignore"):
        single = numbers.astype(np.float32)
        return np.where(np.isinf(single) & np.isfinite(numbers), largest, single)


def _missing(there: int, header: Header, offset: int) -> _Cut | None:
    if there == header.points:
        return None
    return _Cut(f"ends or is damaged after {there} of {header.points} points", offset)


def _left(rest: bytes, header: Header, offset: int) -> _Cut | None:
    # Text editors add a line break; writers that reserve space leave zeros.
    more = len(rest.strip(b"\0 \t\r\n"))
    if more == 0:
        return None
    return _Cut(
        f"has {more} more bytes than {header.points} points: its header may be wrong", offset
    )


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


@njit(**CACHED)
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
