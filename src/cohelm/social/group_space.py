"""Group space: the convex hull of the members' personal spaces, as it moves over the horizon."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Floats, Integers
from cohelm.messages import Groups, GroupSpaces, People, Predictions, SocialSpaces
from cohelm.shapes import support


def group_spaces(
    people: People,
    groups: Groups,
    predictions: Predictions,
    spaces: SocialSpaces,
    directions: int = 32,
) -> GroupSpaces:
    """The hull of each group's personal spaces at every step.

    The hull of a union reaches in each direction as far as the farthest of its members. Everyone
    is where their most likely hypothesis has them: a hull of all that each might do would close
    the floor about a group that only stands there. A personal space is grown by the body, as it
    is between the chair and one person.

    Args:
        people: n of them.
        groups: who belongs together.
        predictions: where everybody will be.
        spaces: of each person alone.
        directions: how many normals the hull is told by; the outline is too large by at most
            1 / cos(π / directions) − 1 of its radius of curvature, 0.5 % with 32.
    """
    direction = 2.0 * np.pi * np.arange(directions) / directions
    likely = predictions.weight.argmax(axis=1) if len(people) else np.empty(0, dtype=np.int64)
    reach = _supports(
        groups.member,
        len(groups.id),
        likely,
        predictions.mean,
        spaces.kind,
        spaces.axis,
        spaces.front,
        spaces.side,
        spaces.rear,
        spaces.scale,
        spaces.floor,
        people.radius,
        np.cos(direction),
        np.sin(direction),
    )
    return GroupSpaces(id=groups.id, direction=direction, support=reach)


@njit(cache=True)
def _supports(  # noqa: PLR0913, PLR0917  # a kernel takes what it works on one by one
    member: Integers,
    count: int,
    likely: Integers,
    mean: Floats,
    kind: int,
    axis: Floats,
    front: Floats,
    side: Floats,
    rear: Floats,
    scale: float,
    floor: float,
    radius: Floats,
    cos: Floats,
    sin: Floats,
) -> Floats:
    """The greatest p·u (count, N+1, m) over the members' grown spaces; u = (cos, sin), (m,)."""
    steps, m = mean.shape[2], cos.shape[0]
    out = np.full((count, steps, m), -np.inf)
    for i in range(member.shape[0]):
        if member[i] < 0:
            continue
        best, h = out[member[i]], likely[i]
        for k in range(steps):
            x, y = mean[i, h, k, 0], mean[i, h, k, 1]
            ahead, aside = np.cos(axis[i, h, k]), np.sin(axis[i, h, k])
            for j in range(m):
                reach = support(
                    kind,
                    front[i, h, k],
                    side[i, h, k],
                    rear[i, h, k],
                    scale,
                    floor,
                    ahead * cos[j] + aside * sin[j],
                    ahead * sin[j] - aside * cos[j],
                )
                best[k, j] = max(best[k, j], x * cos[j] + y * sin[j] + reach + radius[i])
    return out
