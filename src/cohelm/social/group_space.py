"""Group space: convex hull of the members' personal spaces over the horizon."""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers, read_only
from cohelm.kernels import CACHED
from cohelm.messages import Groups, GroupSpaces, People, Predictions, SocialSpaces
from cohelm.shapes import RadialShape, support


class _Members(NamedTuple):
    """Spaces of n people in h hypotheses over N + 1 steps."""

    group: Integers
    """(n,) −1: alone."""
    weight: Floats
    """(n, h) probabilities."""
    position: Floats
    """(n, h, N+1, 2) m."""
    axis: Floats
    """(n, h, N+1) rad."""
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
    direction, cos, sin = _normals(directions)
    members = _Members(
        groups.member,
        predictions.weight,
        predictions.mean,
        spaces.axis,
        spaces.front,
        spaces.side,
        spaces.rear,
        people.radius,
    )
    form = (spaces.kind, spaces.scale, spaces.floor)
    found = _supports(members, len(groups.id), form, cos, sin)
    found.flags.writeable = False
    return GroupSpaces(id=groups.id, direction=direction, support=found)


@lru_cache(maxsize=8)
def _normals(directions: int) -> tuple[Floats, Floats, Floats]:
    """(angle, rad, its cosine, its sine) of evenly spaced directions, (m,) each."""
    angle = 2.0 * np.pi * np.arange(directions) / directions
    return read_only(angle), read_only(np.cos(angle)), read_only(np.sin(angle))


@njit(**CACHED)
def _supports(
    members: _Members, count: int, form: tuple[int, float, float], cos: Floats, sin: Floats
) -> Floats:
    """Maximum of p·u (count, N+1, m) over the members' grown spaces; u = (cos, sin), (m,).

    form: (kind, scale, floor) of all shapes.
    """
    kind, scale, floor = form
    steps, m = members.position.shape[2], cos.shape[0]
    out = np.full((count, steps, m), -np.inf)
    for i in range(members.group.shape[0]):
        if members.group[i] < 0:
            continue
        best, radius, h = out[members.group[i]], members.radius[i], members.weight[i].argmax()
        for k in range(steps):
            x, y = members.position[i, h, k, 0], members.position[i, h, k, 1]
            ahead, aside = np.cos(members.axis[i, h, k]), np.sin(members.axis[i, h, k])
            sigmas = members.front[i, h, k], members.side[i, h, k], members.rear[i, h, k]
            shape = RadialShape(kind, sigmas[0], sigmas[1], sigmas[2], scale, floor)
            for j in range(m):
                far = support(
                    shape, ahead * cos[j] + aside * sin[j], ahead * sin[j] - aside * cos[j]
                )
                best[k, j] = max(best[k, j], x * cos[j] + y * sin[j] + far + radius)
    return out
