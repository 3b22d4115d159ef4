"""Storeys of an IFC model: the map that a chair meets, rooms from spaces, doors, lifts, stairs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import shapely
from scipy import ndimage

from cohelm.arrays import Booleans, Floats, replace
from cohelm.buildings.free_space import open_borders, partition
from cohelm.buildings.ifc_doors import DIFFERENT_LEVEL, door_openings, lining_posts
from cohelm.buildings.ifc_file import (
    JOINED,
    Entity,
    IfcLevel,
    IfcModel,
    decomposition,
    entity_name,
    file_stems,
    meshes,
    open_ifc,
)
from cohelm.buildings.sections import Mesh, covered_cells, touched_cells, upward
from cohelm.buildings.storey import (
    BuildingStorey,
    Door,
    LinkKind,
    Room,
    StoreyLink,
    polygon_cells,
    room_cells,
    unknown_grid,
    with_rooms,
)
from cohelm.buildings.storey_files import Watch
from cohelm.errors import BuildingError
from cohelm.maps import FREE, OCCUPIED, OccupancyGrid

BAND = (0.05, 1.2)
"""Heights above the floor at which a chair and its rider meet things, m."""
HEADROOM = 2.0
"""Height above the floor up to which stairs are in the way, m: floor below them is low."""
_STEP = 0.05
"""Largest height of a floor above the storey's, m; higher ones are steps."""
_NO_OBSTACLE = ("IfcFeatureElement", "IfcVirtualElement", "IfcDoor")
_FLOORS = ("IfcSlab", "IfcCovering", "IfcRamp", "IfcRampFlight")
_LINKS: dict[str, LinkKind] = {
    "IfcTransportElement": "lift", "IfcStair": "stairs", "IfcStairFlight": "stairs",
    "IfcRamp": "ramp", "IfcRampFlight": "ramp",
}  # fmt: skip
_STAIRS = ("IfcStair", "IfcStairFlight", "IfcRamp", "IfcRampFlight")
_NO_LIFTS = {"ESCALATOR", "MOVINGWALKWAY", "CRANEWAY", "LIFTINGGEAR"}


@dataclass(frozen=True, kw_only=True)
class _Bodies:
    """Meshes of a model by entity number."""

    meshes: dict[int, Mesh]
    solids: list[Mesh]
    """Of all products that can be in the way."""
    stairs: list[Mesh]
    """Those of stairs and ramps among them."""
    floors: Floats
    """Level triangles (t, 3, 3) of slabs, coverings and ramps, m."""


def read_ifc(
    file: Path, *, storey: str | None, resolution: float, watch: Watch
) -> tuple[BuildingStorey, ...]:
    """Storeys of an IFC model, lowest first; see :func:`~cohelm.buildings.read_building`.

    Raises:
        BuildingError: if the model cannot be read, has no such storey, or needs too many cells.
    """
    try:
        return _storeys(open_ifc(file), storey, resolution, watch)
    except (AssertionError, AttributeError, TypeError) as cause:
        # Every attribute of an entity may be absent, or refer to an entity of another class.
        raise BuildingError(f"not a valid IFC model ({cause})", file=file) from cause


def _storeys(
    model: IfcModel, storey: str | None, resolution: float, watch: Watch
) -> tuple[BuildingStorey, ...]:
    chosen = _chosen(model, storey)
    products = [*model.model.by_type("IfcElement"), *model.model.by_type("IfcSpace")]
    bodies = _bodies(products, meshes(model, products, watch))
    levels, stems = _by_height(model, bodies), file_stems([each.name for each in model.levels])
    return tuple(
        replace(_storey(model, level, bodies, resolution), number=number, stem=stem)
        for number, (level, given, stem) in enumerate(
            zip(levels, model.levels, stems, strict=True), 1
        )
        if given in chosen
    )


def _chosen(model: IfcModel, storey: str | None) -> Sequence[IfcLevel]:
    if storey is None:
        return model.levels
    wanted = storey.strip().casefold()
    named = [
        each
        for each in model.levels
        if wanted in {each.name.casefold(), *each.name.casefold().split(JOINED)}
    ]
    if not named and storey.isdecimal() and 1 <= int(storey) <= len(model.levels):
        named = [model.levels[int(storey) - 1]]
    if not named:
        names = ", ".join(f"{i} {each.name!r}" for i, each in enumerate(model.levels, 1))
        raise BuildingError(f"no storey {storey!r}: there are {names}", file=model.file)
    return named


def _bodies(products: Iterable[Entity], found: dict[int, Mesh]) -> _Bodies:
    def of(*classes: str, others: tuple[str, ...] = ()) -> list[Mesh]:
        return [
            found[each.id()]
            for each in products
            if each.id() in found
            and any(map(each.is_a, classes))
            and not any(map(each.is_a, others))
        ]

    floors = np.concatenate([np.empty((0, 3, 3)), *(mesh.triangles for mesh in of(*_FLOORS))])
    return _Bodies(
        meshes=found, solids=of("IfcElement", others=_NO_OBSTACLE), stairs=of(*_STAIRS),
        floors=floors[upward(floors)],
    )  # fmt: skip


