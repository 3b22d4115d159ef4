"""Clusters of people from evidence about pairs, and their persistent ids."""

from __future__ import annotations

import numpy as np
from numba import njit

from cohelm.arrays import Booleans, Floats, Integers
from cohelm.kernels import CACHED


@njit(**CACHED)
def cluster_people(evidence: Floats, linkage: float) -> Integers:
    """Cluster n people; the label (n,) of a cluster is the index of its first member.

    The two clusters with the largest link are joined, as long as it is positive:

        (1 − linkage) · mean + linkage · max   of the evidence of all pairs between them

    Average linkage (0) separates chains of strangers; single linkage (1) finds all of a long row,
    whose ends are joined only by their neighbours.

    Args:
        evidence: (n, n) of each pair, symmetric; the diagonal is ignored.
        linkage: 0…1.
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
                    link = (1.0 - linkage) * mean + linkage * most[i, j]
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


@njit(**CACHED)
def inherit_ids(label: Integers, before: Integers, next_id: int) -> tuple[Integers, int]:
    """(id of each person's group (n,), −1: alone; the next unused id).

    A cluster inherits the id that most of its members had. If two clusters claim one id, the one
    with more of its members gets it, so that after merges and splits the larger part keeps the id.
    Other clusters get new ids.

    Args:
        label: (n,) cluster of each person: the index of its first member.
        before: (n,) earlier group id of each person, −1: none.
        next_id: larger than any id used so far.
    """
    n = label.shape[0]
    size, group, open_claim = np.zeros(n, dtype=np.int64), np.full(n, -1), np.zeros(n, np.bool_)
    for i in range(n):
        size[label[i]] += 1
    for i in range(n):
        open_claim[i] = before[i] >= 0 and size[label[i]] > 1
    while True:
        heir, kept = _strongest(label, before, open_claim)
        if heir < 0:
            break
        for i in range(n):
            if label[i] == heir:
                group[i] = kept
            if label[i] == heir or before[i] == kept:
                open_claim[i] = False
    for k in range(n):
        if size[k] > 1 and group[k] < 0:
            for i in range(n):
                if label[i] == k:
                    group[i] = next_id
            next_id += 1
    return group, next_id


@njit(**CACHED)
def _strongest(label: Integers, before: Integers, open_claim: Booleans) -> tuple[int, int]:
    """(cluster, id) that share the most people; the oldest id among equals, −1 without a claim."""
    most, heir, kept = 0, -1, -1
    for k in range(len(label)):
        if not open_claim[k]:
            continue
        common = 0
        for i in range(len(label)):
            common += label[i] == label[k] and before[i] == before[k]
        if common > most or (common == most and before[k] < kept):
            most, heir, kept = common, label[k], before[k]
    return heir, kept
