"""Free floor of a storey as zones that doorways join: rooms, and parts of the floor in no room."""

from __future__ import annotations

import functools
import itertools
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from scipy import ndimage
from skimage.graph import MCP_Geometric
from skimage.measure import approximate_polygon
from skimage.segmentation import watershed

from cohelm.arrays import Annotated, Booleans, Floats, Floats32, Integers, Shape, replace, value
from cohelm.buildings.free_space import border_runs, open_border
from cohelm.buildings.storey import BuildingStorey, Cell, Door, polygon_cells, room_cells, roomiest
from cohelm.maps import OccupancyGrid, signed_distance

_Window = tuple[slice, slice]
_SLIVER = 1.0, 0.25
"""Floor in no room is a part of the zone beside it below this area, m², or half width, m."""
_CONTACT = 0.3
"""Length of a border from which a zone counts as a side of a door, m."""
_NARROWEST = 0.4
"""Length of a border without a door from which it joins two zones, m."""
_WAITING = 2.0, 0.8, 0.3
"""In front of a lift the chair waits at most this far from it, with this clearance, or less where
there is no more, but not less than the last one, m."""
_NEAR_WALL = 0.8, 2.0
"""Nearer to a wall than this, m, a path is dearer; at the wall, a metre counts so many more."""
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
    """Corners of a short path over free cells, away from walls; map frame, m."""
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
        cell = roomiest(inside, self.grid.resolution) if inside.any() else None
        return None if cell is None else (cell[0] + int(low[0]), cell[1] + int(low[1]))

    def waiting_cell(self, zones: Sequence[int], front: Cell, door: Door | None) -> Cell | None:
        """Cell in front of a lift where a chair waits; None if there is no room for one.

        It is the nearest cell with ``_WAITING`` clearance, else the one with the largest clearance.

        Args:
            zones: labels of those that it may lie in.
            front: a cell of them at the lift.
            door: the lift's; the cell lies within its width. None: a lift without one.
        """
        reach = int(np.ceil(_WAITING[0] / self.grid.resolution))
        low = np.maximum(np.subtract(front, reach), 0)
        window = tuple(slice(a, b + reach + 1) for a, b in zip(low, front, strict=True))
        cells = np.argwhere(np.isin(self.labels[window], zones)) + low
        if door is not None:
            beside = np.abs((self.grid.centres(cells) - door.point) @ door.direction)
            cells = cells[beside <= door.width / 2.0]
        strip = np.zeros(self.labels[window].shape, dtype=np.bool_)
        strip[tuple((cells - low).T)] = True
        part = ndimage.label(strip)[0][tuple((cells - low).T)]
        away = np.hypot(*(cells - front).T) * self.grid.resolution
        joined = (part == part[np.argmin(away)]) & (away <= _WAITING[0]) if len(cells) else part > 0
        cells, away = cells[joined], away[joined]
        room = np.minimum(self.clearance[tuple(cells.T)], _WAITING[1])
        if room.max(initial=0.0) < _WAITING[2]:
            return None
        row, col = cells[np.lexsort((away, -room))[0]]
        return int(row), int(col)

    def paths(self, zone: int, cells: list[Cell]) -> Iterator[tuple[int, int, ZonePath]]:
        """Connections between all pairs of cells of a zone that its free cells join.

        Yields:
            Positions i < j in ``cells``, and the connection.
        """
        return self._paths(*self.part(zone), cells)

    def through(self, doorway: Doorway, one: int, other: int) -> ZonePath | None:
        """Connection of two sides of a doorway; None if its free cells do not join them."""
        ends = [doorway.sides[one], doorway.sides[other]]
        window, low = _around(np.array([*doorway.between, *ends]))
        inside = np.isin(self.labels[window], [one, other])
        inside[tuple((doorway.between - low).T)] = True
        return next((path for _, _, path in self._paths(inside, low, ends)), None)

    def _paths(
        self, inside: Booleans, low: Integers, cells: list[Cell]
    ) -> Iterator[tuple[int, int, ZonePath]]:
        """Connections of cells over ``inside`` (rows, cols), a window that begins at ``low``."""
        grid, high = self.grid, low + inside.shape
        near = self.clearance[low[0] : high[0], low[1] : high[1]]
        ends = [(int(row), int(col)) for row, col in np.array(cells) - low]
        radii = _widest(np.where(inside, near, 0.0), ends)
        close = np.maximum(1.0 - near / _NEAR_WALL[0], 0.0)
        for i, start in enumerate(ends[:-1]):
            joined = [j for j in range(i + 1, len(ends)) if radii[i, j] > 0.0]
            search = MCP_Geometric(np.where(inside, 1.0 + _NEAR_WALL[1] * close, -1.0))
            search.find_costs([start], [ends[j] for j in joined])
            for j in joined:
                path = np.array(search.traceback(ends[j])) + low
                steps = np.linalg.norm(np.diff(path, axis=0), axis=1) * grid.resolution
                corners = approximate_polygon(path.astype(float), _CORNER).astype(np.int64)
                found = ZonePath(
                    points=grid.centres(corners), length=float(steps.sum()),
                    clear_width=2.0 * float(radii[i, j]),
                )  # fmt: skip
                yield i, j, found


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
        behind = [
            group
            for group in groups
            if abs((group[0].point - door.point) @ door.direction) < 0.25 * door.width
            and abs((group[0].point - door.point) @ door.normal)
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
    ids = {i: room.id for i, room in enumerate(storey.rooms, 1)}
    named = [door for door in storey.doors if door.depth <= 0.0]
    for pair, cells in border_runs(zones.labels):
        rooms, points = (
            tuple(ids[label] for label in pair if label in ids),
            zones.grid.centres(cells),
        )
        border = open_border(f"border-{cells[0][0]}-{cells[0][1]}", zones.grid, cells, rooms)
        near = [
            door
            for door in named
            if set(door.rooms) == set(rooms)
            and np.linalg.norm(points - door.point, axis=1).min() < 0.5
        ]
        passed = any(
            set(pair) <= set(each.sides)
            and np.linalg.norm(each.door.point - border.point) < border.width
            for each in doorways
        )
        if near:
            border = named.pop(named.index(near[0]))
        elif passed or border.width < _NARROWEST:
            continue
        beside = _beside(zones, cells)
        beside = beside[np.isin(zones.labels[tuple(beside.T)], pair)]
        # Cells on both sides of the roomiest place, with nothing between them.
        best = cells[int(np.argmax(zones.clearance[tuple(cells.T)]))]
        cost = np.abs(beside - best).sum(axis=1) - 1e-3 * zones.clearance[tuple(beside.T)]
        yield Doorway(door=border, sides=_sides(zones, beside, cost), between=cells)


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


def _widest(clearance: Floats, cells: Sequence[Cell]) -> Floats:
    """Largest disc radii (n, n) that get from each of n cells to each other, m; 0: none.

    Two cells are joined by cells with at least some clearance up to one level, which bisection over
    the levels finds. Steps are straight, since the planner's cut no corner. ``clearance``
    (rows, cols), m, is 0 where no path may go.
    """
    levels = np.unique(clearance[clearance > 0.0])

    @functools.cache
    def parts(k: int) -> Integers:
        """Connected part (n,) of the cells with clearance from the k-th level on; 0: in none."""
        out: Integers = ndimage.label(clearance >= levels[k])[0][tuple(np.transpose(cells))]
        return out

    radii = np.zeros((len(cells), len(cells)))
    for i, j in itertools.combinations(range(len(cells)), 2):
        highest = min(clearance[cells[i]], clearance[cells[j]])
        count = bisect_left(
            range(int(np.searchsorted(levels, highest, "right"))), True,
            key=lambda k: not parts(k)[i] == parts(k)[j] > 0,
        )  # fmt: skip
        radii[i, j] = radii[j, i] = levels[count - 1] if count else 0.0
    return radii
