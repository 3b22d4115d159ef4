"""Buildings given as outlines: IndoorGML cell spaces, and areas and passages of osmAG.

IndoorGML 1.0 (OGC 14-005r5) without a coordinate system is taken as metres. osmAG (Feng et al.,
osmAG: hierarchical semantic topometric area graph maps in the OSM format, 2023) has degrees.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal, NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
import shapely
from scipy import ndimage

from cohelm.arrays import Floats, replace
from cohelm.buildings.ifc_file import SIZE_LIMIT, file_stems
from cohelm.buildings.storey import (
    BuildingStorey,
    Door,
    Room,
    StoreyLink,
    polygon_cells,
    room_cells,
    unknown_grid,
    with_rooms,
)
from cohelm.errors import BuildingError
from cohelm.maps import FREE, OCCUPIED

_EARTH = 6_378_137.0
"""Radius of the Earth at the equator, m (WGS 84)."""
_GML, _ID = "{http://www.opengis.net/gml/3.2}", "{http://www.opengis.net/gml/3.2}id"
_NOTE = "walls are drawn along the outlines of the rooms; heights and thresholds are not known"


class _Part(NamedTuple):
    """Room, door, stairs or piece of furniture."""

    kind: Literal["room", "door", "stairs", "furniture"]
    id: str
    name: str
    storey: str
    height: float
    """Orders the storeys; m, or the level."""
    points: Floats
    """Outline (k, 2), or the two ends of a door; m."""


def read_outlines(
    file: Path, *, storey: str | None, resolution: float
) -> tuple[BuildingStorey, ...]:
    """Storeys of an IndoorGML (.gml) or osmAG file (.osm), lowest first.

    Raises:
        BuildingError: if it cannot be read, has no outline of a room, or no such storey.
    """
    try:
        if file.stat().st_size > SIZE_LIMIT:
            raise BuildingError(f"more than {SIZE_LIMIT / 1e6:.0f} MB", file=file)
        root = ET.parse(file, ET.XMLParser(target=_WithoutDocumentType())).getroot()
        parts = list(_osm_ag(root) if file.suffix.lower() == ".osm" else _indoor_gml(root))
        return _storeys(parts, storey, resolution, file)
    except (OSError, ET.ParseError, ValueError, LookupError, ArithmeticError) as cause:
        raise BuildingError(f"cannot be read ({cause})", file=file) from None


class _WithoutDocumentType(ET.TreeBuilder):
    """Refuses document types, whose entities may expand without end."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise ValueError(f"a document type is not read: {name}, {pubid}, {system}")


def _storeys(
    parts: Sequence[_Part], storey: str | None, resolution: float, file: Path
) -> tuple[BuildingStorey, ...]:
    names = sorted({each.storey for each in parts if each.kind == "room"})
    if not names:
        problem = "no room with an outline: IndoorGML needs the geometry of its cell spaces, osmAG "
        raise BuildingError(f"{problem}ways with osmAG:type = area", file=file)
    names.sort(key=lambda name: min(each.height for each in parts if each.storey == name))
    stems = file_stems(names)
    chosen = [
        number
        for number, name in enumerate(names, 1)
        if storey is None or storey.strip().casefold() in {str(number), name.casefold()}
    ]
    if not chosen:
        raise BuildingError(f"no storey {storey!r}: there are {', '.join(names)}", file=file)
    return tuple(
        replace(
            _storey([each for each in parts if each.storey == names[n - 1]], resolution, file),
            number=n, stem=stems[n - 1],
        )
        for n in chosen
    )  # fmt: skip


def _indoor_gml(root: ET.Element) -> Iterator[_Part]:
    for cell in root.iter():
        rings = [
            " ".join(place.text or "" for place in ring if place.tag.startswith(f"{_GML}pos"))
            for geometry in cell.findall("{*}cellSpaceGeometry")
            for ring in geometry.iter(f"{_GML}LinearRing")
        ]
        if not rings:
            continue
        size = 3 if cell.find(".//{*}Geometry3D") is not None else 2
        shapes = [np.array(ring.split(), dtype=float).reshape(-1, size)[:-1] for ring in rings]
        # The floor: the lowest ring, and the largest in plan of those.
        floor = min(shapes, key=lambda p: (p[:, 2:].sum().round(2) / len(p), -_area(p)))
        height = float(floor[:, 2:].sum() / len(floor))
        name = (cell.findtext(f"{_GML}name") or cell.get(_ID) or "").strip()
        about = cell.findtext(f"{_GML}description") or ""
        level = re.search(r'storey\s*=\s*"([^"]+)"', about)
        words = f"{cell.tag.partition('}')[2]} {cell.get(_ID, '')} {name} {about}".casefold()
        is_door = re.search(r"\b_?door|connectionspace", words) is not None
        is_stair = re.search(r"\bstair", words) is not None
        kind: Literal["room", "door", "stairs"] = "stairs" if is_stair else "room"
        yield _Part(
            "door" if is_door else kind, cell.get(_ID, name), name,
            level[1] if level else f"{height:g} m", height, floor[:, :2],
        )  # fmt: skip


