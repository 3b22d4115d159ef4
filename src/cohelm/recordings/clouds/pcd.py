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
_MAX_FILE = 1 << 31
_LZF_RATIO = 265 / 3
"""Maximum number of bytes per compressed byte: three can copy 7 + 255 + 2 and one more."""
_UNIT = 0.01
"""Maximum deviation of the norm of VIEWPOINT's quaternion from 1."""
_AXES = ["x", "y", "z"]
_NUMBERS = {"F4", "F8", *(f"{kind}{size}" for kind in "IU" for size in (1, 2, 4, 8))}


class Header(NamedTuple):
    """Content of the header."""

    points: int
    """Number of points."""
    names: list[str]
    """Names of the fields."""
    point: np.dtype[Any]
    """Layout of a point; its fields are named by their numbers."""
    viewpoint: tuple[float, ...]
    """Position, m, and quaternion (w, x, y, z) of the sensor; empty: not given."""
    encoding: str
    """One of :data:`ENCODINGS`."""


def read_header(data: bytes) -> tuple[Header, bytes]:
    """Read the header of a file; returns it with the bytes that follow.

    Raises:
        ValueError: if it is incomplete or contradicts itself.
    """
    words: dict[str, list[str]] = {}
    at = 0
    while "DATA" not in words:
        end = data.find(b"\n", at, _MAX_HEADER)
        if end < 0:
            raise ValueError("is not a PCD file, or cut within its header: DATA is missing")
        line = data[at:end].decode("latin-1").split("#")[0].split()
        at = end + 1
        if line and line[0].upper() in words:
            raise ValueError(f"the header has {line[0][:20]} twice")
        if line:
            words[line[0].upper()] = line[1:]
    try:
        names = words["FIELDS"] if "FIELDS" in words else words["COLUMNS"]
        counts = [int(word) for word in words.get("COUNT", ["1"] * len(names))]
        pairs = zip(words["TYPE"], words["SIZE"], strict=True)
        kinds = [f"{kind.upper()}{int(size)}" for kind, size in pairs]
        grid = int(words["WIDTH"][0]) * int(words.get("HEIGHT", ["1"])[0])
        points = int(words["POINTS"][0]) if "POINTS" in words else grid
        viewpoint = tuple(float(word) for word in words.get("VIEWPOINT", []))
        encoding = words["DATA"][0].lower()
    except (KeyError, ValueError, IndexError) as error:
        raise ValueError(f"the header is incomplete or damaged: {error}") from None
    if not len(names) == len(kinds) == len(counts) or min(counts, default=0) < 0:
        raise ValueError("FIELDS, SIZE, TYPE and COUNT do not match")
    if not set(kinds) <= _NUMBERS:
        raise ValueError("has a field whose TYPE and SIZE do not match")
    if points != grid or not 0 <= points <= POINT_LIMIT:
        raise ValueError(
            f"WIDTH and HEIGHT are {grid} points, POINTS {points}; up to {POINT_LIMIT} are read"
        )
    if sorted(name for name in names if name in _AXES) != _AXES:
        raise ValueError("does not have one field each of x, y and z")
    if encoding not in ENCODINGS:
        raise ValueError(f"DATA {encoding[:20]!r} is unknown")
    if len(viewpoint) not in {0, 7}:
        raise ValueError("VIEWPOINT needs seven numbers")
    fields = [
        (str(k), f"<{kind.lower()}", (count,))
        for k, (kind, count) in enumerate(zip(kinds, counts, strict=True))
    ]
    return Header(points, names, np.dtype(fields), viewpoint, encoding), data[at:]


def looks_like_pcd(start: bytes) -> bool:
    """Check that a file with this beginning is a PCD file."""
    words = start.lstrip().split()
    return b".PCD" in start[:200] or (bool(words) and words[0] in {b"VERSION", b"FIELDS"})


def read_pcd(file: Path) -> CloudSweep:
    """Read a PCD file; the range is that of its farthest point.

    Raises:
        RecordingError: if it is not a PCD file, contradicts itself, or has fewer or more points
            than it declares.
    """
    try:
        header, rest = read_header(read_bytes(file, _MAX_FILE))
        points = _ascii(rest, header) if header.encoding == "ascii" else _binary(rest, header)
    except (ValueError, OverflowError) as error:
        raise RecordingError(" ".join(str(error).split())[:200], file=file) from None
    damage: list[RecordingError] = []
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


def _ascii(data: bytes, header: Header) -> Floats32:
    lines = [line for line in data.decode("latin-1").splitlines() if line.strip("\0 \t")]
    _check_size(len(lines), header.points, "lines")
    counts = [header.point[k].shape[0] for k in range(len(header.names))]
    table = np.loadtxt(lines, comments=None, ndmin=2) if lines else np.empty((0, sum(counts)))
    if table.shape[1] != sum(counts):
        raise ValueError(f"has {table.shape[1]} numbers in a line instead of {sum(counts)}")
    first = dict(zip(header.names, np.cumsum([0, *counts]), strict=False))
    return _single(table[:, [first[axis] for axis in _AXES]])


def _binary(data: bytes, header: Header) -> Floats32:
    n, size = header.points, header.points * header.point.itemsize
    if header.encoding == "binary":
        # Writers that reserve space leave zeros, text editors a line break.
        _check_size(max(len(data.rstrip(b"\0\r\n")), min(len(data), size)), size, "bytes")
        block = np.frombuffer(data, dtype=header.point, count=n)
        columns = [block[str(header.names.index(axis))] for axis in _AXES]
    else:
        packed, unpacked = struct.unpack_from("<II", data.ljust(8, b"\0"))
        _check_size(unpacked, size, "unpacked bytes")
        if packed > len(data) - 8 or len(data[8 + packed :].rstrip(b"\0\r\n")):
            raise ValueError(f"has {len(data) - 8} compressed bytes instead of {packed}")
        plain = decompress_lzf(data[8 : 8 + packed], size)
        _check_size(len(plain), size, "unpacked bytes")
        columns, fields = [], dict(header.point.fields or {})
        for axis in _AXES:
            field, offset, *_ = fields[str(header.names.index(axis))]
            columns.append(np.frombuffer(plain, field, n, n * offset).reshape(n, -1))
    return np.column_stack([_single(column[:, 0]) for column in columns])


def _check_size(there: int, declared: int, unit: str) -> None:
    if there != declared:
        raise ValueError(
            f"is cut off or damaged: has {there} {unit} of points instead of {declared}"
        )


def _single(numbers: NDArray[Any]) -> Floats32:
    """Single precision of numbers; finite ones stay finite, so that absurd ones are detected."""
    largest = np.finfo(np.float32).max
    with np.errstate(over="ignore", invalid="ignore"):
        single = numbers.astype(np.float32)
        return np.where(np.isinf(single) & np.isfinite(numbers), largest, single)


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
