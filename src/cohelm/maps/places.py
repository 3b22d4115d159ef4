"""Named places on a map: destinations and areas."""

from __future__ import annotations

import heapq
import math
from collections.abc import Iterator, Mapping
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import ArrayLike

from cohelm import config
from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.config import nearest
from cohelm.errors import ConfigError, MapError
from cohelm.geometry import distance_to_polygon
from cohelm.maps.grid import MAX_COORDINATE

_KEYS = ("point", "polygon", "names")
"""Keys of a place in a file."""


@value
class NamedPlace:
    """Named point, or named area with a point in it."""

    name: str
    point: Annotated[Floats, Shape("2")]
    """Destination of the place; map frame, m."""
    polygon: Annotated[Floats, Shape("k 2")] | None = None
    """Corners of the area in order; map frame, m."""
    names: Mapping[str, str] = field(default_factory=dict)
    """The name in other languages, by their code (``de``)."""

    def contains(self, point: ArrayLike) -> bool:
        """Check that a map point (2,) lies in the area; a place without an area contains none."""
        x, y = np.asarray(point, dtype=float)
        return self.polygon is not None and distance_to_polygon(self.polygon, x, y) < 0.0


@value
class Places:
    """Named places of one map; names, in every language, are not case-sensitive."""

    places: tuple[NamedPlace, ...] = ()
    source: str = "this map"
    """Source of the names, for error messages."""

    def __iter__(self) -> Iterator[NamedPlace]:
        return iter(self.places)

    def __len__(self) -> int:
        return len(self.places)

    @property
    def names(self) -> tuple[str, ...]:
        """All names, in the order of the file."""
        return tuple(place.name for place in self.places)

    def find(self, name: str) -> NamedPlace:
        """The place of that name.

        Raises:
            MapError: if there is none; names the nearest, or all.
        """
        wanted = _folded(name)
        found = [place for place in self.places if _folded(place.name) == wanted]
        found += [p for p in self.places if wanted in map(_folded, p.names.values())]
        if found:
            return found[0]
        if not self.places:
            raise MapError(f"no place {name!r}: this map has no named places", file=self.source)
        raise MapError(f"no place {name!r}{nearest(name, self.names)}", file=self.source)

    def at(self, point: ArrayLike) -> str:
        """Name of the smallest area that a map point (2,) lies in; empty where it lies in none."""
        around = [(_area(p.polygon), p.name) for p in self.places if p.contains(point)]
        return min(around)[1] if around else ""


def read_places(file: Path | str) -> Places:
    """The places that a YAML file names.

    A place is a point ``Reception: [x, y]``, or an area ``Ward 3: {polygon: [[x, y], …]}``, whose
    point is then the innermost one unless ``point: [x, y]`` says otherwise. Its ``names:
    {de: Station 3}`` are those in other languages.

    Raises:
        MapError: if the file is missing or invalid; names file and place.
    """
    file = Path(file)
    try:
        data = config.read_yaml(file)
    except ConfigError as cause:
        raise MapError(cause.problem, file=file) from None
    found: dict[str, NamedPlace] = {}
    for key, given in data.items():
        name = str(key).strip()
        if not name or _folded(name) in found:
            raise MapError(
                f"{name!r}: each place needs its own name, which is not empty", file=file
            )
        try:
            found[_folded(name)] = _place(name, given)
        except ValueError as cause:
            raise MapError(f"{name}: {cause}", file=file) from None
    return Places(places=tuple(found.values()), source=str(file))


def places_beside(map_file: Path | str) -> Places:
    """The places in ``<stem>.places.yaml`` beside a map file; none where there is no such file.

    Raises:
        MapError: see :func:`read_places`.
    """
    map_file = Path(map_file)
    file = map_file.with_name(f"{map_file.stem}.places.yaml")
    return read_places(file) if file.is_file() else Places(source=str(map_file))


