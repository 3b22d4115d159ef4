"""People who stream along a lane, each keeping to a place across it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from cohelm.arrays import Floats
from cohelm.evaluation.company import Flow, Way
from cohelm.geometry import arc_length

APART = 0.8
"""Between the starts of two people of a flow, m at least, as long as there is room."""
OFF_CHAIR = 1.8
"""Between the start of one and the chair, m."""
_TRIES = 30


def flow_ways(
    flows: Sequence[Flow], count: int, chair: Floats, rng: np.random.Generator
) -> list[Way]:
    """A way for each person of the flows.

    Args:
        flows: the lanes.
        count: people in all of them; shared in proportion to what each asks for.
        chair: (2,) where it starts, m.
        rng: places and who comes first are drawn from it; nothing is where there are no flows.
    """
    if not flows or count <= 0:
        return []
    ways: list[Way] = []
    for flow, share in zip(flows, _shares([flow.count for flow in flows], count), strict=True):
        ways += _ways(flow, share, chair, rng)
    return ways


def _shares(wanted: Sequence[int], count: int) -> list[int]:
    """``count`` in whole parts in proportion to ``wanted``; the largest remainders round up."""
    exact = np.array(wanted) * count / sum(wanted)
    parts = np.floor(exact).astype(int)
    rest = np.argsort(parts - exact, kind="stable")[: count - parts.sum()]
    parts[rest] += 1
    return [int(part) for part in parts]


def _ways(flow: Flow, count: int, chair: Floats, rng: np.random.Generator) -> list[Way]:
    lane = np.array(flow.lane)
    if flow.loop:
        lane = np.vstack([lane, lane[:1]])
    sideways = sideways_of(lane, closed=flow.loop)
    along = arc_length(lane)
    reach = min(flow.spread or along[-1], along[-1])
    starts: list[Floats] = []
    ways = []
    for i in range(count):
        best, room = (0.0, 0.0, lane[0]), -1.0
        for _ in range(_TRIES):  # the first that is far enough from the others, else the farthest
            s = reach * (i + rng.random()) / count
            aside = flow.width * (rng.random() - 0.5)
            at = _point(lane + aside * sideways, along, s)
            apart = float(np.hypot(*(at - chair))) + APART - OFF_CHAIR
            apart = min((apart, *(float(np.hypot(*(at - other))) for other in starts)))
            if apart > room:
                best, room = (s, aside, at), apart
            if apart >= APART:
                break
        s, aside, at = best
        starts.append(at)
        ways.append(_way(flow, lane + aside * sideways, along, s))
    return ways


def _way(flow: Flow, line: Floats, along: Floats, s: float) -> Way:
    """From ``s`` on along a line (k, 2), round it where it is a loop."""
    ahead = line[np.flatnonzero(along > s + 1e-6)]
    behind = line[1:][along[1:] <= s + 1e-6] if flow.loop else line[:0]
    points = np.vstack([_point(line, along, s)[None], ahead, behind])
    return Way(
        points=tuple((float(x), float(y)) for x, y in points),
        loop=flow.loop,
        speed=flow.speed,
        see_robot=flow.see_robot,
    )


def sideways_of(lane: Floats, *, closed: bool) -> Floats:
    """By what each corner (k, 2) of a lane moves that is moved one metre to the left."""
    way = np.diff(lane, axis=0)
    left = np.stack([-way[:, 1], way[:, 0]], axis=-1) / np.hypot(*way.T)[:, None]
    before = np.vstack([left[-1:] if closed else left[:1], left])
    after = np.vstack([left, left[:1] if closed else left[-1:]])
    both = before + after  # along the bisector, and longer the sharper the bend
    size: Floats = (both**2).sum(axis=-1, keepdims=True)
    return np.asarray(2.0 * both / np.maximum(size, 0.5))


def _point(line: Floats, along: Floats, s: float) -> Floats:
    return np.array([np.interp(s, along, line[:, i]) for i in (0, 1)])
