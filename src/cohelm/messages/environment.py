"""Trust in the sensors, live obstacles, and the crowding of the floor."""

from __future__ import annotations

from enum import StrEnum

from cohelm.arrays import Annotated, Bytes, Floats, Floats32, Integers, Shape, value


class Sensing(StrEnum):
    """Validity of the sensor data of one tick."""

    OK = "ok"
    """All sensors in time, at least one new reading with returns."""
    SILENT = "silent"
    """No reading since the last observation; tracks coast."""
    NO_RETURNS = "no_returns"
    """Readings without any usable return: an empty hall, or a blind sensor."""
    NO_FLOOR = "no_floor"
    """A recorded cloud of a sensor of unknown mount shows no floor: people are not recognised."""
    CLOCK_FROZEN = "clock_frozen"
    """No reading is newer than the newest of the same sensor before: time is not known."""
    CLOCK_BACKWARDS = "clock_backwards"
    """A reading is older than the newest of the same sensor before, and is dropped. If that
    happens twice in a row, or time ran back by more than a second, all tracks are reset."""
    CLOCK_OFFSET = "clock_offset"
    """A reading's time is more than a second from now, or not a number; it is dropped."""


@value
class Crowding:
    """Usual density of people on a coarse grid over the floor."""

    density: Annotated[Floats32, Shape("rows cols")]
    """People per m²."""
    resolution: float
    """Side of a cell, m."""
    X_MG: Annotated[Floats, Shape("3")]
    """Pose of the grid's lower left corner in the map frame."""


@value
class LiveObstacles:
    """Obstacles that sensors detected and the map does not contain, people excluded.

    A rolling window whose cells are those of the map's grid; ``corner`` gives its position there.
    """

    corner: Annotated[Integers, Shape("2")]
    """(row, column) of the window's first cell in the map's grid; may lie outside it."""
    occupied: Annotated[Bytes, Shape("rows cols")]
    """1 where occupied."""
    version: int
    """Increases whenever a cell changes."""
