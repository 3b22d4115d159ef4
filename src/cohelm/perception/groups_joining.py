"""From evidence about pairs to groups that keep their ids."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers


@njit(cache=True)
def clusters(evidence: Floats) -> Integers:
    """The cluster of each of n people (n,): the index of its first member.

    Those two clusters are joined whose members speak most for it, on average over all pairs
    between them, as long as that is positive (average linkage). So a chain of strangers, each near
    the next only, does not become one group, and one who walks at the far end of a row does belong.

    Args:
        evidence: (n, n) of each pair, symmetric; the diagonal is not looked at.
    """
    n = evidence.shape[0]
    label, total = np.arange(n), evidence.copy()
    size, alive = np.ones(n), np.ones(n, dtype=np.bool_)
    while True:
        best, a, b = 0.0, -1, -1
        for i in range(n):
            if not alive[i]:
                continue
            for j in range(i + 1, n):
                if alive[j]:
                    mean = total[i, j] / (size[i] * size[j])
                    if mean > best:
                        best, a, b = mean, i, j
        if a < 0:
            return label
        for k in range(n):
            total[a, k] += total[b, k]
            total[k, a] = total[a, k]
            if label[k] == b:
                label[k] = a
        size[a] += size[b]
        alive[b] = False


@njit(cache=True)
def inherit(label: Integers, before: Integers, next_id: int) -> tuple[Integers, int]:
    """(id of each one's group (n,), −1: alone; the next id that is free).

    A cluster goes on with the id that most of its members had; where two want the same, who has
    more of its members gets it, so that merges and splits leave the id with the larger part. All
    others get ids that were never used.

    Args:
        label: (n,) cluster of each: the index of its first member.
        before: (n,) id of the group that each was in, −1: none.
        next_id: larger than any id used so far.
    """
    n = label.shape[0]
    size = np.bincount(label, minlength=n)
    group = np.full(n, -1)
    open_claim = (before >= 0) & (size[label] > 1)
    while open_claim.any():
        heir, kept = _strongest(label, before, open_claim)
        group[label == heir] = kept
        open_claim &= (label != heir) & (before != kept)
    for k in range(n):
        if size[k] > 1 and group[k] < 0:
            group[label == k] = next_id
            next_id += 1
    return group, next_id


@njit(cache=True)
def _strongest(label: Integers, before: Integers, open_claim: Booleans) -> tuple[int, int]:
    """The cluster and the id that share the most people; of equals, the oldest id's first."""
    most, heir, kept = 0, -1, -1
    for k in np.flatnonzero(open_claim):
        common = ((label == label[k]) & (before == before[k])).sum()
        if common > most or (common == most and before[k] < kept):
            most, heir, kept = common, label[k], before[k]
    return heir, kept
