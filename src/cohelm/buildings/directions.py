"""Directions for a route through a building, as steps and as English sentences."""

from __future__ import annotations

from typing import Literal

import numpy as np

from cohelm.arrays import Floats, replace, value
from cohelm.buildings.route_graph import BuildingRoute, RouteGraph, RouteNode
from cohelm.buildings.storey import Door, DoorKind

Side = Literal["left", "right", "ahead", "behind", ""]
"""Seen in the direction of travel; empty if that is not known, as at the start."""
_ALONG = 5.0
"""Length of a way in a room from which it is a step of its own, m."""
_LOOK = 2.0
"""Length at the ends of a way that decides its direction there, m."""
_TURNS = {"left": "Turn left", "right": "Turn right", "behind": "Turn around"}
_BY_SIDE = {
    "left": " on your left", "right": " on your right", "ahead": " ahead", "behind": " behind you",
}  # fmt: skip


@value
class Direction:
    """One step of directions."""

    kind: Literal["start", "door", "along", "lift", "arrive"]
    storey: str
    """Name of the storey; for a lift, of the one that it goes to."""
    room: str = ""
    """Name of the room: the one that the step leads into, or along; empty for floor in no room."""
    side: Side = ""
    """Side of the door or lift, or of the turn before a way along a room."""
    distance: float = 0.0
    """Length of the way up to the door, lift or destination, or along the room, m."""
    door: DoorKind | None = None
    """Kind of the door, for kind ``door``."""
    lift: str = ""
    """Name of the lift, where the building has several."""

    @property
    def text(self) -> str:
        """The step as an English sentence."""
        if self.kind == "start":
            return f"Start in {self.room}." if self.room else f"Start on {self.storey}."
        if self.kind == "arrive":
            return f"You are at {self.room or 'your destination'}."
        if self.kind == "lift":
            return f"Take {self.lift or 'the lift'} to {self.storey}."
        turn = _TURNS.get(self.side, "")
        if self.kind == "along":
            way = f"along {self.room}" if self.room else "straight on"
            go = f"{turn} and go" if turn else "Go"
            return f"{go} {way} for {self.distance:.0f} m."
        room = self.room or "the open floor"
        if self.door == "open border":
            return f"{turn} into {room}." if turn else f"Go on into {room}."
        side = _BY_SIDE.get(self.side, f" to {self.room}" if self.room else "")
        return f"Go through the {self.door}{side}."


def directions(graph: RouteGraph, route: BuildingRoute) -> tuple[Direction, ...]:
    """Steps of a route; ways in one room are one step, or none if they are short."""
    first, last = route.nodes[0], route.nodes[-1]
    steps = [Direction(kind="start", room=first.place, storey=graph.storey(first.storey).name)]
    way: list[Floats] = [first.point]
    heading: Floats | None = None
    for one, other, edge in zip(route.nodes, route.nodes[1:], route.edges, strict=False):
        if edge.kind == "walk":
            way += [*edge.points, other.point]
            continue
        points, storey = np.array(way), graph.storey(one.storey).name
        distance = _length(points)
        step = Direction(kind="along", room=one.place, distance=distance, storey=storey)
        long = distance >= _ALONG
        if long:
            steps.append(replace(step, side=_side(heading, _ahead(points))))
            heading = -_ahead(points[::-1])
        step = replace(step, room=other.place)
        if edge.door is not None:
            through = _through(edge.door, one, other)
            side = _door_side(heading, through, one.point - points[0], long=long)
            steps.append(replace(step, kind="door", side=side, door=edge.door.kind))
            heading = through
        else:
            lift = next(each for each in graph.lifts if each.name == other.key)
            at = {each.storey: each.polygon.mean(axis=0) for each in lift.landings}
            side = _side(heading, at[one.storey] - one.point)
            storey, name = graph.storey(other.storey).name, lift.name * (len(graph.lifts) > 1)
            steps.append(replace(step, kind="lift", side=side, storey=storey, lift=name))
            heading = other.point - at[other.storey]
        way = [other.point]
    rest, storey = _length(np.array(way)), graph.storey(last.storey).name
    arrive = Direction(kind="arrive", room=last.name or last.place, distance=rest, storey=storey)
    return (*steps, arrive)


def _length(points: Floats) -> float:
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def _ahead(points: Floats) -> Floats:
    """Direction (2,) in which a path (k, 2) begins."""
    away = np.linalg.norm(points - points[0], axis=1)
    end = points[int(np.argmax(away >= _LOOK)) if (away >= _LOOK).any() else -1]
    ahead: Floats = end - points[0]
    return ahead


def _through(door: Door, one: RouteNode, other: RouteNode) -> Floats:
    """Direction (2,) in which a door is passed, across its wall."""
    passed = other.point - one.point
    if abs(passed @ door.normal) < 0.3 * np.linalg.norm(passed):  # a border round a corner
        return passed
    through: Floats = np.sign(passed @ door.normal) * door.normal
    return through


def _angle(heading: Floats, direction: Floats) -> float:
    """Angle from a heading to a direction, both (2,), degrees; left is positive."""
    cross = heading[0] * direction[1] - heading[1] * direction[0]
    return float(np.degrees(np.arctan2(cross, heading @ direction)))


def _side(heading: Floats | None, direction: Floats) -> Side:
    if heading is None:
        return ""
    angle = _angle(heading, direction)
    if abs(angle) <= 45.0:
        return "ahead"
    if abs(angle) > 135.0:
        return "behind"
    return "left" if angle > 0.0 else "right"


def _door_side(heading: Floats | None, through: Floats, to_door: Floats, *, long: bool) -> Side:
    """Side of a door: that of its wall, or where that is ahead or behind, that of the door in it.

    Args:
        heading: direction of travel (2,) before it, or on entering the room if the way is short.
        through: direction (2,) in which it is passed.
        to_door: vector (2,) from the entrance of the room, m.
        long: the way through the room is long, and ``heading`` leads up to the door.
    """
    side = _side(heading, through)
    if heading is None or long or side in {"left", "right"} or not to_door.any():
        return side
    bearing = _angle(heading, to_door)
    if side == "ahead" and abs(bearing) < 60.0:
        return "ahead"
    if abs(bearing) > 150.0:
        return "behind"
    return "left" if bearing > 0.0 else "right"
