"""What a page knows from the beginning: floor, places, doors, chair, limits and settings."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from cohelm.driving.messages.message import Message
from cohelm.messages import Mode


class Place(Message):
    """Somewhere with a name."""

    name: str
    x: float
    y: float


class Doorway(Message):
    """A door that can be shut in simulation: where it is across, from a to b."""

    id: int
    a: tuple[float, float]
    b: tuple[float, float]


class Floor(Message):
    """The map's picture and where it lies: its lower left corner, and metres a pixel."""

    image: str
    """Path of a PNG on the same server; it changes with the map."""
    width: int
    height: int
    resolution: float
    x: float
    y: float


class Chair(Message):
    """The chair that is driven; its outline about the middle of the drive axle, m."""

    name: str
    outline: tuple[tuple[float, float], ...]
    max_speed: float
    max_turn_rate: float


class Limits(Message):
    """What only the therapist changes."""

    max_speed: Annotated[float, Field(ge=0.1, le=3.0)]
    """m/s."""
    max_acceleration: Annotated[float, Field(ge=0.1, le=2.0)]
    """m/s²; braking is never limited by it."""
    min_distance: Annotated[float, Field(ge=0.0, le=2.0)]
    """Least distance kept from people, m."""


class RiderSettings(Message):
    """How this rider's hand and switch are understood."""

    tremor_filter: Annotated[float, Field(ge=0.0, le=1.0)] = 0.0
    """Time constant of the low-pass on the stick, s; 0 is off."""
    dead_zone: Annotated[float, Field(ge=0.0, le=0.6)] = 0.08
    """Deflection below which the stick counts as centred."""
    dwell: Annotated[float, Field(ge=0.3, le=5.0)] = 1.2
    """How long a switch's scanning rests on each choice, s."""


class Scene(Message):
    """What does not change while the chair drives."""

    name: str
    description: str
    simulation: bool
    seed: int
    floor: Floor
    places: tuple[Place, ...]
    doors: tuple[Doorway, ...]
    chair: Chair
    modes: tuple[Mode, ...]
