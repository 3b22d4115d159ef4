"""What the rider wants of a route, from the options and files of a command line."""

from __future__ import annotations

import csv
import json
import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from cohelm.arrays import Floats
from cohelm.cli import words
from cohelm.errors import ConfigError
from cohelm.maps import FARTHEST
from cohelm.messages import Wish

MOST_POINTS = 100_000
"""Of a drawn line."""


@dataclass(frozen=True)
class Asked:
    """What the options say of wishes."""

    prefer: tuple[str, ...] = ()
    ordered: bool = False
    avoid: tuple[str, ...] = ()
    avoid_hard: tuple[str, ...] = ()
    stroke: tuple[Path, ...] = ()


def wishes_of(asked: Asked) -> tuple[Wish, ...]:
    """Points that attract, lines to follow, zones to avoid; each in the order given.

    Raises:
        ConfigError: naming the option, or the file and its line.
    """
    points = [np.array([words.point(text, "--prefer")]) for text in asked.prefer]
    if asked.ordered and points:
        points = [np.concatenate(points)]
    zones = [_zone(text, "--avoid", hard=False) for text in asked.avoid]
    zones += [_zone(text, "--avoid-hard", hard=True) for text in asked.avoid_hard]
    strokes = [Wish(kind="stroke", points=read_stroke(file)) for file in asked.stroke]
    return (*(Wish(points=each) for each in points), *strokes, *zones)


def _zone(text: str, key: str, *, hard: bool) -> Wish:
    corners, radius = words.zone(text, key)
    return Wish(kind="avoid", points=np.array(corners), radius=radius, hard=hard)


def read_stroke(file: Path) -> Floats:
    """A drawn line (k, 2), k ≥ 2, m: lines of ``x,y``, a JSON list of [x, y], or GeoJSON.

    Of GeoJSON the first LineString counts, and its coordinates are metres of the map frame.

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
        raise _bad(file, "a line to follow has two points or more")
    if len(given) > MOST_POINTS:
        raise _bad(file, f"has {len(given)} points; more than {MOST_POINTS} are no drawn line")
    for point in given:
        if not (len(point) >= 2 and all(_is_coordinate(each) for each in point[:2])):
            raise _bad(file, f"write points as [x, y] in metres, got {str(point)[:60]}")
    return np.array([point[:2] for point in given], dtype=float)


def _from_csv(text: str, file: Path) -> list[Any]:
    """Points of lines ``x,y``; blank lines, lines with # and a line of headings are skipped."""
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
    """The coordinates of the first LineString in GeoJSON; a bare list is one."""
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
    return number and math.isfinite(each) and abs(each) <= FARTHEST


def _bad(file: Path, problem: str) -> ConfigError:
    return ConfigError(problem, file=file, key="--stroke")
