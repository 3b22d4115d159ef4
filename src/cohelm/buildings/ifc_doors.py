"""Doors and open passages of an IFC model: place, direction, clear width, rooms on both sides."""

from __future__ import annotations

from collections.abc import Iterable

import ifcopenshell.util.element
import numpy as np
from scipy.spatial import ConvexHull

from cohelm.arrays import Floats
from cohelm.buildings.ifc_file import Entity, IfcModel, entity_name, placement
from cohelm.buildings.sections import Mesh
from cohelm.buildings.storey import Door

NARROWEST = 0.6
"""Openings without a door that are narrower are no passages, m."""
_THICKEST = 1.0
"""Walls that seem thicker are not straight, and do not tell the depth of an opening, m."""
DIFFERENT_LEVEL = 0.3
"""Doors whose sill is farther from the floor belong to another level, m."""


def door_openings(
    model: IfcModel,
    products: Iterable[Entity],
    meshes: dict[int, Mesh],
    band: tuple[float, float],
    notes: list[str],
) -> list[Door]:
    """Doors, and openings of walls without a door or window, at a floor; without their rooms.

    Args:
        model: the model.
        products: those of the storey.
        meshes: by entity number.
        band: height of the floor, and the height up to which openings must be open, m.
        notes: gets a sentence on each door that is left out.
    """
    found = []
    for product in products:
        if product.is_a("IfcDoor"):
            opening = _door(model, product, meshes, band[0], notes)
        elif product.is_a("IfcOpeningElement") and not product.HasFillings:
            opening = _passage(model, product, meshes, band)
        else:
            continue
        if opening is not None:
            found.append(opening)
    return found


def lining_posts(doors: Iterable[Door], low: float, high: float) -> list[Mesh]:
    """Solids beside the clear width of openings, between two heights, m."""
    posts = []
    for door in doors:
        if door.opening - door.width > 2e-3:
            for side in (-1.0, 1.0):
                ends = sorted((side * door.width / 2.0, side * door.opening / 2.0))
                corners = door.part(*ends)
                prism = [np.column_stack([corners, np.full(4, z)]) for z in (low - 1.0, high + 1.0)]
                hull = ConvexHull(np.concatenate(prism))
                posts.append(Mesh(vertices=hull.points, faces=hull.simplices.astype(np.int64)))
    return posts


def _door(
    model: IfcModel, door: Entity, meshes: dict[int, Mesh], floor: float, notes: list[str]
) -> Door | None:
    voids = [fill.RelatingOpeningElement for fill in door.FillsVoids]
    body = next((meshes[e.id()] for e in (*voids, door) if e.id() in meshes), None)
    overall = (door.OverallWidth or 0.0) * model.unit
    if body is None:
        notes.append(f"{entity_name(door)} has neither an opening nor a body: left out")
        return None
    sill = body.bounds[0, 2] - floor
    if abs(sill) > DIFFERENT_LEVEL:
        notes.append(f"{entity_name(door)}: its sill is {sill:+.2f} m from the floor: left out")
        return None
    along, across = _axes(placement(model, door), body, overall)
    width = whole = float(np.ptp(body.vertices[:, :2] @ along))
    in_opening = bool(voids) and voids[0].id() in meshes
    source = "opening"
    if overall and (not in_opening or overall < width - 1e-3):
        width, source = min(overall, width), "overall width"
    lining, threshold = _lining(door)
    if lining:
        source += " less lining"
    host = next((e.RelatingBuildingElement for v in voids for e in v.VoidsElements), None)
    point, depth = _middle(body, meshes.get(host.id()) if host else None, along, across)
    return Door(
        id=door.GlobalId, kind="door", name=door.Name or "", point=point, direction=along,
        opening=whole if in_opening else width, depth=depth, width_from=source,
        width=max(width - 2.0 * lining * model.unit, 0.0),
        threshold=None if threshold is None else threshold * model.unit,
    )  # fmt: skip


def _passage(
    model: IfcModel, opening: Entity, meshes: dict[int, Mesh], band: tuple[float, float]
) -> Door | None:
    """Opening from the floor through the whole wall; None for niches and windows without frame."""
    host = next((void.RelatingBuildingElement for void in opening.VoidsElements), None)
    body = meshes.get(opening.id())
    wall = meshes.get(host.id()) if host is not None and host.is_a("IfcWall") else None
    if body is None or wall is None:
        return None
    bottom, top = body.bounds[:, 2]
    if bottom > band[0] + 0.05 or top < band[1]:
        return None
    along, across = _axes(placement(model, host), wall, np.inf)
    width = float(np.ptp(body.vertices[:, :2] @ along))
    point, depth = _middle(body, wall, along, across)
    thickness = np.ptp(wall.vertices[:, :2] @ across)
    if width < NARROWEST or depth < 0.9 * thickness:
        return None
    return Door(
        id=opening.GlobalId, kind="opening", name=opening.Name or "", point=point,
        direction=along, width=width, opening=width, width_from="opening", depth=depth,
    )  # fmt: skip


def _axes(pose: Floats, body: Mesh, width: float) -> tuple[Floats, Floats]:
    """Directions along and across a wall (2,), from the x and y axes of a placement.

    Along the first one a body is nearest to ``width`` wide, m; 0: unknown, the longer one.
    """
    axes = [axis / np.hypot(*axis) for axis in pose[:2, :2].T if np.hypot(*axis) > 0.9]
    if len(axes) < 2:  # a placement that stands on edge: the box of smallest area
        angles = np.linspace(0.0, np.pi / 2.0, 180, endpoint=False)
        turned = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        sizes = np.ptp(body.vertices[:, :2] @ turned.T, axis=0)
        best = turned[int(np.argmin(sizes * np.roll(sizes, 90)))]
        axes = [best, np.array([-best[1], best[0]])]
    sizes = [float(np.ptp(body.vertices[:, :2] @ axis)) for axis in axes]
    off = np.abs(np.array(sizes) - min(width or max(sizes), 1e6))
    first = int(np.argmin(off))
    return axes[first], axes[1 - first]


def _middle(body: Mesh, wall: Mesh | None, along: Floats, across: Floats) -> tuple[Floats, float]:
    """Centre (2,) of an opening in its wall, and the wall's thickness there, m."""
    low, high = _extent(body, across)
    if wall is not None:
        first, last = _extent(wall, across)
        if last - first < _THICKEST and min(high, last) > max(low, first):
            low, high = max(low, first), min(high, last)
    point = np.mean(_extent(body, along)) * along + (low + high) / 2.0 * across
    return point, float(high - low)


def _extent(mesh: Mesh, axis: Floats) -> tuple[float, float]:
    along = mesh.vertices[:, :2] @ axis
    return float(along.min()), float(along.max())


def _lining(door: Entity) -> tuple[float, float | None]:
    """Thickness of a door's lining on one side, and its threshold, in the model's unit."""
    kind = ifcopenshell.util.element.get_type(door)
    sets = [*(getattr(kind, "HasPropertySets", None) or ())]
    sets += [
        link.RelatingPropertyDefinition
        for link in door.IsDefinedBy
        if link.is_a("IfcRelDefinesByProperties")
    ]
    linings = [each for each in sets if each.is_a("IfcDoorLiningProperties")]
    thickness = [each.LiningThickness for each in linings if each.LiningThickness]
    thresholds = [e.ThresholdThickness for e in linings if e.ThresholdThickness is not None]
    return (thickness or [0.0])[0], (thresholds or [None])[0]
