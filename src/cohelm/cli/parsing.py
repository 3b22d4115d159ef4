"""Parse points, places, zones and drawn lines that a command line gives."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.cli.requests import RouteRequest
from cohelm.errors import ConfigError, MapError
from cohelm.maps import MAX_COORDINATE, Places
from cohelm.messages import Wish

MAX_STROKE_POINTS = 100_000
ZONE_RADIUS = 0.5
"""Default radius of a zone about a point or a line, m."""


def place(text: str, key: str, *, heading: bool = False) -> str | tuple[float, ...]:
    """Parse ``x,y``, or ``x,y,degrees`` where a heading is allowed, or the name of a place.

    Raises:
        ConfigError: naming the option.
    """
    try:
        numbers = tuple(float(part) for part in text.split(","))
    except ValueError:
        if text.strip() and not text.strip()[0].isdigit():
            return text.strip()
        numbers = ()
    sizes = {2, 3} if heading else {2}
    if len(numbers) not in sizes or not all(abs(each) <= MAX_COORDINATE for each in numbers):
        form = "x,y or x,y,degrees" if heading else "x,y"
        raise ConfigError(f"write {form} in metres, or a place's name, got {text!r}", key=key)
    return numbers


def point(text: str, key: str) -> tuple[float, float]:
    """Parse ``x,y`` in metres.

    Raises:
        ConfigError: naming the option.
    """
    spot = place(text, key)
    if isinstance(spot, str) or len(spot) != 2:
        raise ConfigError(f"write a point as x,y in metres, as 3.5,-2, got {text!r}", key=key)
    return spot[0], spot[1]


def zone(text: str, key: str) -> tuple[list[tuple[float, float]], float]:
    """Parse a zone into points and radius: ``x,y[,radius]`` or ``x,y x,y x,y …[,radius]``, m.

    A point or a line without a radius has 0.5 m; an outline of three or more points has none.

    Raises:
        ConfigError: naming the option.
    """
    try:
        groups = [[float(part) for part in group.split(",")] for group in text.split()]
    except ValueError:
        groups = []
    sizes = [len(group) for group in groups]
    numbers = [abs(number) <= MAX_COORDINATE for group in groups for number in group]
    fits = bool(sizes) and set(sizes[:-1]) <= {2} and sizes[-1] in {2, 3} and all(numbers)
    radius = groups[-1][2] if fits and sizes[-1] == 3 else None
    if not fits or (radius is not None and radius <= 0.0):
        form = "x,y,radius or an outline as 'x,y x,y x,y', in metres, or name a place"
        raise ConfigError(f"write a zone as {form}, got {text[:80]!r}", key=key)
    if radius is None:
        radius = ZONE_RADIUS if len(groups) < 3 else 0.0
    corners = [(group[0], group[1]) for group in groups]
    if len(corners) == 3 and len(set(corners)) < 3:
        raise ConfigError(f"an outline needs three different corners, got {text[:80]!r}", key=key)
    return corners, radius


def wishes_of(request: RouteRequest, places: Places) -> tuple[Wish, ...]:
    """Wishes in the order given: points that attract, lines to follow, zones and places to avoid.

    Raises:
        ConfigError: naming the option, or the file and its line.
    """
    points = [np.array([point(text, "--prefer")]) for text in request.prefer]
    if request.ordered and points:
        points = [np.concatenate(points)]
    zones = [_avoided(text, "--avoid", places, hard=False) for text in request.avoid]
    zones += [_avoided(text, "--avoid-hard", places, hard=True) for text in request.avoid_hard]
    strokes = [Wish(kind="stroke", points=read_stroke(file)) for file in request.stroke]
    return (*(Wish(points=each) for each in points), *strokes, *zones)


def _avoided(text: str, key: str, places: Places, *, hard: bool) -> Wish:
    if text.strip()[:1].isalpha():
        try:
            area = places.find(text.strip()).polygon
        except MapError as cause:
            raise ConfigError(cause.problem, key=key) from None
        if area is None:
            raise ConfigError(f"{text.strip()!r} is a point; name an area or a zone", key=key)
        return Wish(kind="avoid", points=area, hard=hard)
    corners, radius = zone(text, key)
    return Wish(kind="avoid", points=np.array(corners), radius=radius, hard=hard)


def read_stroke(file: Path) -> Floats:
    """Read a drawn line (k, 2), k ≥ 2, m: lines of ``x,y``, a JSON list of [x, y], or GeoJSON.

    In GeoJSON the first LineString is used; its coordinates are metres in the map frame.

    Raises:
        ConfigError: naming the file, and the line where there is one at fault.
    """
    try:
        text = file.read_text(encoding="utf-8-sig")
    except (OSError, ValueError) as cause:
        what = getattr(cause, "strerror", None) or "not UTF-8 text"
        raise ConfigError(f"cannot be read ({what})", file=file, key="--stroke") from None
    given = _from_json(text, file) if text.lstrip()[:1] in {"[", "{"} else _from_csv(text, file)
    if len(given) < 2:
        raise _bad(file, "a drawn line needs at least two points")
    if len(given) > MAX_STROKE_POINTS:
        raise _bad(file, f"has {len(given)} points; at most {MAX_STROKE_POINTS} are read")
    for point in given:
        if not (len(point) >= 2 and all(_is_coordinate(each) for each in point[:2])):
            raise _bad(file, f"write points as [x, y] in metres, got {str(point)[:60]}")
    return np.array([point[:2] for point in given], dtype=float)


def _from_csv(text: str, file: Path) -> list[Any]:
    """Parse lines ``x,y``; skip blank lines, lines with # and a first line of headings."""
    points: list[Any] = []
    for number, cells in enumerate(csv.reader(text.splitlines()), start=1):
        if not cells or not "".join(cells).strip() or cells[0].lstrip().startswith("#"):
            continue
        try:
            x, y = (float(each) for each in cells[:2])
        except ValueError:
            if not points and number == 1:
                continue
            shown = ",".join(cells)[:60]
            raise _bad(file, f"line {number}: write x,y in metres, got {shown!r}") from None
        points.append([x, y])
    return points


def _from_json(text: str, file: Path) -> list[Any]:
    try:
        data = json.loads(text)
    except (ValueError, RecursionError) as cause:
        what = getattr(cause, "msg", "nested too deeply")
        line = getattr(cause, "lineno", None)
        raise _bad(file, f"not JSON: {'' if line is None else f'line {line}: '}{what}") from None
    line = _line_string(data)
    if not (isinstance(line, list) and all(isinstance(point, list) for point in line)):
        raise _bad(file, "holds no list of [x, y] and no GeoJSON LineString")
    return line


def _line_string(data: Any) -> Any:
    """Find the coordinates of the first LineString in GeoJSON; a bare list counts as one."""
    if not isinstance(data, dict):
        return data
    if data.get("type") == "LineString":
        return data.get("coordinates")
    if data.get("type") == "Feature":
        return _line_string(data.get("geometry"))
    for each in data.get("features") or data.get("geometries") or ():
        found = _line_string(each) if isinstance(each, dict) else None
        if found is not None:
            return found
    return None


def _is_coordinate(each: Any) -> bool:
    number = isinstance(each, int | float) and not isinstance(each, bool)
    return number and abs(each) <= MAX_COORDINATE  # nor is inf or NaN


def _bad(file: Path, problem: str) -> ConfigError:
    return ConfigError(problem, file=file, key="--stroke")