def _by_height(model: IfcModel, bodies: _Bodies) -> list[IfcLevel]:
    """Levels at the heights of their floors, each with the doors and spaces that stand on it.

    Doors and spaces in no storey, or at a height that only another storey has, change over.
    """
    floors = np.array([_floor_height(level, bodies) for level in model.levels])
    held = [{each.id() for each in level.products} for level in model.levels]
    moved: list[list[Entity]] = [[] for _ in model.levels]
    notes: list[list[str]] = [[] for _ in model.levels]
    gone: set[tuple[int, int]] = set()
    for product in (*model.model.by_type("IfcDoor"), *model.model.by_type("IfcSpace")):
        body, key = bodies.meshes.get(product.id()), product.id()
        off = np.abs(floors - (np.inf if body is None else body.bounds[0, 2]))
        fits = int(np.argmin(off))
        if off[fits] > DIFFERENT_LEVEL:
            continue
        owners = [i for i, ids in enumerate(held) if key in ids]
        gone |= {(i, key) for i in owners if off[i] > DIFFERENT_LEVEL}
        if all(off[i] > DIFFERENT_LEVEL for i in owners):
            moved[fits].append(product)
            where = " and ".join(repr(model.levels[i].name) for i in owners) or "no storey"
            notes[fits].append(f"{entity_name(product)} is in {where}; by its height it is here")
    return [
        replace(
            level,
            floor=float(floors[i]),
            notes=(*level.notes, *notes[i]),
            products=(*(e for e in level.products if (i, e.id()) not in gone), *moved[i]),
        )
        for i, level in enumerate(model.levels)
    ]


def _storey(model: IfcModel, level: IfcLevel, bodies: _Bodies, resolution: float) -> BuildingStorey:
    notes, floor = [*level.notes, *_bodiless(level, bodies)], level.floor
    spaces = [each for each in level.products if each.is_a("IfcSpace")]
    if abs(floor - level.elevation) > 0.03:
        off = floor - level.elevation
        notes.append(f"the floor is {off:+.2f} m from the height of the storey")
    rooms = [room for each in spaces if (room := _room(each, bodies, floor, notes)) is not None]
    openings = door_openings(model, level.products, bodies.meshes, (floor, floor + BAND[1]), notes)
    grid = _grid(bodies, level, rooms, openings, resolution, notes, file=model.file)
    free = bool(np.any(~grid.blocked()))
    if not free:
        notes.append("no free floor: no map is written")
    if rooms or not free:
        doors = tuple(with_rooms(each, rooms) for each in openings)
        doors = (*doors, *open_borders(grid, rooms, doors))
    else:
        found = partition(grid, tuple(openings))
        rooms, doors = list(found.rooms), found.doors
        notes.append("no spaces on this storey: the rooms are the parts of the free floor")
    apart = [door.id for door in doors if not door.rooms]
    if apart:
        notes.append(f"doors that join no room: {', '.join(apart)}")
    return BuildingStorey(
        name=level.name, stem="", elevation=floor, grid=grid, rooms=tuple(rooms), doors=doors,
        links=tuple(_links(level.products, bodies)), notes=tuple(notes),
    )  # fmt: skip


def _bodiless(level: IfcLevel, bodies: _Bodies) -> list[str]:
    kinds = ("IfcWall", "IfcColumn", "IfcSlab", "IfcSpace", "IfcFurnishingElement")
    lost = [
        each
        for each in level.products
        if any(map(each.is_a, kinds)) and each.id() not in bodies.meshes and not each.IsDecomposedBy
    ]
    more = f" and {len(lost) - 1} more" if len(lost) > 1 else ""
    return [f"no readable geometry: {entity_name(each)}{more}" for each in lost[:1]]


def _floor_height(level: IfcLevel, bodies: _Bodies) -> float:
    """Height of most of the floor: of spaces, else of the largest slab top near the storey, m."""
    spaces = [e.id() for e in level.products if e.is_a("IfcSpace") and e.id() in bodies.meshes]
    bottoms = [bodies.meshes[each].bounds[0, 2] for each in spaces]
    near = [z for z in bottoms if abs(z - level.elevation) < 0.5]
    if near:
        return float(np.median(near))
    z = bodies.floors[:, :, 2].mean(axis=1)
    flat = bodies.floors[np.abs(z - level.elevation) < 0.3]
    if not len(flat):
        return level.elevation
    edges = flat[:, 1:, :2] - flat[:, :1, :2]
    area = np.abs(edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0])
    heights, which = np.unique(np.round(flat[:, :, 2].mean(axis=1), 2), return_inverse=True)
    areas = np.bincount(which, area)
    return float(heights[areas > 0.5 * areas.max()].max())  # a covering lies on its slab


