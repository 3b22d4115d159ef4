"""Route graph of a building: rooms, doors and lifts, and the ways between them."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from typing import Any, Literal

import networkx as nx
import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, replace, value
from cohelm.buildings.floor_zones import FloorZones, ZonePath, floor_zones
from cohelm.buildings.lifts import Lift, lifts_of, open_front
from cohelm.buildings.storey import BuildingStorey, Cell, Door, polygon_cells
from cohelm.buildings.storey_files import room_names
from cohelm.config import nearest
from cohelm.errors import ConfigError, NoRoute
from cohelm.geometry import distance_to_polygon
from cohelm.maps import NamedPlace, innermost_point

NodeKind = Literal["room", "place", "door", "lift"]
LIFT_WAIT = 30.0
"""Waiting and riding time of a lift, s; assumed."""
LIFT_PRICE = 0.8
"""Price of a second in a lift, m: the distance that a chair drives in it."""
WIDE = 1.5
"""Clear width from which a way is wide: two chairs turn, or a chair and a person pass, m."""


@value
class RouteNode:
    """Place on a route."""

    kind: NodeKind
    storey: int
    point: Annotated[Floats, Shape("2")]
    """Roomiest point of a room, named place, side of a door, place in front of a lift; map frame,
    m."""
    name: str
    """Name of the room, place, door or lift; empty for floor in no room."""
    key: str
    """Id of the room or door, name of the place or lift; empty for floor in no room."""
    zone: int
    """Zone of its storey's floor that it lies in."""
    place: str
    """Name of the room that it lies in; empty for floor in no room."""
    room: str
    """Id of the room that it lies in; empty for floor in no room."""


@value
class RouteEdge:
    """Way between two places that needs no other place."""

    kind: Literal["walk", "door", "lift"]
    points: Annotated[Floats, Shape("k 2")]
    """Short path over free cells, away from walls; map frame of the storey, m."""
    length: float
    """m; 0 for a lift."""
    clear_width: float
    """Bottleneck of the free width on the map, m; ∞ for a lift."""
    door: Door | None = None
    """The door, for kind ``door``; it knows width and threshold of the model."""
    wait: float = 0.0
    """Time in and for a lift, s."""
    ramp: bool = False
    """Leads over a ramp of the model."""


@value
class RouteWishes:
    """Wishes for a route; each is a price in metres of detour."""

    avoid: frozenset[str] = frozenset()
    """Ids of rooms to pass only if the detour is longer than ``room_price``."""
    closed: frozenset[str] = frozenset()
    """Ids of rooms never to enter."""
    room_price: float = 100.0
    """For entering and leaving a room to avoid, m."""
    narrow_price: float = 0.0
    """For each metre on a way narrower than 1.5 m, m; 0: no such wish."""
    ramp_price: float = 0.0
    """For each ramp, m; 0: no such wish."""

    def each_without(self) -> dict[str, RouteWishes]:
        """All other wishes, by the name of each one that is set."""
        wishes: tuple[tuple[str, str, Any], ...] = (
            ("avoid", "avoid", frozenset()), ("closed", "closed", frozenset()),
            ("wide", "narrow_price", 0.0), ("level", "ramp_price", 0.0),
        )  # fmt: skip
        return {
            name: replace(self, **{field: none})
            for name, field, none in wishes
            if getattr(self, field) != none
        }


@value
class BuildingRoute:
    """Route through rooms, doors and lifts."""

    positions: tuple[int, ...]
    """Those of its nodes in the graph."""
    nodes: tuple[RouteNode, ...]
    edges: tuple[RouteEdge, ...]
    """One fewer than nodes, each directed as the route."""

    @property
    def length(self) -> float:
        """Length without lifts, m."""
        return float(sum(edge.length for edge in self.edges))

    @property
    def clear_width(self) -> float:
        """Narrowest clear width on the map, m."""
        return min((edge.clear_width for edge in self.edges), default=math.inf)