def _osm_ag(root: ET.Element) -> Iterator[_Part]:
    nodes = {node.get("id"): (node.get("lon"), node.get("lat")) for node in root.iter("node")}
    degrees = np.radians(np.array(list(nodes.values()) or np.zeros((1, 2)), dtype=float))
    middle = degrees.mean(axis=0)
    metres = (degrees - middle) * _EARTH * np.array([np.cos(middle[1]), 1.0])
    points = dict(zip(nodes, metres, strict=False))
    for way in root.iter("way"):
        tags = {tag.get("k", ""): tag.get("v", "") for tag in way.iter("tag")}
        line = np.array([points[nd.get("ref")] for nd in way.iter("nd")])
        level, name = tags.get("level", "0"), tags.get("name", way.get("id", ""))
        kind: Literal["room", "door", "stairs", "furniture"] = "furniture"
        if tags.get("osmAG:type") == "passage":
            kind = "door"
        elif tags.get("osmAG:type") == "area":
            kind = "stairs" if "stair" in tags.get("osmAG:areaType", "") else "room"
        elif "osmAG:furniture_type" not in tags:
            continue
        if tags.get("osmAG:areaType") != "structure":
            yield _Part(
                kind, way.get("id", name), name, f"Level {level}", float(level),
                line[:-1] if len(line) > 2 else line,
            )  # fmt: skip


def _storey(parts: Sequence[_Part], resolution: float, file: Path) -> BuildingStorey:
    """Map of a storey with its rooms, doors and stairs."""
    name, height = parts[0].storey, min(each.height for each in parts)
    grid = unknown_grid(np.concatenate([e.points for e in parts]), resolution, name, file)
    rooms = [
        Room(id=e.id, number="", name=e.name, polygons=(e.points,), area=_area(e.points))
        for e in parts
        if e.kind == "room"
    ]
    data = grid.data.copy()
    for room in rooms:
        cells = room_cells(room, grid)
        data[cells & (data != OCCUPIED)] = FREE
        data[cells & ~ndimage.binary_erosion(cells)] = OCCUPIED
    doors = [_door(e, resolution) for e in parts if e.kind == "door"]
    # Cells that the outline touches are filled too: no wider than the door.
    halves = [max(door.width / 2 - resolution, 0.0) for door in doors]
    through = [d.part(-half, half, 1.5 * resolution) for d, half in zip(doors, halves, strict=True)]
    data[polygon_cells(through, grid)] = FREE
    for kind in ("stairs", "furniture"):
        data[polygon_cells([e.points for e in parts if e.kind == kind], grid)] = OCCUPIED
    links = (
        StoreyLink(id=e.id, kind="stairs", name=e.name, polygon=e.points)
        for e in parts
        if e.kind == "stairs"
    )
    return BuildingStorey(
        name=name, stem="", elevation=height, grid=replace(grid, data=data), rooms=tuple(rooms),
        doors=tuple(with_rooms(door, rooms) for door in doors), links=tuple(links), notes=(_NOTE,),
    )  # fmt: skip


def _door(part: _Part, resolution: float) -> Door:
    """Door of an outline, by its smallest rectangle; a line is a door in a wall of two cells."""
    ends, depth = part.points, 2.0 * resolution
    if len(ends) > 2:
        box = shapely.minimum_rotated_rectangle(shapely.Polygon(ends))
        corners = np.array(shapely.get_coordinates(box))
        sides = np.linalg.norm(np.diff(corners[:3], axis=0), axis=1)
        # The middles of the short sides.
        corners, depth = np.roll(corners[:4], -int(np.argmax(sides)), axis=0), float(sides.min())
        ends = (corners[[0, 1]] + corners[[3, 2]]) / 2.0
    along = ends[1] - ends[0]
    width = float(np.hypot(*along))
    if not width:
        raise ValueError(f"the door {part.id} has no width")
    return Door(
        id=part.id, kind="door", name=part.name, point=ends.mean(axis=0), direction=along / width,
        width=width, opening=width, width_from="opening", depth=depth,
    )  # fmt: skip


def _area(points: Floats) -> float:
    return float(shapely.Polygon(points[:, :2]).area)
