"""Entrances of a building, given or found, and short labels of its doors."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.buildings.chair_floor import is_entrance
from cohelm.buildings.storey import BuildingStorey, Room
from cohelm.buildings.storey_files import room_places
from cohelm.config import nearest
from cohelm.errors import ConfigError
from cohelm.maps import NamedPlace

_KEY = "--entrance"
_LONGEST_LABEL = 12


@value
class AccessEntrance:
    """Place where the chair starts."""

    name: str
    storey: int
    """Number of the storey."""
    door: str = ""
    """Id of the door to the outside, or empty."""
    point: Annotated[Floats, Shape("2")] | None = None
    """Map frame, m; None: in front of the door."""


def door_labels(storeys: Sequence[BuildingStorey]) -> dict[str, str]:
    """Label of each door by id: its name if that is short and unique, else D and a number."""
    doors = [door for storey in storeys for door in storey.doors]
    count = Counter(door.name for door in doors)
    taken = {name for name in count if count[name] == 1 and 0 < len(name) <= _LONGEST_LABEL}
    return {
        door.id: door.name if door.name in taken else f"D{number}"
        for number, door in enumerate(doors, 1)
    }


def find_entrances(
    storeys: Sequence[BuildingStorey], inside: Collection[str], text: str | None, notes: list[str]
) -> tuple[AccessEntrance, ...]:
    """Entrance that a text names, or the doors of the entry storey that lead outside.

    The text is a room's name or number, a door's id, name or label, or ``X,Y`` in metres on the
    lowest storey; ``STOREY: `` before it chooses another one by name or number. Without a text, the
    entry storey is the one nearest to height 0 that has such doors, and the widest is the first.

    Args:
        storeys: those with a map.
        inside: ids of doors that lead into lifts.
        text: as above, or None.
        notes: gets a sentence if the largest room stands in for an entrance.

    Raises:
        ConfigError: if there is no such place, or there are several.
    """
    labels = door_labels(storeys)
    if text is not None:
        return (_named(storeys, labels, text),)
    outside = {
        storey.number: [d for d in storey.doors if is_entrance(d) and d.id not in inside]
        for storey in storeys
    }
    entry = min(
        (storey for storey in storeys if outside[storey.number]),
        key=lambda storey: abs(storey.elevation), default=None,
    )  # fmt: skip
    if entry is not None:
        doors = sorted(outside[entry.number], key=lambda door: -door.width)
        return tuple(
            AccessEntrance(name=f"door {labels[door.id]}", storey=entry.number, door=door.id)
            for door in doors
        )
    rooms = [(room.area, place, s) for s in storeys for room, place in _rooms(s)]
    lowest = [each for each in rooms if each[2] is storeys[0]]
    _, place, storey = max(lowest, key=lambda each: each[0])
    notes.append(f"no door leads outside: the way begins in the largest room, {place.name}")
    return (AccessEntrance(name=place.name, storey=storey.number, point=place.point),)


def _rooms(storey: BuildingStorey) -> Iterator[tuple[Room, NamedPlace]]:
    return zip(storey.rooms, room_places(storey), strict=True)


def _named(
    storeys: Sequence[BuildingStorey], labels: Mapping[str, str], text: str
) -> AccessEntrance:
    """Entrance that a text names; raises ConfigError if there is none, or there are several."""
    before, _, rest = text.partition(":")
    chosen = [s for s in storeys if before.strip().casefold() in {s.name.casefold(), str(s.number)}]
    wanted = (rest if chosen and rest.strip() else text).strip()
    chosen = chosen if chosen and rest.strip() else list(storeys)
    try:
        numbers = [float(part) for part in wanted.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) == 2:
        return AccessEntrance(name=f"({wanted})", storey=chosen[0].number, point=np.array(numbers))
    found: dict[str, AccessEntrance] = {}
    known: list[str] = []
    for storey in chosen:
        for room, place in _rooms(storey):
            known.append(place.name)
            if _is_named(wanted, room.id, room.number, room.name, room.label, place.name):
                found[f"{storey.name}: {place.name}"] = AccessEntrance(
                    name=place.name, storey=storey.number, point=place.point
                )
        for door in storey.doors:
            label = f"door {labels[door.id]}"
            if _is_named(wanted, door.id, door.name, labels[door.id]):
                found[f"{storey.name}: {label}"] = AccessEntrance(
                    name=label, storey=storey.number, door=door.id,
                    point=None if is_entrance(door) else door.point,
                )  # fmt: skip
    if not found:
        raise ConfigError(f"no room or door {wanted!r}{nearest(wanted, known)}", key=_KEY)
    if len(found) > 1:
        raise ConfigError(f"{wanted!r} is ambiguous: {', '.join(map(repr, found))}", key=_KEY)
    return next(iter(found.values()))


def _is_named(wanted: str, *names: str) -> bool:
    return wanted.casefold() in (name.casefold() for name in names if name)
