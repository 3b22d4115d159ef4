"""Evidence in the cells of the live obstacle layer: hits add, crossing beams take."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Bytes, Floats, Integers, SignedBytes
from cohelm.kernels import CACHED, callee


class EvidenceAmounts(NamedTuple):
    """Evidence of one scan in a cell."""

    hit: int
    miss: int
    most: int
    """Upper bound of the evidence of a cell."""


@njit(**CACHED)
def find_unexplained_returns(
    points: Floats,
    mapped: Booleans,
    detection_of_return: Integers,
    position: Floats,
    people: Floats,
    body: Floats,
    reach: float,
) -> Booleans:
    """Find the returns (p,) that neither the map nor a tracked person explains: obstacles.

    Args:
        points, mapped, detection_of_return, position: as in ``Detections``.
        people: tracked people, (n, ≥2), m.
        body: (n,) distance from each person within which a return is theirs, m.
        reach: distance within which a detection is a tracked person, m.
    """
    tracked = np.zeros(position.shape[0], dtype=np.bool_)
    for j in range(position.shape[0]):
        for t in range(people.shape[0]):
            dx, dy = position[j, 0] - people[t, 0], position[j, 1] - people[t, 1]
            tracked[j] |= math.hypot(dx, dy) < reach
    unexplained = ~mapped
    for i in range(points.shape[0]):
        if detection_of_return[i] >= 0 and tracked[detection_of_return[i]]:
            unexplained[i] = False
        for t in range(people.shape[0]):
            dx, dy = points[i, 0] - people[t, 0], points[i, 1] - people[t, 1]
            if unexplained[i] and abs(dx) < body[t] and math.hypot(dx, dy) < body[t]:
                unexplained[i] = False
    return unexplained


@njit(**CACHED)
def mark_and_clear(
    evidence: SignedBytes,
    origin: Floats,
    ends: Floats,
    is_obstacle: Booleans,
    margin: Floats,
    amounts: EvidenceAmounts,
) -> None:
    """Add and take evidence for the beams from ``origin`` to ``ends``, in cells (column, row).

    A cell is hit or missed at most once per scan, and a hit outweighs every miss.

    Args:
        evidence: (rows, cols), in place.
        origin: (2,).
        ends: (p, 2).
        is_obstacle: (p,) True for ends at an unexplained object.
        margin: (p,) last part of each beam that clears nothing.
        amounts: evidence of a hit and of a miss, and its upper bound.
    """
    rows, cols = evidence.shape
    hit, miss, most = amounts
    done = np.zeros((rows, cols), dtype=np.uint8)
    for i in range(ends.shape[0]):
        if not is_obstacle[i]:
            continue
        c, r = math.floor(ends[i, 0]), math.floor(ends[i, 1])
        if 0 <= r < rows and 0 <= c < cols and not done[r, c]:
            done[r, c] = 1
            evidence[r, c] = min(evidence[r, c] + hit, most)
    cells, at = beam_buffers(origin, ends)
    for i in range(ends.shape[0]):
        for k in range(crossed_cells(origin, ends[i], margin[i], cells, at)):
            r, c = cells[k, 0], cells[k, 1]
            inside = 0 <= r < rows and 0 <= c < cols
            if inside and evidence[r, c] != 0 and not done[r, c]:  # most cells are 0
                done[r, c] = 1
                evidence[r, c] = max(evidence[r, c] - miss, 0)


@njit(**CACHED)
def is_empty(cells: Bytes) -> bool:
    """Check that all cells are 0, the usual case; eight cells are compared at once."""
    flat = cells.reshape(-1)
    words = flat.size // 8
    for eight in flat[: 8 * words].view(np.uint64):
        if eight != 0:
            return False
    return not flat[8 * words :].any()


@callee()
def beam_buffers(origin: Floats, ends: Floats) -> tuple[Integers, Floats]:
    """Empty buffers for the cells on the longest beam from ``origin`` to one of ``ends``."""
    most = 0.0
    for i in range(ends.shape[0]):
        most = max(most, abs(ends[i, 0] - origin[0]) + abs(ends[i, 1] - origin[1]))
    size = int(most) + 4
    return np.empty((size, 2), dtype=np.int64), np.empty(size)


@callee()
def crossed_cells(origin: Floats, end: Floats, margin: float, cells: Integers, at: Floats) -> int:
    """Find the cells that a beam crosses (Amanatides and Woo 1987); return their number.

    Args:
        origin: (column, row) of the start.
        end: (column, row) of the end.
        margin: last part that is left out, in cells.
        cells: (row, column) of each, in place.
        at: travelled length at the entry into each, in cells, in place.
    """
    dx, dy = end[0] - origin[0], end[1] - origin[1]
    length = math.hypot(dx, dy)
    if length <= margin:
        return 0
    dx, dy, stop = dx / length, dy / length, length - margin
    c, r = math.floor(origin[0]), math.floor(origin[1])
    step_c, step_r = (1 if dx > 0.0 else -1), (1 if dy > 0.0 else -1)
    per_c = 1.0 / abs(dx) if dx != 0.0 else np.inf
    per_r = 1.0 / abs(dy) if dy != 0.0 else np.inf
    to_c = ((c + 1 - origin[0]) if dx > 0.0 else (origin[0] - c)) * per_c if dx != 0.0 else np.inf
    to_r = ((r + 1 - origin[1]) if dy > 0.0 else (origin[1] - r)) * per_r if dy != 0.0 else np.inf
    travelled = 0.0
    count = 0
    while travelled < stop and count < at.size:
        cells[count, 0], cells[count, 1], at[count] = r, c, travelled
        count += 1
        if to_c < to_r:
            travelled, to_c, c = to_c, to_c + per_c, c + step_c
        else:
            travelled, to_r, r = to_r, to_r + per_r, r + step_r
    return count


@njit(**CACHED)
def clear_people(evidence: SignedBytes, bodies: Floats, resolution: float) -> None:
    """Clear the cells of people (n, 3) of (column, row, radius in m)."""
    rows, cols = evidence.shape
    for t in range(bodies.shape[0]):
        x, y, radius = bodies[t, 0], bodies[t, 1], bodies[t, 2] / resolution + 1.0
        for r in range(max(int(y - radius), 0), min(int(y + radius) + 1, rows)):
            for c in range(max(int(x - radius), 0), min(int(x + radius) + 1, cols)):
                if math.hypot(c + 0.5 - x, r + 0.5 - y) <= radius:
                    evidence[r, c] = 0


@njit(**CACHED)
def update_occupied(evidence: SignedBytes, occupied: Bytes, occupied_from: int) -> bool:
    """Update ``occupied`` from ``evidence`` in place; return True if a cell changed.

    Most cells are free and without evidence: eight of them are skipped at once.
    """
    changed = False
    e, o = evidence.reshape(-1), occupied.reshape(-1)
    words = e.size // 8
    some_e, some_o = e[: 8 * words].view(np.uint64), o[: 8 * words].view(np.uint64)
    for word in range(words + 1):
        if word < words and some_e[word] == 0 and some_o[word] == 0:
            continue
        for i in range(8 * word, min(8 * word + 8, e.size)):
            if (e[i] >= occupied_from and not o[i]) or (e[i] <= 0 and o[i]):
                o[i] = 1 - o[i]
                changed = True
    return changed