@value
class RouteGraph:
    """Rooms, doors and lifts of a building as nodes, joined within rooms, by doors and by lifts."""

    storeys: tuple[BuildingStorey, ...]
    lifts: tuple[Lift, ...]
    nodes: tuple[RouteNode, ...]
    graph: Any
    """Undirected ``networkx.Graph`` over positions in ``nodes``; each edge has a RouteEdge, from
    the lower position to the higher one, as ``edge``."""
    notes: tuple[str, ...] = ()
    """Lifts without a waiting place and places on no free floor, one sentence each."""

    def edge(self, one: int, other: int) -> RouteEdge:
        """Edge of two joined nodes, directed from the first one; KeyError if none joins them."""
        edge: RouteEdge = self.graph.edges[one, other]["edge"]
        return edge if one < other else replace(edge, points=edge.points[::-1])

    def storey(self, number: int) -> BuildingStorey:
        """Storey of a number; StopIteration if there is none."""
        return next(each for each in self.storeys if each.number == number)

    def lift_places(self, storey: int) -> tuple[NamedPlace, ...]:
        """Waiting places in front of the lifts that are no rooms on a storey."""
        rooms = {e.name for e in self.lifts for at in e.landings if at.room and at.storey == storey}
        here = [each for each in self.nodes if each.kind == "lift" and each.storey == storey]
        points = {each.name: each.point for each in reversed(here) if each.name not in rooms}
        return tuple(NamedPlace(name=name, point=point) for name, point in points.items())

    def find(self, text: str, key: str = "") -> int:
        """Position of the room or lift of that name, number, or both; ``NAME @ STOREY`` tells more.

        Args:
            text: not case-sensitive.
            key: option or key that gives it, for errors.

        Raises:
            ConfigError: if there is none, or more than one; names candidates.
        """
        found = self._places(text)
        if len(found) == 1:
            return found[0]
        if not found:
            every = {node.name for node in self.nodes if _has_name(node)}
            raise ConfigError(f"no place {text!r}{nearest(text, every)}", key=key)
        names = " or ".join(repr(self._full_name(i)) for i in found)
        raise ConfigError(f"{text!r} may be {names}", key=key)

    def rooms(self, text: str, key: str = "") -> frozenset[str]:
        """Ids of all rooms of that name or number, on one storey with ``NAME @ STOREY``.

        Raises:
            ConfigError: if there is none; names candidates.
        """
        found = {self.nodes[i].room for i in self._places(text) if self.nodes[i].kind == "room"}
        if not found:
            every = {node.name for node in self.nodes if node.kind == "room" and node.name}
            raise ConfigError(f"no room {text!r}{nearest(text, every)}", key=key)
        return frozenset(found)

    def route(
        self,
        start: int,
        goal: int,
        *,
        width: float = 0.0,
        wishes: RouteWishes | None = None,
        blocked: Set[frozenset[int]] = frozenset(),
    ) -> BuildingRoute:
        """Cheapest route between two nodes.

        Args:
            start, goal: positions in ``nodes``.
            width: the robot's; narrower edges are closed, m.
            wishes: prices of rooms, narrow ways and ramps.
            blocked: pairs of nodes whose edges are closed.

        Raises:
            NoRoute: if there is none; names the door or room that is too narrow.
        """
        wishes = wishes or RouteWishes()
        best = self._path(start, goal, width, wishes, blocked)
        if best is None:
            narrowest = self._narrowest(start, goal, wishes, blocked)
            others = replace(wishes, closed=frozenset())
            closed = not narrowest and self._path(start, goal, width, others, blocked) is not None
            raise NoRoute(
                start=self._full_name(start), goal=self._full_name(goal), needed=width,
                narrowest=narrowest,
                because="rooms never to enter close every way" if closed else "; ".join(self.notes),
            )  # fmt: skip
        return BuildingRoute(
            positions=tuple(best),
            nodes=tuple(self.nodes[i] for i in best),
            edges=tuple(self.edge(*pair) for pair in itertools.pairwise(best)),
        )

    def describe(self, one: int, other: int) -> str:
        """The edge of two nodes in words: the door with its clear width, or the room."""
        edge, ends = self.edge(one, other), [self.nodes[one], self.nodes[other]]
        if edge.door is None:
            where = ends[0].place or "the floor in no room"
            return f"the way through {where}, {edge.clear_width:.2f} m wide"
        name = f" {edge.door.name!r}" if edge.door.name else ""
        sides = " – ".join(node.place or "no room" for node in ends)
        width = f"{edge.door.width:.2f} m wide"
        if edge.clear_width < edge.door.width - 0.005:
            width += f", {edge.clear_width:.2f} m on the map"
        return f"the {edge.door.kind}{name} ({sides}), {width}"

    def _places(self, text: str) -> list[int]:
        name, _, where = (part.strip().casefold() for part in text.partition("@"))
        at = {s.number for s in self.storeys if where in {"", s.name.casefold(), str(s.number)}}
        return [
            i
            for i, node in enumerate(self.nodes)
            if node.storey in at and _has_name(node) and name in self._names(node)
        ]

    def _names(self, node: RouteNode) -> set[str]:
        storey, names = self.storey(node.storey), {node.name}
        for room in storey.rooms:
            if room.id == node.key:
                names |= {room.number, room.label, room.name}
        for place in storey.places:
            if place.name == node.name:
                names |= {*place.names.values()}
        return {each.casefold() for each in names if each}

    def _full_name(self, i: int) -> str:
        node = self.nodes[i]
        return f"{node.name or node.place or 'no room'} @ {self.storey(node.storey).name}"

    def _path(
        self, start: int, goal: int, width: float, wishes: RouteWishes, blocked: Set[frozenset[int]]
    ) -> list[int] | None:
        def price(one: int, other: int, data: Mapping[str, Any]) -> float | None:
            edge: RouteEdge = data["edge"]
            rooms = [self.nodes[one].room, self.nodes[other].room]
            closed = edge.kind == "door" and any(room in wishes.closed for room in rooms)
            if closed or edge.clear_width < width or frozenset((one, other)) in blocked:
                return None
            price = edge.length + LIFT_PRICE * edge.wait + wishes.ramp_price * edge.ramp
            if edge.kind == "door":  # half of a room's price at each of its doors
                price += 0.5 * wishes.room_price * sum(room in wishes.avoid for room in rooms)
            if edge.kind == "walk" and edge.clear_width < WIDE:
                price += wishes.narrow_price * edge.length
            return price

        try:
            return list(nx.dijkstra_path(self.graph, start, goal, weight=price))
        except nx.NetworkXNoPath:
            return None

    def _narrowest(
        self, start: int, goal: int, wishes: RouteWishes, blocked: Set[frozenset[int]]
    ) -> str:
        """Narrowest edge of the widest route, in words, a door if it is one; empty if none."""

        def path(width: float) -> list[int] | None:
            return self._path(start, goal, width, wishes, blocked)

        widths = sorted({data["edge"].clear_width for _, _, data in self.graph.edges(data=True)})
        count = bisect_left(widths, True, key=lambda width: path(width) is None)
        best = path(widths[count - 1]) if count else None
        pairs = list(itertools.pairwise(best or []))
        if not pairs:
            return ""
        one, other = min(
            pairs, key=lambda p: (self.edge(*p).clear_width, self.edge(*p).kind != "door")
        )
        beside = [p for p in pairs if {one, other} & set(p) and self.edge(*p).kind == "door"]
        # A doorway's jambs narrow the way up to it as much as the doorway itself.
        if beside and self.edge(*beside[0]).clear_width < self.edge(one, other).clear_width + 0.15:
            one, other = beside[0]
        return self.describe(one, other)


