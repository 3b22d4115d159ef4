"""People who belong together: abreast where they walk, round a common space where they stand."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.evaluation.company import Group, Way
from cohelm.evaluation.flows import sideways_of

ABREAST = 3
"""So many at most walk side by side; the others follow (Moussaïd et al. 2010: larger groups split
up)."""
ROWS = 1.0
"""Between one row and the next, m (assumed)."""


def group_ways(groups: Sequence[Group], count: int, speeds: Floats) -> tuple[list[Way], Integers]:
    """A way for each member, and the number of the group of each, (m,).

    Args:
        groups: as a scenario has them.
        count: of people at most; the last ones are left out.
        speeds: (m,) or more, preferred ones; a group that names none has its first member's, m/s.
    """
    ways: list[Way] = []
    numbers: list[int] = []
    for number, group in enumerate(groups):
        first = len(ways)
        if first >= count:
            break
        speed = float(speeds[first]) if group.speed is None else group.speed
        ways += _standing(group, speed) if len(group.points) == 1 else _walking(group, speed)
        numbers += [number] * group.size
    return ways[:count], np.array(numbers[:count], dtype=np.int64)


def _walking(group: Group, speed: float) -> list[Way]:
    """In rows of up to three, each member beside the common way by the same everywhere."""
    lane = np.array(group.points)
    aside = sideways_of(np.vstack([lane, lane[:1]]) if group.loop else lane, closed=group.loop)
    ahead = (lane[1] - lane[0]) / max(float(np.hypot(*(lane[1] - lane[0]))), 1e-9)
    out = []
    for i in range(group.size):
        row, place = divmod(i, ABREAST)
        abreast = min(group.size - row * ABREAST, ABREAST)
        offset = (place - 0.5 * (abreast - 1)) * group.spacing
        line = lane + offset * aside[: len(lane)]
        line[0] -= row * ROWS * ahead
        out.append(_way(group, line, speed))
    return out


def _standing(group: Group, speed: float) -> list[Way]:
    """On a circle with ``spacing`` from neighbour to neighbour, all of them facing its middle."""
    middle = np.array(group.points[0])
    radius = 0.5 * group.spacing / math.sin(math.pi / group.size)
    out = []
    for i in range(group.size):
        angle = 2.0 * math.pi * i / group.size
        place = middle + radius * np.array([math.cos(angle), math.sin(angle)])
        facing = math.degrees(math.remainder(angle + math.pi, 2.0 * math.pi))
        out.append(_way(group, place[None], speed).model_copy(update={"facing_deg": facing}))
    return out


def _way(group: Group, line: Floats, speed: float) -> Way:
    return Way(
        points=tuple((float(x), float(y)) for x, y in line),
        loop=group.loop,
        speed=speed,
        see_robot=group.see_robot,
    )
