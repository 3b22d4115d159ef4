"""Outlines of personal and group spaces as polygons, for pictures and viewers."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Floats
from cohelm.messages import SocialSpaces
from cohelm.shapes import hull_outline, outline


def space_outline(
    spaces: SocialSpaces,
    index: tuple[int, int, int],
    centre: Floats,
    *,
    margin: float = 0.0,
    count: int = 72,
) -> Floats:
    """Closed outline (count + 1, 2) of one personal space, map frame, m.

    Args:
        spaces: Personal spaces over the horizon.
        index: Person, hypothesis and step of the horizon.
        centre: Position (2,) of the person at that step, m.
        margin: Added to the extent in every direction, as the radius of the body, m.
        count: Number of edges.
    """
    pose = np.array([centre[0], centre[1], spaces.axis[index]])
    return outline(spaces.shape(*index), margin, pose, count)


def group_outlines(spaces: SocialSpaces | None, step: int = 0) -> list[Floats]:
    """Closed outlines (m + 1, 2) of the group spaces at a step of the horizon, map frame, m."""
    if spaces is None or spaces.groups is None:
        return []
    direction = spaces.groups.direction
    return [hull_outline(direction, support) for support in spaces.groups.support[:, step]]
