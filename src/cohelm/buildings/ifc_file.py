"""IFC models: opened and checked, their storeys, and triangle meshes of their products."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import ifcopenshell
import ifcopenshell.util.element
import ifcopenshell.util.placement
import ifcopenshell.util.unit
import numpy as np

from cohelm.buildings.ifc_shapes import shapes
from cohelm.buildings.sections import Mesh
from cohelm.buildings.storey_files import Watch
from cohelm.errors import BuildingError

SIZE_LIMIT = 200_000_000
"""Largest model that is read, bytes."""
_END = b"END-ISO-10303-21;"
JOINED = " / "
"""Between the names of storeys at one height."""
_SAME_HEIGHT = 0.1
"""Storeys closer than this are one, m."""
Entity = Any
"""Instance of an IFC entity; ifcopenshell makes its attributes at run time."""


@dataclass(frozen=True, kw_only=True)
class IfcLevel:
    """Storeys of a model at one height, and the products contained in them."""

    name: str
    elevation: float
    """Placement of the storey in the model, m."""
    floor: float
    """Height of its floor, m."""
    products: tuple[Entity, ...]
    notes: tuple[str, ...]


@dataclass(frozen=True, kw_only=True)
class IfcModel:
    """An opened model."""

    file: Path
    model: Any
    unit: float
    """Length unit, m."""
    levels: tuple[IfcLevel, ...]
    """Lowest first."""


def open_ifc(file: Path) -> IfcModel:
    """Open a model and find its storeys.

    Raises:
        BuildingError: if the file is missing, too large, incomplete, of an unknown schema, or has
            no length unit or no storeys.
    """
    _check_text(file)
    try:
        model: Any = ifcopenshell.open(str(file))
    except (ifcopenshell.Error, OSError, RuntimeError) as cause:
        raise BuildingError(f"not a readable IFC model ({cause})", file=file) from None
    projects = model.by_type("IfcProject")
    if not projects:
        raise BuildingError("no IfcProject", file=file)
    if ifcopenshell.util.unit.get_project_unit(model, "LENGTHUNIT") is None:
        problem = "no length unit (LENGTHUNIT) in UnitsInContext"
        raise BuildingError(problem, file=file, entity=entity_name(projects[0]))
    unit = float(ifcopenshell.util.unit.calculate_unit_scale(model))
    return IfcModel(file=file, model=model, unit=unit, levels=_levels(model, unit, file))


def meshes(model: IfcModel, products: Iterable[Entity], watch: Watch) -> dict[int, Mesh]:
    """Meshes of products by their entity number, in m; those without a readable body are absent.

    Raises:
        BuildingError: if the geometry library crashes.
    """
    wanted = [each.id() for each in products if each.Representation is not None]
    return {
        number: Mesh(vertices=vertices, faces=faces)
        for number, vertices, faces in watch(shapes(model.file, wanted), len(wanted))
        if len(faces) and np.isfinite(vertices).all()
    }


def placement(model: IfcModel, product: Entity) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Pose of a product in the model (4, 4), m.

    Raises:
        BuildingError: if its placement cannot be read; names entity and GlobalId.
    """
    try:
        matrix = np.array(
            ifcopenshell.util.placement.get_local_placement(product.ObjectPlacement), dtype=float
        )
    except (AttributeError, TypeError, ValueError, RecursionError):
        raise BuildingError(
            "its placement cannot be read", file=model.file, entity=entity_name(product)
        ) from None
    matrix[:3, 3] *= model.unit
    return matrix


def decomposition(whole: Entity) -> tuple[Entity, ...]:
    """All that an entity consists of or contains, at any depth; damaged models have cycles."""
    found: dict[int, Entity] = {}
    rest = [whole]
    while rest:
        for each in ifcopenshell.util.element.get_decomposition(rest.pop(), is_recursive=False):
            if each.id() not in found:
                found[each.id()] = each
                rest.append(each)
    return tuple(found.values())


def file_stems(names: Sequence[str]) -> tuple[str, ...]:
    """Names of files without suffix: lower case, ASCII, without spaces, all different."""
    stems: list[str] = []
    for name in names:
        text = re.sub(r"(?<!\w)[-−](?=\d)", " minus ", name)
        text = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
        stem = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "storey"
        more = (stem, *(f"{stem}-{number}" for number in range(2, len(names) + 2)))
        stems.append(next(each for each in more if each not in stems))
    return tuple(stems)


def entity_name(entity: Entity) -> str:
    """Class, GlobalId and name of an entity, for messages."""
    name = f" {entity.Name!r}" if getattr(entity, "Name", None) else ""
    return f"{entity.is_a()} {entity.GlobalId}{name}"


def _check_text(file: Path) -> None:
    try:
        size = file.stat().st_size
        if size > SIZE_LIMIT:
            limit = f"{size / 1e6:.0f} MB are more than the limit of {SIZE_LIMIT / 1e6:.0f} MB"
            raise BuildingError(limit, file=file)
        with file.open("rb") as stream:
            head = stream.read(4096)
            stream.seek(max(size - 4096, 0))
            tail = stream.read()
    except OSError as cause:
        raise BuildingError(f"cannot be read ({cause.strerror})", file=file) from None
    if b"ISO-10303-21" not in head:
        raise BuildingError("not an IFC model: it does not begin as a STEP file", file=file)
    if _END not in tail:
        raise BuildingError(f"incomplete: {_END.decode()} is missing at its end", file=file)


def _levels(model: Any, unit: float, file: Path) -> tuple[IfcLevel, ...]:
    storeys = model.by_type("IfcBuildingStorey")
    if not storeys:
        raise BuildingError("no IfcBuildingStorey", file=file)
    unplaced = IfcModel(file=file, model=model, unit=unit, levels=())
    heights = {each.id(): float(placement(unplaced, each)[2, 3]) for each in storeys}
    groups: list[list[Entity]] = []
    for storey in sorted(storeys, key=lambda each: heights[each.id()]):
        near = groups and heights[storey.id()] - heights[groups[-1][0].id()] < _SAME_HEIGHT
        groups[-1].append(storey) if near else groups.append([storey])
    levels = []
    for group in groups:
        names, height = [each.Name or each.GlobalId for each in group], heights[group[0].id()]
        notes = []
        if len(group) > 1:
            notes.append(f"the storeys {', '.join(names)} are at one height and were joined")
        for each in group:
            given, placed = (each.Elevation or 0.0) * unit, heights[each.id()]
            if abs(given - placed) > 0.01:
                ignored = f"Elevation {given:.2f} m was ignored, it is placed at {placed:.2f} m"
                notes.append(f"{entity_name(each)}: {ignored}")
        parts = {part.id(): part for each in group for part in decomposition(each)}
        products = (parts[key] for key in sorted(parts) if parts[key].is_a("IfcProduct"))
        levels.append(
            IfcLevel(
                name=JOINED.join(dict.fromkeys(names)), elevation=height, floor=height,
                products=tuple(products), notes=tuple(notes),
            )
        )  # fmt: skip
    return tuple(levels)
