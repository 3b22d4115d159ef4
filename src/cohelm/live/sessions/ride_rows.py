"""Rows of a ride: one for each tick, float32 in the byte order of the machine.

    n, the number of people │ CHAIR_SIZE numbers about the chair │ PERSON_SIZE numbers × n

``ride_log`` writes them to a file, ``measuring`` reads them.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from cohelm.arrays import Floats, Floats32
from cohelm.errors import StoreError
from cohelm.evaluation.episode.ride_log import row_of, states_of
from cohelm.navigation import Tick
from cohelm.simulation import GroundTruth


class ChairColumn:
    """Columns about the chair; those from ``COMMAND`` on are ``evaluation``'s ``row_of``."""

    TIME = 0
    """Since the first tick, s."""
    POSE = slice(1, 4)
    TWIST = slice(4, 7)
    GAP_WALL = 7
    HIT_WALL = 8
    COMMAND = slice(9, 12)
    REQUESTED = slice(12, 15)
    STICK = slice(15, 17)
    ETA = 17


class PersonColumn:
    """Columns about one person."""

    GAP = 0
    HIT_MOVING = 1
    HIT_STANDING = 2
    STATE = slice(3, 7)
    """(x, y, v_x, v_y)."""
    HEADING = 7
    WAYPOINT = 8
    RADIUS = 9


CHAIR_SIZE = 18
PERSON_SIZE = 10


def row_of_tick(tick: Tick, truth: GroundTruth, begun: float) -> Floats32:
    """Return the row (1 + CHAIR_SIZE + n · PERSON_SIZE,) of a tick.

    Args:
        tick: Tick of the navigator.
        truth: Ground truth at the same time.
        begun: Time of the first tick, s.
    """
    crowd = truth.crowd
    n = len(crowd.radius)
    out = np.empty(1 + CHAIR_SIZE + n * PERSON_SIZE, dtype=np.float32)
    out[0] = n
    chair, people = out[1 : 1 + CHAIR_SIZE], out[1 + CHAIR_SIZE :].reshape(n, PERSON_SIZE)
    chair[ChairColumn.TIME] = truth.time - begun
    chair[ChairColumn.POSE], chair[ChairColumn.TWIST] = truth.pose, truth.twist
    chair[ChairColumn.GAP_WALL], chair[ChairColumn.HIT_WALL] = truth.gap_wall, truth.hit_wall
    chair[ChairColumn.COMMAND.start :] = row_of(tick)
    people[:, PersonColumn.GAP] = truth.gap_people
    people[:, PersonColumn.HIT_MOVING] = truth.hit_moving
    people[:, PersonColumn.HIT_STANDING] = truth.hit_standing
    people[:, PersonColumn.STATE] = states_of(crowd)
    people[:, PersonColumn.HEADING] = crowd.heading
    people[:, PersonColumn.WAYPOINT] = crowd.target
    people[:, PersonColumn.RADIUS] = crowd.radius
    return out


def read_rows(file: Path) -> tuple[Floats, Floats]:
    """Return the complete rows of a file.

    Returns:
        (k, CHAIR_SIZE) for the chair, and (k, n, PERSON_SIZE) for people; before a person appeared
        they are NaN, infinitely far and in contact with nothing.

    Raises:
        StoreError: The file cannot be read, or holds no complete row.
    """
    try:
        numbers = np.fromfile(file, dtype=np.float32)
    except OSError as cause:
        raise StoreError(f"cannot be read ({cause.strerror or cause})", file=file) from None
    starts, counts = _complete_rows(numbers)
    if not len(starts):
        raise StoreError("holds no tick", file=file)
    chair = np.stack([numbers[s + 1 : s + 1 + CHAIR_SIZE] for s in starts]).astype(np.float64)
    people = np.full((len(starts), max(counts), PERSON_SIZE), np.nan)
    people[:, :, PersonColumn.GAP] = np.inf
    for column in (
        PersonColumn.HIT_MOVING,
        PersonColumn.HIT_STANDING,
        PersonColumn.HEADING,
        PersonColumn.WAYPOINT,
    ):
        people[:, :, column] = 0.0
    for k, (s, n) in enumerate(zip(starts, counts, strict=True)):
        first = s + 1 + CHAIR_SIZE
        people[k, :n] = numbers[first : first + n * PERSON_SIZE].reshape(n, PERSON_SIZE)
    return chair, people


def _complete_rows(numbers: Floats32) -> tuple[list[int], list[int]]:
    """Start of each complete row, and its number of people; the last row may be incomplete."""
    starts, counts, at = [], [], 0
    while at < len(numbers):
        n = int(numbers[at])
        end = at + 1 + CHAIR_SIZE + n * PERSON_SIZE
        if n < 0 or end > len(numbers):
            break
        starts.append(at)
        counts.append(n)
        at = end
    return starts, counts
