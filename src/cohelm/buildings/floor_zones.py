"""Free floor of a storey as zones that doorways join: rooms, and parts of the floor in no room."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric
from skimage.measure import approximate_polygon
from skimage.segmentation import watershed

from cohelm.arrays import (
    Annotated,
    Booleans,
    Floats,
    Floats32,
    Integers,
    Shape,
    replace,
    value,
)
from cohelm.buildings.free_space import border_runs
from cohelm.buildings.storey import BuildingStorey, Cell, Door, polygon_cells, room_cells, roomiest
from cohelm.maps import OccupancyGrid, signed_distance

_Window = tuple[slice, slice]
_SLIVER = 1.0, 0.25
"""Floor in no room is a part of the zone beside it below this area, m², or half width, m."""
_CONTACT = 0.3
"""Length of a border from which a zone counts as a side of a door, m."""
_NARROWEST = 0.4
"""Length of a border without a door from which it joins two zones, m."""
_CORNER = 2.0
"""Tolerance of a path's corners, cells."""


@value
class Doorway:
    """Door, opening or open border, with the cells from which it is entered."""

    door: Door
    sides: dict[int, Cell]
    """Cell of each zone in front of it, by the zone's label."""
    between: Annotated[Integers, Shape("n 2")]
    """Cells of the doorway itself."""


@value
class ZonePath:
    """Connection of two cells in a zone."""

    points: Annotated[Floats, Shape("k 2")]
    """Corners of the shortest path between free cells; map frame, m."""
    length: float
    """m."""
    clear_width: float
    """Diameter of the largest disc that gets from one cell to the other, m."""


@value
class FloorZones:
    """Free floor of a storey, divided at its doors."""

    grid: OccupancyGrid
    labels: Annotated[Integers, Shape("rows cols")]
    """Zone of each cell: n for the n-th room, higher numbers for floor in no room, 0 elsewhere."""
    clearance: Annotated[Floats32, Shape("rows cols")]
    """Distance to what is not free, m."""
    doorways: tuple[Doorway, ...]
    windows: tuple[_Window | None, ...]
    """Rows and columns of each zone, from label 1 on; None for a room without free floor."""

    def part(self, zone: int) -> tuple[Booleans, Integers]:
        """Cells of a zone in its window, and the first row and column of that."""
        window = self.windows[zone - 1] or (slice(0, 0), slice(0, 0))
        return self.labels[window] == zone, np.array([window[0].start, window[1].start])

    def roomiest(self, zone: int) -> Cell | None:
        """Cell of a zone farthest from all others and from obstacles; None if it has no cell."""
        inside, low = self.part(zone)
        cell = roomiest(inside, self.grid.resolution)
        return None if cell is None else (cell[0] + int(low[0]), cell[1] + int(low[1]))

    def roomiest_near(self, zone: int, cell: Cell, reach: float, enough: float) -> Cell:
        """Cell of a zone within ``reach`` of another, m, that has ``enough`` clearance, m.

        The nearest of those; where there are none, the one with the largest clearance.
        """
        inside, low = self.part(zone)
        cells = np.argwhere(inside) + low
        away = np.hypot(*(cells - cell).T) * self.grid.resolution
        cells, away = cells[away <= reach], away[away <= reach]
        room = np.minimum(self.clearance[tuple(cells.T)], enough)
        row, col = cells[np.lexsort((away, -room))[0]]
        return int(row), int(col)

    def paths(self, zone: int, cells: list[Cell]) -> Iterator[tuple[int, int, ZonePath]]:
        """Connections between all pairs of cells of a zone that its free cells join.

        Yields:
            Positions i < j in ``cells``, and the connection.
        """
        inside, low = self.part(zone)
        clearance = np.where(inside, self.clearance[self.windows[zone - 1] or ()], 0.0)
        ends = [(int(row), int(col)) for row, col in np.array(cells) - low]
        radii = _widest(clearance, ends)
        for i, start in enumerate(ends[:-1]):
            joined = [j for j in range(i + 1, len(ends)) if radii[i, j] > 0.0]
            search = _search(inside, start, [ends[j] for j in joined])
            for j in joined:
                path = np.array(search.traceback(ends[j])) + low
                yield i, j, self._path(path, 2.0 * float(radii[i, j]))

    def through(self, doorway: Doorway, one: int, other: int) -> ZonePath | None:
        """Connection of two sides of a doorway; None if its free cells do not join them."""
        start, end = doorway.sides[one], doorway.sides[other]
        cells = np.array([*doorway.between, start, end])
        window, low = _around(cells)
        label = self.labels[window]
        inside = (label == one) | (label == other)
        inside[tuple((doorway.between - low).T)] = True
        first, last = ((cell[0] - low[0], cell[1] - low[1]) for cell in (start, end))
        radius = _widest(np.where(inside, self.clearance[window], 0.0), [first, last])[0, 1]
        if radius <= 0.0:
            return None
        path = np.array(_search(inside, first, [last]).traceback(last)) + low
        return self._path(path, 2.0 * float(radius))

    def _path(self, cells: Integers, width: float) -> ZonePath:
        steps = np.linalg.norm(np.diff(cells, axis=0), axis=1) * self.grid.resolution
        corners = approximate_polygon(np.asarray(cells, dtype=float), _CORNER).astype(np.int64)
        return ZonePath(
            points=self.grid.centres(corners), length=float(steps.sum()), clear_width=float(width)
        )