def write_places(places: Places, file: Path | str) -> None:
    """Write places such that :func:`read_places` gives them back.

    Raises:
        MapError: if the file cannot be written.
    """
    data: dict[str, Any] = {}
    for place in places:
        point = place.point.tolist()
        area = {} if place.polygon is None else {"polygon": place.polygon.tolist()}
        more = {**area, **({"names": dict(place.names)} if place.names else {})}
        data[place.name] = {**more, "point": point} if more else point
    text = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, allow_unicode=True)
    try:
        Path(file).write_text(text, encoding="utf-8")
    except OSError as cause:
        raise MapError(f"cannot be written ({cause})", file=file) from cause


def innermost_point(polygon: Floats, *, precision: float = 0.01) -> Floats:
    """The point (2,) of a simple polygon (k, 2) farthest from its edges, to ``precision``, m.

    Where the polygon is longer than 2000 times that, to a 2000th of its length.

    Best-first subdivision of the bounding box: a square of half side s around a point at distance d
    from the edges holds no point farther in than d + s·√2.
    """
    (x0, y0), (x1, y1) = polygon.min(axis=0), polygon.max(axis=0)
    long, short = max(x1 - x0, y1 - y0), min(x1 - x0, y1 - y0)
    precision = max(precision, long / 2000.0)  # limits the number of squares along a narrow polygon
    half = max(short, precision) / 2.0
    best = -np.inf, 0.0, 0.0
    squares: list[tuple[float, float, float, float]] = []

    def consider(x: float, y: float, half: float) -> None:
        nonlocal best
        inside = -distance_to_polygon(polygon, x, y)
        best = max(best, (inside, x, y))
        heapq.heappush(squares, (-(inside + half * math.sqrt(2.0)), x, y, half))

    for x in np.arange(x0 + half, x1 + half, 2.0 * half):
        for y in np.arange(y0 + half, y1 + half, 2.0 * half):
            consider(float(x), float(y), half)
    while squares:
        bound, x, y, half = heapq.heappop(squares)
        if -bound <= best[0] + precision:
            break
        quarter = half / 2.0
        for dx in (-quarter, quarter):
            for dy in (-quarter, quarter):
                consider(x + dx, y + dy, quarter)
    return np.array(best[1:])


def _place(name: str, given: Any) -> NamedPlace:
    if isinstance(given, dict):
        for key in given:
            if key not in _KEYS:
                raise ValueError(f"unknown key {key!r}{nearest(str(key), _KEYS)}")
        polygon = _polygon(given["polygon"]) if "polygon" in given else None
        names = _names(given.get("names", {}))
        if "point" in given:
            point = _point(given["point"])
            return NamedPlace(name=name, point=point, polygon=polygon, names=names)
        if polygon is not None:
            point = innermost_point(polygon)
            return NamedPlace(name=name, point=point, polygon=polygon, names=names)
    elif isinstance(given, list):
        return NamedPlace(name=name, point=_point(given))
    raise ValueError("must be a point [x, y], or {polygon: [[x, y], …]}")


def _names(given: Any) -> dict[str, str]:
    if not isinstance(given, dict) or not all(
        isinstance(part, str) and part.strip() for pair in given.items() for part in pair
    ):
        raise ValueError("names are a mapping from languages, as in {de: Station 3}")
    return {language: " ".join(name.split()) for language, name in given.items()}


def _point(given: Any) -> Floats:
    point = _numbers(given)
    if point.shape != (2,):
        raise ValueError(f"a point is two finite numbers [x, y], got {given!r}")
    return point


def _polygon(given: Any) -> Floats:
    polygon = _numbers(given)
    if polygon.ndim != 2 or polygon.shape[1] != 2 or len(polygon) < 3:
        raise ValueError("a polygon is three or more points [x, y] of finite numbers")
    if _area(polygon) < 1e-6:
        raise ValueError("the polygon has no area")
    return polygon


def _numbers(given: Any) -> Floats:
    """``given`` as an array; an empty one where it is not finite numbers in a regular nesting."""
    try:
        array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        return np.empty(0)
    return array if (np.abs(array) <= MAX_COORDINATE).all() else np.empty(0)


def _area(polygon: Floats | None) -> float:
    if polygon is None:
        return 0.0
    x, y = polygon.T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


def _folded(name: str) -> str:
    return " ".join(name.split()).casefold()
