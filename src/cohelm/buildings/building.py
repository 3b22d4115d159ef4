"""Buildings of every kind: an IFC model, or a Nav2 map as a building of one storey."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import Any

from cohelm.buildings.storey import BuildingStorey
from cohelm.errors import BuildingError
from cohelm.maps import places_beside, read_map

Watch = Callable[[Iterable[Any], int], Iterator[Any]]
"""Passes elements on, of which there are so many, and may show progress."""
RESOLUTION = 0.05
"""Side of a cell, m."""
_MAPS = {".yaml", ".yml", ".pgm", ".png", ".bmp", ".jpg", ".jpeg"}


def read_building(
    file: Path,
    *,
    storey: str | None = None,
    resolution: float = RESOLUTION,
    watch: Watch = lambda elements, _: iter(elements),
) -> tuple[BuildingStorey, ...]:
    """Storeys of a building, lowest first.

    Args:
        file: IFC model (.ifc), or Nav2 map.
        storey: only this one: its name, or its number, counted from 1 at the lowest.
        resolution: side of a cell of an IFC model's maps, m; a Nav2 map keeps its own.
        watch: shows progress over the products of a model.

    Raises:
        BuildingError: if the model cannot be read, or has no such storey, or the extra ``building``
            is not installed.
        MapError: if the map cannot be read.
    """
    try:
        from cohelm.buildings.free_space import partition  # noqa: PLC0415  # needs the extra
        from cohelm.buildings.ifc_storeys import read_ifc  # noqa: PLC0415
    except ImportError as cause:
        problem = f"reading buildings needs more ({cause}): pip install 'cohelm[building]'"
        raise BuildingError(problem, file=file) from None
    if file.suffix.lower() == ".ifc":
        return read_ifc(file, storey=storey, resolution=resolution, watch=watch)
    if file.suffix.lower() not in _MAPS:
        raise BuildingError("neither an IFC model (.ifc) nor a Nav2 map (.yaml)", file=file)
    if storey not in {None, "1", file.stem}:
        raise BuildingError(f"no storey {storey!r}: a map is one storey", file=file)
    grid = read_map(file)
    found = partition(grid, places=places_beside(file))
    return (
        BuildingStorey(
            name=file.stem, stem=file.stem, elevation=0.0, grid=grid, rooms=found.rooms,
            doors=found.doors, notes=found.notes,
        ),
    )  # fmt: skip