def route_graph(storeys: Sequence[BuildingStorey]) -> RouteGraph:
    """Graph of a building from the maps, rooms, doors and lifts of its storeys."""
    lifts, graph = lifts_of(storeys), nx.Graph()
    nodes: list[RouteNode] = []
    notes: list[str] = []
    landings: dict[str, list[int]] = {lift.name: [] for lift in lifts}
    for storey in storeys:
        if storey.grid.blocked().all():
            continue
        floor = _StoreyFloor(storey, lifts)
        for node, cell in floor.nodes(notes):
            if node.kind == "lift":
                landings[node.key].append(len(nodes))
            if cell is not None:
                floor.members.setdefault(node.zone, []).append((len(nodes), cell))
            nodes.append(node)
        for one, other, edge in floor.edges(nodes):
            graph.add_edge(one, other, edge=edge)
    graph.add_nodes_from(range(len(nodes)))
    for ends in landings.values():
        for one, other in itertools.combinations(ends, 2):
            if nodes[one].storey != nodes[other].storey:
                points = np.array([nodes[one].point, nodes[other].point])
                edge = RouteEdge(
                    kind="lift", points=points, length=0.0, clear_width=math.inf, wait=LIFT_WAIT
                )
                graph.add_edge(one, other, edge=edge)
    return RouteGraph(
        storeys=tuple(storeys), lifts=lifts, nodes=tuple(nodes), graph=graph, notes=tuple(notes)
    )