def floor_zones(storey: BuildingStorey) -> FloorZones:
    """Divide the free floor of a storey at its doors."""
    grid, free = storey.grid, ~storey.grid.blocked()
    labels = np.zeros(grid.shape, dtype=np.int64)
    for i in sorted(range(len(storey.rooms)), key=lambda k: -storey.rooms[k].area):
        labels[room_cells(storey.rooms[i], grid) & free] = i + 1
    in_walls = _in_walls(storey.doors)
    for k, doors in enumerate(in_walls, 1):
        for door in doors:
            half = max(door.opening, door.width) / 2.0
            labels[polygon_cells([door.part(-half, half, grid.resolution)], grid) & free] = -k
    labels = _with_rest(labels, free, len(storey.rooms), grid.resolution)
    zones = FloorZones(
        grid=grid, labels=labels, clearance=signed_distance(~free, grid.resolution), doorways=(),
        windows=(),
    )  # fmt: skip
    found = [_doorway(zones, doors, k) for k, doors in enumerate(in_walls, 1)]
    plain = np.maximum(labels, 0)
    count = max(len(storey.rooms), int(plain.max(initial=0)))
    windows = tuple(ndimage.find_objects(plain, max_label=count)) if count else ()
    zones = replace(zones, labels=plain, windows=windows)
    doorways = tuple(each for each in found if each.sides)
    return replace(zones, doorways=(*doorways, *_open_borders(zones, storey, doorways)))


def _in_walls(doors: Iterable[Door]) -> list[list[Door]]:
    """Doors with a depth; those behind each other, as in two leaves of one wall, together."""
    groups: list[list[Door]] = []
    for door in doors:
        normal = np.array([-door.direction[1], door.direction[0]])
        behind = [
            group
            for group in groups
            if abs((group[0].point - door.point) @ door.direction) < 0.25 * door.width
            and abs((group[0].point - door.point) @ normal)
            < (group[0].depth + door.depth) / 2.0 + _CONTACT
            and abs(group[0].direction @ door.direction) > 0.9
        ]
        if door.depth > 0.0:
            behind[0].append(door) if behind else groups.append([door])
    return groups


def _with_rest(labels: Integers, free: Booleans, rooms: int, resolution: float) -> Integers:
    """Labels with floor in no room: new zones, and slivers as parts of zones that touch them.

    A sliver that only doorways touch, as a small space between two of them, is a zone too.
    """
    rest = free & (labels == 0)
    parts, count = ndimage.label(rest)
    area = np.bincount(parts.ravel(), minlength=count + 1)[1:] * resolution**2
    inner = ndimage.distance_transform_edt(rest) * resolution
    half = np.asarray(ndimage.maximum(inner, parts, np.arange(1, count + 1)))
    by_door, by_zone = (
        np.isin(np.arange(1, count + 1), parts[ndimage.binary_dilation(cells)])
        for cells in (labels < 0, labels > 0)
    )
    whole = ((area >= _SLIVER[0]) & (half >= _SLIVER[1])) | (by_door & ~by_zone)
    zone = np.concatenate([[False], whole])[parts]
    out = np.where(zone, parts + rooms, labels)
    # Slivers are flooded from the zones that touch them, but not through doorways.
    known = np.maximum(out, 0)
    flooded = watershed(np.zeros(out.shape, dtype=np.uint8), known, mask=(known > 0) | rest)
    return np.where(out < 0, out, flooded).astype(np.int64)


def _doorway(zones: FloorZones, doors: Sequence[Door], number: int) -> Doorway:
    """Doorway in a wall; without sides if no free floor reaches it.

    Args:
        zones: with doorways as negative labels.
        doors: those behind each other in it; the narrowest one counts.
        number: its label without sign.
    """
    door = min(doors, key=lambda each: each.width)
    half = max(door.opening, door.width) / 2.0 + zones.grid.resolution
    window, low = _around(zones.grid.cells(door.part(-half, half, 0.5)))
    between = np.argwhere(zones.labels[window] == -number) + low
    beside = _beside(zones, between)
    # At the jambs, another room may touch the wall.
    offset = np.abs((zones.grid.centres(beside) - door.point) @ door.direction)
    beside = beside[offset < max(door.opening, door.width) / 2.0]
    away = np.linalg.norm(zones.grid.centres(beside) - door.point, axis=1)
    cost = away - 10.0 * zones.clearance[tuple(beside.T)]
    return Doorway(door=door, sides=_sides(zones, beside, cost), between=between)


