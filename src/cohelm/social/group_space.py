"""Group space: convex hull of the members' personal spaces over the horizon."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.messages import Groups, GroupSpaces, People, Predictions, SocialSpaces
from cohelm.shapes import RadialShape, support


class _Members(NamedTuple):
    """Spaces of n people in their most likely hypothesis over N + 1 steps."""

    group: Integers
    """(n,) −1: alone."""
    position: Floats
    """(n, N+1, 2) m."""
    axis: Floats
    """(n, N+1) rad."""
    front: Floats
    side: Floats
    rear: Floats
    radius: Floats
    """(n,) m."""


def group_spaces(
    people: People,
    groups: Groups,
    predictions: Predictions,
    spaces: SocialSpaces,
    directions: int = 32,
) -> GroupSpaces:
    """Compute the hull of each group's personal spaces at every step.

    The support of a hull is the maximum of its members'. Each person follows their most likely
    hypothesis: a hull of all hypotheses would block the floor around a group that only stands
    there. A personal space is grown by the body, as between the chair and one person.

    Args:
        people: n people.
        groups: of these people.
        predictions: of their motion.
        spaces: of each person.
        directions: number of normals; the outline is too large by at most
            1 / cos(π / directions) − 1 of its radius of curvature, 0.5 % with 32.
    """
    direction = 2.0 * np.pi * np.arange(directions) / directions
    n = len(people)
    likely = predictions.weight.argmax(axis=1) if n else np.empty(0, dtype=np.int64)
    at = (np.arange(n), likely)
    members = _Members(
        groups.member,
        predictions.mean[at],
        spaces.axis[at],
        spaces.front[at],
        spaces.side[at],
        spaces.rear[at],
        people.radius,
    )
    found = _supports(
        members,
        len(groups.id),
        (spaces.kind, spaces.scale, spaces.floor),
        np.cos(direction),
        np.sin(direction),
    )
    return GroupSpaces(id=groups.id, direction=direction, support=found)


@njit(cache=True)
def _supports(
    members: _Members, count: int, form: tuple[int, float, float], cos: Floats, sin: Floats
) -> Floats:
    """Maximum of p·u (count, N+1, m) over the members' grown spaces; u = (cos, sin), (m,).

    form: (kind, scale, floor) of all shapes.
    """
    kind, scale, floor = form
    steps, m = members.position.shape[1], cos.shape[0]
    out = np.full((count, steps, m), -np.inf)
    for i in range(members.group.shape[0]):
        if members.group[i] < 0:
            continue
        best, radius = out[members.group[i]], members.radius[i]
        for k in range(steps):
            x, y = members.position[i, k, 0], members.position[i, k, 1]
            ahead, aside = np.cos(members.axis[i, k]), np.sin(members.axis[i, k])
            shape = RadialShape(
                kind, members.front[i, k], members.side[i, k], members.rear[i, k], scale, floor
            )
            for j in range(m):
                far = support(
                    shape, ahead * cos[j] + aside * sin[j], ahead * sin[j] - aside * cos[j]
                )
                best[k, j] = max(best[k, j], x * cos[j] + y * sin[j] + far + radius)
    return out
