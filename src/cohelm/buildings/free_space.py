"""Rooms and doors of a plain map, found in its free space.

Regions that are wider than every passage between them become rooms: with d the distance to the
nearest wall, a watershed of −d separates them, and two of them stay apart if d falls well below the
maximum of each where they meet (Thrun, Learning metric-topological maps, 1998: critical lines).
A boundary that is as narrow as a door, and no longer than one, is a door.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skimage.segmentation import watershed

from cohelm.arrays import Booleans, Floats, Floats32, Integers, replace
from cohelm.buildings.storey import Door, Room, polygon_cells, room_cells, with_rooms
from cohelm.geometry import transform
from cohelm.maps import OccupancyGrid, Places, signed_distance

DOOR_WIDTHS = (0.6, 1.6)
"""Clear widths of passages that may be doors, m."""
_LOOSE = 1.5
"""Extent up to which an obstacle that touches no other is furniture, m."""
_RATIO = 1.25
"""How much wider a room is than a passage into it."""
_NO_CORRIDOR = 1.2
"""Narrower passages are no corridors, m."""
_WIDENS = 1.2, 0.8
"""Behind a door that is wider, the passage is that much wider this far from it, m."""
_SMALLEST = 1.5
"""Smaller regions are part of a neighbour, m²."""
_NARROWEST = 0.8
"""Regions that are nowhere wider are gaps behind walls, m."""
_ANGLES = np.linspace(0.0, np.pi, 36, endpoint=False)


class Partition(NamedTuple):
    """Free space divided into rooms."""

    rooms: tuple[Room, ...]
    doors: tuple[Door, ...]
    notes: tuple[str, ...]


def partition(
    grid: OccupancyGrid, doors: tuple[Door, ...] = (), places: Places | None = None
) -> Partition:
    """Divide the free space of a map into rooms, largest first, and find the doors between them.

    Args:
        grid: the map.
        doors: known doors, at which rooms end; their rooms are filled in.
        places: named places; a room gets the name of the first one in it.
    """
    walkable = _without_furniture(~grid.blocked(), grid.resolution)
    for door in doors:  # closed from wall to wall
        half = 0.5 * door.width + 2.0 * grid.resolution
        closed = replace(door, depth=grid.resolution).part(-half, half)
        walkable[polygon_cells([closed], grid)] = False
    clearance = signed_distance(~walkable, grid.resolution)
    regions = _merged(*_watershed(clearance), clearance, grid.resolution)
    regions = _without_long_passages(regions, clearance, grid)
    sizes = np.bincount(regions.ravel())[1:] * grid.resolution**2
    widest = ndimage.maximum(clearance, regions, np.arange(1, len(sizes) + 1))
    fits = (sizes >= _SMALLEST) & (np.asarray(widest) > _NARROWEST / 2.0)
    order = [i + 1 for i in np.argsort(-sizes, kind="stable") if fits[i]]
    rooms = tuple(
        _room(regions, label, number, grid, places) for number, label in enumerate(order, 1)
    )
    names = dict(zip(order, (room.id for room in rooms), strict=True))
    new = _doors(regions, clearance, grid, names)
    known = [with_rooms(door, rooms) for door in doors]
    rest = float(sizes.sum() - sum(room.area for room in rooms))
    small = f"{rest:.1f} m² of free space are too small or narrow for rooms"
    return Partition(rooms=rooms, doors=(*known, *new), notes=(small,) if rest >= _SMALLEST else ())


def open_borders(
    grid: OccupancyGrid, rooms: Sequence[Room], doors: Sequence[Door]
) -> tuple[Door, ...]:
    """Borders of two rooms along which the floor is free, at no door, at least as wide as one."""
    owner = np.zeros(grid.shape, dtype=np.int64)
    for i, room in enumerate(rooms, 1):
        owner[room_cells(room, grid) & ~grid.blocked()] = i
    found: list[Door] = []
    for pair, cells in border_runs(owner):
        pair_ids = tuple(rooms[i - 1].id for i in pair)
        border = open_border(f"border-{len(found) + 1}", grid, cells, pair_ids)
        at_door = any(np.hypot(*(door.point - border.point)) < door.width / 2.0 for door in doors)
        if border.width >= DOOR_WIDTHS[0] and not at_door:
            found.append(border)
    return tuple(found)


def open_border(key: str, grid: OccupancyGrid, cells: Integers, rooms: tuple[str, ...]) -> Door:
    """Border of rooms without a wall, along cells (n, 2) of a map; ``key`` is its id."""
    points = grid.centres(cells)
    middle = points.mean(axis=0)
    along = np.linalg.svd(points - middle)[2][0]
    width = float(np.ptp((points - middle) @ along)) + grid.resolution
    return Door(
        id=key, kind="open border", point=middle, direction=along, width=width, opening=width,
        rooms=rooms,
    )  # fmt: skip


def _without_furniture(free: Booleans, resolution: float) -> Booleans:
    """Free cells and those of loose obstacles, which divide no rooms."""
    labels, _ = ndimage.label(~free, structure=np.ones((3, 3)))
    out = free.copy()
    for label, window in enumerate(ndimage.find_objects(labels), 1):
        size = np.array([(part.start, part.stop) for part in window])
        border = (size[:, 0] == 0) | (size[:, 1] == free.shape)
        if np.ptp(size, axis=1).max() * resolution <= _LOOSE and not border.any():
            out[window] |= labels[window] == label
    return out


def _watershed(clearance: Floats32) -> tuple[Integers, Floats]:
    """Basins (rows, cols) of −clearance, from 1 on, 0 in walls; their maximum clearances (n+1,)."""
    highest = clearance == ndimage.maximum_filter(clearance, size=3)
    seeds, count = ndimage.label(
        highest & (clearance > DOOR_WIDTHS[0] / 2.0), structure=np.ones((3, 3))
    )
    basins: Integers = watershed(-clearance, seeds, mask=clearance > 0.0).astype(np.int64)
    peaks = ndimage.maximum(clearance, seeds, np.arange(count + 1))
    return basins, np.asarray(peaks, dtype=float)


def _borders(regions: Integers, clearance: Floats32) -> tuple[Integers, Integers, Floats]:
    """Pairs of neighbouring cells in different regions.

    Returns:
        Regions of each pair (n, 2), the smaller one first; cell (n, 2) with the lower clearance;
        that clearance (n,), m.
    """
    rows, cols = regions.shape
    index = np.arange(rows * cols).reshape(rows, cols)
    first = np.concatenate([index[:, :-1].ravel(), index[:-1].ravel()])
    second = np.concatenate([index[:, 1:].ravel(), index[1:].ravel()])
    region, d = regions.ravel(), clearance.ravel()
    apart = (region[first] != region[second]) & (region[first] > 0) & (region[second] > 0)
    first, second = first[apart], second[apart]
    lower = np.where(d[first] <= d[second], first, second)
    pairs = np.sort(np.stack([region[first], region[second]], axis=1), axis=1)
    return pairs, np.stack(np.divmod(lower, cols), axis=1), d[lower].astype(float)


def _merged(basins: Integers, peaks: Floats, clearance: Floats32, resolution: float) -> Integers:
    """Regions of basins, the widest borders first: those that no passage divides are one."""
    pairs, _, saddles = _borders(basins, clearance)
    order = np.lexsort((-saddles, pairs[:, 1], pairs[:, 0]))
    pairs, saddles = pairs[order], saddles[order]
    new = np.any(np.diff(pairs, axis=0, prepend=-1) != 0, axis=1)
    pairs, saddles = pairs[new], saddles[new]
    area = np.bincount(basins.ravel(), minlength=len(peaks)) * resolution**2
    peak, parent = peaks.copy(), np.arange(len(peaks))

    def root(i: int) -> int:
        while parent[i] != i:
            parent[i] = parent[parent[i]]
            i = int(parent[i])
        return i

    for k in np.argsort(-saddles, kind="stable"):
        a, b = root(int(pairs[k, 0])), root(int(pairs[k, 1]))
        wide = saddles[k] > DOOR_WIDTHS[1] / 2.0
        weak = min(peak[a], peak[b]) < _RATIO * (saddles[k] + resolution / 2.0)
        if a != b and (wide or weak or min(area[a], area[b]) < _SMALLEST):
            parent[b] = a
            peak[a], area[a] = max(peak[a], peak[b]), area[a] + area[b]
    return _relabelled(np.array([root(i) for i in range(len(parent))]), basins)


def _without_long_passages(regions: Integers, clearance: Floats32, grid: OccupancyGrid) -> Integers:
    """Regions joined at borders that can be passed but are no doors: the pieces of a corridor."""
    doors, others = set(), set()
    for pair, cells in border_runs(regions):
        passage, is_door = _passage(grid, clearance, cells)
        if is_door:
            doors.add(pair)
        elif passage.width >= DOOR_WIDTHS[0]:
            others.add(pair)
    ends = np.array(sorted(others - doors), dtype=np.int64).reshape(-1, 2).T
    count = int(regions.max()) + 1
    edges = coo_array((np.ones(ends.shape[1]), ends), shape=(count, count))
    return _relabelled(connected_components(edges, directed=False)[1], regions)


def _relabelled(lookup: Integers, regions: Integers) -> Integers:
    """Regions after ``lookup``, numbered from 1 without gaps; 0 stays."""
    out = np.zeros(regions.shape, dtype=np.int64)
    inside = regions > 0
    out[inside] = np.unique(lookup[regions[inside]], return_inverse=True)[1] + 1
    return out


def _doors(
    regions: Integers, clearance: Floats32, grid: OccupancyGrid, names: dict[int, str]
) -> list[Door]:
    """Borders between rooms that are as narrow and as short as doors."""
    found: list[Door] = []
    for pair, cells in border_runs(regions):
        door, is_door = _passage(grid, clearance, cells)
        rooms = tuple(names[label] for label in pair if label in names)
        if is_door and rooms:
            found.append(replace(door, id=f"door-{len(found) + 1}", rooms=rooms))
    return found


def border_runs(regions: Integers) -> Iterator[tuple[tuple[int, int], Integers]]:
    """Connected parts of the borders of regions: the pair, and cells (n, 2) along it."""
    pairs, cells, _ = _borders(regions, np.zeros(regions.shape, dtype=np.float32))
    for pair in np.unique(pairs, axis=0):
        on = np.unique(cells[(pairs == pair).all(axis=1)], axis=0)
        low = on.min(axis=0)
        mask = np.zeros(on.max(axis=0) - low + 1, dtype=np.bool_)
        mask[tuple((on - low).T)] = True
        groups, count = ndimage.label(mask, structure=np.ones((3, 3)))
        group = groups[tuple((on - low).T)]
        for i in range(1, count + 1):
            yield (int(pair[0]), int(pair[1])), on[group == i]


def _passage(grid: OccupancyGrid, clearance: Floats32, border: Integers) -> tuple[Door, bool]:
    """Narrowest line from wall to wall through a border (n, 2), and if it is a door.

    A door is as wide as one, and narrower than corridors, or the passage widens behind it.
    """
    cell = border[np.argmax(clearance[tuple(border.T)])]
    widths, offsets = _chords(grid, clearance, grid.centres(cell))
    best = int(np.argmin(widths))
    direction = np.array([np.cos(_ANGLES[best]), np.sin(_ANGLES[best])])
    width, point = float(widths[best]), grid.centres(cell) + offsets[best] * direction
    normal = np.array([-direction[1], direction[0]])
    beyond = [
        _chords(grid, clearance, point + side * _WIDENS[1] * normal)[0][best]
        for side in (-1.0, 1.0)
    ]
    passage = Door(
        id="", kind="passage", point=point, direction=direction, width=width, opening=width
    )
    short = width <= _NO_CORRIDOR or min(beyond) >= _WIDENS[0] * width
    return passage, DOOR_WIDTHS[0] <= width <= DOOR_WIDTHS[1] and short


def _chords(grid: OccupancyGrid, clearance: Floats32, point: Floats) -> tuple[Floats, Floats]:
    """Free lengths (36,) through a point in all directions, m, and offsets of their middles."""
    reach = np.arange(0.0, 2.0 * DOOR_WIDTHS[1], grid.resolution / 4.0)
    rays = np.stack([np.cos(_ANGLES), np.sin(_ANGLES)], axis=1)
    ends = []
    for side in (-1.0, 1.0):
        points = point + side * reach[:, None, None] * rays
        cells = grid.cells(points)
        inside = grid.contains(points)
        rows, cols = np.where(inside[..., None], cells, 0).transpose(2, 0, 1)
        # A ray ends in the last free cell: it must not slip through the gaps of a dotted wall.
        blocked = ~inside | (clearance[rows, cols] < 0.6 * grid.resolution)
        first = np.where(blocked.any(axis=0), blocked.argmax(axis=0), len(reach) - 1)
        ends.append(side * (reach[first] + grid.resolution))
    return ends[1] - ends[0], (ends[0] + ends[1]) / 2.0


def _room(
    regions: Integers, label: int, number: int, grid: OccupancyGrid, places: Places | None
) -> Room:
    """Room of a region: the outline runs along the borders of its cells."""
    window = ndimage.find_objects((regions == label).astype(np.uint8))[0]
    inside = np.pad(regions[window] == label, 1)
    fine = np.kron(inside, np.ones((4, 4), dtype=np.bool_)).astype(np.uint8)
    contours, tree = cv2.findContours(fine, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    corner = np.array([window[1].start - 1, window[0].start - 1])
    polygons: list[Floats] = []
    holes: list[Floats] = []
    for i in sorted(range(len(contours)), key=lambda k: -cv2.contourArea(contours[k])):
        outline = cv2.approxPolyDP(contours[i], 4.0, closed=True)[:, 0]
        if len(outline) >= 3:
            at = (corner + (outline + 0.5) / 4.0) * grid.resolution
            is_hole = tree[0, i, 3] >= 0
            (holes if is_hole else polygons).append(transform(grid.X_MG, at))
    room = Room(
        id=f"room-{number}", number=str(number), name="Room", polygons=tuple(polygons),
        holes=tuple(holes), area=float(np.count_nonzero(inside) * grid.resolution**2),
    )  # fmt: skip
    name = next((each.name for each in places or () if room.contains(each.point)), "")
    return replace(room, number="", name=name) if name else room