def _open_borders(
    zones: FloorZones, storey: BuildingStorey, doorways: Sequence[Doorway]
) -> Iterator[Doorway]:
    """Borders of zones without a wall: those that the storey names, and others."""
    index = {room.id: i for i, room in enumerate(storey.rooms, 1)}
    ids = {i: room for room, i in index.items()}
    named = [door for door in storey.doors if door.depth <= 0.0]
    for pair, cells in border_runs(zones.labels):
        points = zones.grid.centres(cells)
        middle = points.mean(axis=0)
        rooms = tuple(ids[label] for label in pair if label in ids)
        extent = float(np.linalg.norm(np.ptp(points, axis=0))) + zones.grid.resolution
        door = next(
            (
                door
                for door in named
                if set(door.rooms) == set(rooms)
                and np.linalg.norm(points - door.point, axis=1).min() < 0.5
            ),
            None,
        )
        passed = any(
            set(pair) <= set(each.sides) and np.linalg.norm(each.door.point - middle) < extent
            for each in doorways
        )
        named = [each for each in named if each is not door]
        if door is None and (passed or extent < _NARROWEST):
            continue
        if door is None:
            along = np.linalg.svd(points - middle)[2][0]
            door = Door(
                id=f"border-{cells[0][0]}-{cells[0][1]}", kind="open border", name="",
                point=middle, direction=along, width=extent, width_from="map", opening=extent,
                depth=0.0, threshold=None, rooms=rooms,
            )  # fmt: skip
        beside = _beside(zones, cells)
        beside = beside[np.isin(zones.labels[tuple(beside.T)], pair)]
        # Cells on both sides of the roomiest place, with nothing between them.
        best = cells[int(np.argmax(zones.clearance[tuple(cells.T)]))]
        away = np.abs(beside - best).sum(axis=1)
        cost = away - 1e-3 * zones.clearance[tuple(beside.T)]
        yield Doorway(door=door, sides=_sides(zones, beside, cost), between=cells)


def _around(cells: Integers) -> tuple[_Window, Integers]:
    """Window around cells (n, 2) with a cell more on all sides, and its first row and column."""
    low, high = np.maximum(cells.min(axis=0) - 1, 0), np.maximum(cells.max(axis=0) + 2, 0)
    return (slice(low[0], high[0]), slice(low[1], high[1])), low


def _beside(zones: FloorZones, cells: Integers) -> Integers:
    """Cells (m, 2) of zones among or beside cells (n, 2)."""
    if not len(cells):
        return cells
    window, low = _around(cells)
    mask = np.zeros(zones.labels[window].shape, dtype=np.bool_)
    mask[tuple((cells - low).T)] = True
    return np.argwhere(ndimage.binary_dilation(mask) & (zones.labels[window] > 0)) + low


def _sides(zones: FloorZones, beside: Integers, cost: Floats) -> dict[int, Cell]:
    """Zones among cells (n, 2) beside a door, each with its cell of the lowest cost (n,)."""
    label, order = zones.labels[tuple(beside.T)], np.argsort(cost, kind="stable")
    return {
        int(each): (int(row), int(col))
        for each in np.unique(label)
        if np.count_nonzero(label == each) * zones.grid.resolution >= _CONTACT
        for row, col in beside[order[label[order] == each][:1]]
    }


def _search(inside: Booleans, start: Cell, ends: Sequence[Cell]) -> MCP_Geometric:
    """Shortest paths from a cell to others over the cells ``inside`` (rows, cols)."""
    search = MCP_Geometric(np.where(inside, 1.0, -1.0))
    search.find_costs([start], list(ends))
    return search


def _widest(clearance: Floats, cells: Sequence[Cell]) -> Floats:
    """Largest disc radii (n, n) that get from each of n cells to each other, m; 0: none.

    Two cells are joined by cells with at least some clearance up to one level, which bisection over
    the levels finds. Steps are straight, since the planner's cut no corner.

    Args:
        clearance: (rows, cols), m; 0 where no path may go.
        cells: the n cells.
    """
    levels = np.unique(clearance[clearance > 0.0])

    @functools.cache
    def parts(k: int) -> Integers:
        """Connected part (n,) of the cells with clearance from the k-th level on; 0: in none."""
        out: Integers = ndimage.label(clearance >= levels[k])[0][tuple(np.transpose(cells))]
        return out

    radii = np.zeros((len(cells), len(cells)))
    for i, j in itertools.combinations(range(len(cells)), 2):
        low = -1
        high = int(np.searchsorted(levels, min(clearance[cells[i]], clearance[cells[j]]), "right"))
        while high - low > 1:
            middle = (low + high) // 2
            one, other = parts(middle)[[i, j]]
            low, high = (middle, high) if one == other > 0 else (low, middle)
        radii[i, j] = radii[j, i] = levels[low] if low >= 0 else 0.0
    return radii
