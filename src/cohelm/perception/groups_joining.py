"""From evidence about pairs to groups that keep their ids."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers


@njit(cache=True)
def clusters(evidence: Floats, chain: float) -> Integers:
    """The cluster of each of n people (n,): the index of its first member.

    Those two clusters are joined of which it is most likely, as long as that is positive:

        (1 − chain) · mean + chain · max   of the evidence of all pairs between them

    Average linkage (chain = 0) keeps strangers apart who are each near the next only; single
    linkage (1) finds all of a long row. Who walks at the far end of a row belongs to it by a
    strong neighbour, not by all of it.

    Args:
        evidence: (n, n) of each pair, symmetric; the diagonal is not looked at.
        chain: 0…1.
    """
    n = evidence.shape[0]
    label, total, most = np.arange(n), evidence.copy(), evidence.copy()
    size, alive = np.ones(n), np.ones(n, dtype=np.bool_)
    while True:
        best, a, b = 0.0, -1, -1
        for i in range(n):
            if not alive[i]:
                continue
            for j in range(i + 1, n):
                if alive[j]:
                    mean = total[i, j] / (size[i] * size[j])
                    link = (1.0 - chain) * mean + chain * most[i, j]
                    if link > best:
                        best, a, b = link, i, j
        if a < 0:
            return label
        for k in range(n):
            total[a, k] += total[b, k]
            total[k, a] = total[a, k]
            most[a, k] = max(most[a, k], most[b, k])
            most[k, a] = most[a, k]
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
