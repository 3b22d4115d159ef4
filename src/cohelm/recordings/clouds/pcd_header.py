"""Header of a PCD file: names, types and number of the fields of a point, and contradictions."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from cohelm.recordings.clouds.sweep import POINT_LIMIT

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
