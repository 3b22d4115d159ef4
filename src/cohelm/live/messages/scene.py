"""Facts that a page gets at the beginning: floor, places, doors, chair, limits and settings."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from cohelm.live.messages.message import WireMessage
from cohelm.messages import Mode


class PlaceInfo(WireMessage):
    """Named place; x, y in m."""

    name: str
    x: float
    y: float
    area: tuple[tuple[float, float], ...] = ()
    """Corners of its outline, m; empty for a point."""
    names: Annotated[dict[str, str], Field(default_factory=dict)]
    """The name in other languages, by their code; requests may use any of them."""


class DoorInfo(WireMessage):
    """Door that the simulation can close: a line from a to b across the doorway, m."""

    id: int
    a: tuple[float, float]
    b: tuple[float, float]


class FloorInfo(WireMessage):
    """Image of the map and its position: lower left corner (x, y), m; resolution, m per pixel."""

    image: str
    """Path of a PNG on the same server; it changes with the map."""
    width: int
    height: int
    resolution: float
    x: float
    y: float


class MapDifference(WireMessage):
    """Place where the building differs from the map; the map itself is never changed."""

    kind: Literal["gone", "new"]
    """``gone``: a wall of the map is not there; ``new``: the map does not have what is there."""
    x: float
    """Middle, m."""
    y: float
    cells: tuple[tuple[float, float], ...]
    """Centres of its cells, whose side is ``MapDifferences.cell``, m."""


class MapDifferences(WireMessage):
    """All places where rides have found the building to differ from the map."""

    type: Literal["map_differences"] = "map_differences"
    cell: float
    """m."""
    found: tuple[MapDifference, ...]


class EdgeCells(WireMessage):
    """All cells behind edges of the floor that the chair has found and cannot take."""

    type: Literal["edge_cells"] = "edge_cells"
    runs: tuple[tuple[int, int, int], ...]
    """(row, column, number of cells along the row), in pixels of ``FloorInfo``; the first row is
    at the bottom."""


class ChairInfo(WireMessage):
    """Chair that is driven, with its outline in the base frame, m."""

    name: str
    outline: tuple[tuple[float, float], ...]
    max_speed: float
    """m/s."""
    max_acceleration: float
    """m/s²."""
    max_turn_rate: float
    """rad/s."""
    sees_floor: bool
    """False: nothing protects it from stairs, kerbs and edges."""


MIN_SPEED_LIMIT = 0.1
"""Minimum of ``Limits.max_speed``, m/s."""
ACCELERATION_LIMITS = (0.1, 2.0)
"""Minimum and maximum of ``Limits.max_acceleration``, m/s²."""
MAX_DEAD_ZONE = 0.6
"""Maximum of ``RiderSettings.dead_zone``."""


class Limits(WireMessage):
    """Limits that only the therapist changes."""

    max_speed: Annotated[float, Field(ge=MIN_SPEED_LIMIT, le=3.0)]
    """m/s."""
    max_acceleration: Annotated[float, Field(ge=ACCELERATION_LIMITS[0], le=ACCELERATION_LIMITS[1])]
    """m/s²; it never limits braking."""
    min_distance: Annotated[float, Field(ge=0.0, le=2.0)]
    """Minimum distance from people, m."""


class RiderSettings(WireMessage):
    """Settings for this rider's stick and switch."""

    tremor_filter: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Time constant of the low-pass filter on the stick, s; 0 is off."""
    dead_zone: Annotated[float, Field(ge=0.0, le=MAX_DEAD_ZONE)] = 0.08
    """Deflection below which the stick counts as centred."""
    start_at_once: bool = False
    """True: a chosen destination needs no confirmation."""
    dwell: Annotated[float, Field(ge=0.3, le=5.0)] = 1.2
    """Time for which switch scanning stays on each choice, s."""
    switches: Literal[0, 1, 2] | None = None
    """Number of switches that the page is operated with; None: as it was set on the page."""


class StoreyInfo(WireMessage):
    """Storey of the building, with its places."""

    name: str
    places: tuple[str, ...]
    lifts: tuple[str, ...] = ()
    """Places of the present storey from which a lift leads there."""


class SceneInfo(WireMessage):
    """Facts that stay the same while the chair drives on one storey."""

    name: str
    description: str
    simulation: bool
    seed: int
    floor: FloorInfo
    places: tuple[PlaceInfo, ...]
    doors: tuple[DoorInfo, ...]
    chair: ChairInfo
    modes: tuple[Mode, ...]
    storey: str = ""
    """Name of the present storey; empty: the map is no storey of a building."""
    storeys: tuple[StoreyInfo, ...] = ()
    """All storeys of the building with a map, lowest first."""
