"""What a recording is: observations in the order of time, and what others say was there."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.messages import Observation


@value
class Labels:
    """Where people, or parts of people, truly were; k of them."""

    time: float
    """s."""
    position: Annotated[Floats, Shape("k 2")]
    """Map frame, m."""
    id: Annotated[Integers, Shape("k")]
    """Stable over a person's life; −1: not told."""
    visible: Annotated[Floats, Shape("k")]
    """Share of the body that the sensor could see, 0…1; 1 where not told."""


@value
class Frame:
    """One instant of a recording."""

    observation: Observation
    labels: Labels | None = None
    """None: nobody said."""
    posed: bool = True
    """Whether the recording says where the robot was; if not, its pose is (0, 0, 0)."""


class Recording(Protocol):
    """A file of sensor readings, read as it is iterated over."""

    name: str
    """Of the file, for people."""
    frames: int | None
    """How many there are, or fewer where some cannot be read; None: not known before."""
    warnings: list[str]
    """What could not be read, and where, and what had to be assumed, in one line each; grows while
    it is read."""

    def __iter__(self) -> Iterator[Frame]:
        """The frames in the order of time, from the first one on.

        Raises:
            RecordingError: if nothing can be read, naming the file and, where one is at fault, the
                byte.
        """
        ...