def _room(space: Entity, bodies: _Bodies, floor: float, notes: list[str]) -> Room | None:
    """Room of a space: the union of the level triangles at its bottom."""
    mesh = bodies.meshes.get(space.id())
    if mesh is None:
        return None
    bottom = mesh.bounds[0, 2]
    if abs(bottom - floor) > 0.3:
        notes.append(f"{entity_name(space)} lies {bottom - floor:+.2f} m from the floor")
    triangles = mesh.triangles
    low = upward(triangles) & (triangles[:, :, 2].max(axis=1) < bottom + 0.05)
    outline = shapely.union_all(
        shapely.make_valid(shapely.polygons(triangles[low][:, :, :2])), grid_size=1e-4
    )
    parts = [each for each in shapely.get_parts(outline) if each.area > 1e-3]
    if not parts:
        notes.append(f"{entity_name(space)} has no floor: left out")
        return None
    parts.sort(key=lambda each: -each.area)
    return Room(
        id=space.GlobalId, number=(space.Name or "").strip(), name=(space.LongName or "").strip(),
        polygons=tuple(_corners(each.exterior) for each in parts),
        holes=tuple(_corners(ring) for each in parts for ring in each.interiors),
        area=float(sum(each.area for each in parts)),
    )  # fmt: skip


def _corners(ring: shapely.LinearRing) -> Floats:
    """Corners (k, 2) of an outline, m."""
    return np.array(shapely.get_coordinates(ring.simplify(1e-3)))[:-1]


def _grid(
    bodies: _Bodies,
    level: IfcLevel,
    rooms: Sequence[Room],
    doors: Sequence[Door],
    resolution: float,
    notes: list[str],
    *,
    file: Path,
) -> OccupancyGrid:
    """Map of a storey: free floor where something carries the chair, solids in the band on top."""
    z, floor = bodies.floors[:, :, 2], level.floor
    near = (z.min(axis=1) > floor - 0.1) & (z.max(axis=1) < floor + _STEP)
    floors = bodies.floors[near]
    low, high = floor + BAND[0], floor + BAND[1]
    solids = [m for m in bodies.solids if m.bounds[0, 2] < high and m.bounds[1, 2] > low]
    corners = [floors[:, :, :2].reshape(-1, 2), *(p for room in rooms for p in room.polygons)]
    doorways = [door.part(-door.opening / 2, door.opening / 2, resolution) for door in doors]
    corners += doorways
    if not len(floors) and not rooms:
        corners += [mesh.bounds[:, :2] for mesh in solids]
    empty = unknown_grid(np.concatenate(corners), resolution, level.name, file)
    solid = touched_cells([*solids, *lining_posts(doors, low, high)], empty, low, high)
    solid |= touched_cells(bodies.stairs, empty, low, floor + HEADROOM)
    free, in_doors = covered_cells(floors, empty), polygon_cells(doorways, empty)
    if doors and not len(floors) and not rooms:
        notes.append("no floor in the model: what the walls enclose is taken as floor")
        filled: Booleans = ndimage.binary_fill_holes(solid | in_doors)
        free = filled & ~solid
    bare = []
    for room in rooms:
        cells = room_cells(room, empty)
        if np.count_nonzero(free & cells) < 0.5 * np.count_nonzero(cells):
            bare.append(room.label)
            free |= cells
    if bare:
        notes.append(f"no slab below {', '.join(bare)}: its outline is taken as floor")
    data = empty.data.copy()
    data[free | in_doors] = FREE
    data[solid] = OCCUPIED
    return replace(empty, data=data)


def _links(products: Iterable[Entity], bodies: _Bodies) -> Iterable[StoreyLink]:
    """Lifts, stairs and ramps; stairs and their flights are one."""
    for product in products:
        kind = next((_LINKS[k] for k in _LINKS if product.is_a(k)), None)
        whole = [link.RelatingObject for link in getattr(product, "Decomposes", ())]
        if kind is None or any(e.is_a(k) for e in whole for k in _LINKS):
            continue
        # IFC2X3 calls the type OperationType.
        types = {getattr(product, name, None) for name in ("PredefinedType", "OperationType")}
        if types & _NO_LIFTS:
            continue
        parts = (product, *decomposition(product))
        found = [bodies.meshes[e.id()] for e in parts if e.id() in bodies.meshes]
        if found:
            points = np.concatenate([mesh.vertices[:, :2] for mesh in found])
            hull = shapely.get_coordinates(shapely.MultiPoint(points).convex_hull)[:-1]
            if len(hull) >= 3:
                name = product.Name or ""
                yield StoreyLink(id=product.GlobalId, kind=kind, name=name, polygon=hull)