class _StoreyFloor:
    """Nodes and edges of one storey."""

    def __init__(self, storey: BuildingStorey, lifts: Iterable[Lift]) -> None:
        self.storey = storey
        self.names = room_names(storey.rooms)
        self.zones: FloorZones = floor_zones(storey)
        every = [(lift, landing) for lift in lifts for landing in lift.landings]
        self.landings = [pair for pair in every if pair[1].storey == storey.number]
        shafts = polygon_cells([each.polygon for _, each in self.landings], storey.grid)
        labels = self.zones.labels
        sizes = np.bincount(labels.ravel(), minlength=len(storey.rooms) + 1)
        inside = np.bincount(labels[shafts].ravel(), minlength=len(sizes))
        lift_rooms = {landing.room for _, landing in self.landings}
        self.open = [
            i
            for i in range(1, len(sizes))
            if inside[i] <= 0.5 * sizes[i] and self._room(i)[0] not in lift_rooms - {""}
        ]
        """Labels of zones that are no lift."""
        self.members: dict[int, list[tuple[int, Cell]]] = {}
        """Positions and cells of the nodes in each zone."""

    def nodes(self, notes: list[str]) -> Iterator[tuple[RouteNode, Cell | None]]:
        """Nodes with their cells; a room or place on no free floor has no cell."""
        for zone in self.open:
            key, name = self._room(zone)
            cell = self.zones.roomiest(zone)
            if cell is not None:
                yield self._node("room", zone, cell, name, key), cell
            elif key:
                inner = innermost_point(self.storey.rooms[zone - 1].polygons[0])
                yield self._node("room", zone, self._cell(inner), name, key), None
        for doorway in self.zones.doorways:
            for zone, cell in doorway.sides.items():
                if zone in self.open:
                    name, key = doorway.door.name, doorway.door.id
                    yield self._node("door", zone, cell, name, key), cell
        for lift, landing in self.landings:
            fronts: list[tuple[Door | None, dict[int, Cell]]] = [
                (doorway.door, doorway.sides)
                for doorway in self.zones.doorways
                if doorway.door.id in landing.doors
            ] or [(None, self._fronts(open_front(self.storey, landing.polygon)))]
            waiting = {
                int(self.zones.labels[cell]): cell
                for door, sides in fronts
                for zone, front in sides.items()
                if zone in self.open and (cell := self.zones.waiting_cell(self.open, front, door))
            }
            for zone, cell in waiting.items():
                yield self._node("lift", zone, cell, lift.name, lift.name), cell
            if not waiting:
                where = f"{lift.name!r} on {self.storey.name}"
                notes.append(f"no waiting place in front of {where}: it is not used there")
        lifts = (lift.name for lift, _ in self.landings)
        taken = {name.casefold() for name in (*self.names.values(), *lifts)}
        for place in self.storey.places:
            if place.name.casefold() not in taken:
                cell = self._cell(place.point)
                inside = bool(self.storey.grid.contains(place.point))
                zone = int(self.zones.labels[cell]) if inside else 0
                node = self._node("place", zone, cell, place.name, place.name)
                yield replace(node, point=place.point), cell if zone else None
                if not zone:
                    notes.append(f"{place.name!r} on {self.storey.name} lies on no free floor")

    def edges(self, nodes: Sequence[RouteNode]) -> Iterator[tuple[int, int, RouteEdge]]:
        for zone, members in self.members.items():
            for i, j, path in self.zones.paths(zone, [cell for _, cell in members]):
                yield members[i][0], members[j][0], self._edge("walk", path)
        at = {
            (nodes[i].key, nodes[i].zone): i
            for members in self.members.values()
            for i, _ in members
            if nodes[i].kind == "door"
        }
        for doorway in self.zones.doorways:
            sides = [zone for zone in doorway.sides if zone in self.open]
            for one, other in itertools.combinations(sides, 2):
                passed = self.zones.through(doorway, one, other)
                if passed is not None:
                    ends = at[doorway.door.id, one], at[doorway.door.id, other]
                    yield *ends, self._edge("door", passed, doorway.door)

    def _fronts(self, front: np.ndarray[Any, Any]) -> dict[int, Cell]:
        """The middle cell of each zone among cells (rows, cols)."""
        found = {}
        for zone in np.unique(self.zones.labels[front]):
            cells = np.argwhere(front & (self.zones.labels == zone))
            middle = cells[np.argmin(np.linalg.norm(cells - cells.mean(axis=0), axis=1))]
            found[int(zone)] = (int(middle[0]), int(middle[1]))
        return found

    def _cell(self, point: Floats) -> Cell:
        row, col = self.storey.grid.cells(point).tolist()
        return row, col

    def _room(self, zone: int) -> tuple[str, str]:
        """Id and name of a zone's room; empty for floor in no room."""
        if not 0 < zone <= len(self.storey.rooms):
            return "", ""
        room = self.storey.rooms[zone - 1].id
        return room, self.names[room]

    def _node(
        self,
        kind: Literal["room", "place", "door", "lift"],
        zone: int,
        cell: Cell,
        name: str,
        key: str,
    ) -> RouteNode:
        room, place = self._room(zone)
        return RouteNode(
            kind=kind, storey=self.storey.number, point=self.storey.grid.centres(cell), name=name,
            key=key, zone=zone, place=place, room=room,
        )  # fmt: skip

    def _edge(
        self, kind: Literal["walk", "door"], path: ZonePath, door: Door | None = None
    ) -> RouteEdge:
        ramp = any(
            link.kind == "ramp" and distance_to_polygon(link.polygon, *point) < 0.0
            for link in self.storey.links
            for point in path.points
        )
        return RouteEdge(
            kind=kind, points=path.points, length=path.length, clear_width=path.clear_width,
            door=door, ramp=ramp,
        )  # fmt: skip


def _has_name(node: RouteNode) -> bool:
    return node.kind != "door" and bool(node.name)
