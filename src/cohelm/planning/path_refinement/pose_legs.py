"""Legs of a path over (x, y, heading), and the poses along them.

A leg is a row: the pose at its start, its curvature and its length, negative backwards; for a turn
on the spot the curvature is infinite and the length is the turn.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.array_kernels import copy_row
from cohelm.arrays import Floats, Integers
from cohelm.kernels import CACHED
from cohelm.planning.path_refinement.dubins import drive_arc
from cohelm.planning.path_refinement.pose_nodes import PoseNodes

STEP = 0.1
"""Length of a motion of the search, and distance between poses of a path, m."""


@njit(**CACHED)
def joined_legs(nodes: PoseNodes, last: int, word: Floats) -> Floats:
    """Legs (k, 5) from the seed to ``last`` and along the word."""
    pose, parent, bend = nodes.pose, nodes.parent, nodes.bend
    back = [last]
    while parent[back[-1]] >= 0:
        back.append(parent[back[-1]])
    n = len(back) - 1
    out = np.empty((n + 4, 5))
    for i in range(n):
        u, v = back[n - i], back[n - i - 1]
        copy_row(out[i], pose[u])
        out[i, 3], out[i, 4] = bend[v], nodes.length[v]
    copy_row(out[n], pose[last])
    for k in range(3):
        out[n + k, 3], out[n + k, 4] = word[k, 0], word[k, 1]
        drive_arc(out[n + k, :3], word[k, 0], word[k, 1], out[n + k + 1, :3])
    out[n + 3, 3] = out[n + 3, 4] = 0.0
    return out


@njit(**CACHED)
def sampled_poses(legs: Floats) -> tuple[Floats, Integers, Integers]:
    """(poses (m, 3) along legs, indices of turns on the spot, and of changes of gear).

    Poses are evenly spaced between these places.
    """
    n = legs.shape[0]
    poses = [legs[0, :3].copy()]
    pivots, cusps = [0], [0]
    pivots.pop()
    cusps.pop()
    first, gear = 0, 0.0
    while first < n:
        if legs[first, 3] == np.inf:
            if len(pivots) == 0 or pivots[-1] != len(poses) - 1:
                pivots.append(len(poses) - 1)
            first += 1
            continue
        # A stretch in one gear.
        stop, length = first, 0.0
        while stop < n and legs[stop, 3] != np.inf and legs[stop, 4] * length >= 0.0:
            length += legs[stop, 4]
            stop += 1
        if length * gear < 0.0:
            cusps.append(len(poses) - 1)
        if length != 0.0:
            gear = length
        count = math.ceil(abs(length) / STEP - 1e-6)
        leg, before = first, 0.0
        for k in range(1, count + 1):
            at = abs(length) * k / count
            while leg < stop - 1 and before + abs(legs[leg, 4]) < at:
                before += abs(legs[leg, 4])
                leg += 1
            part = math.copysign(min(at - before, abs(legs[leg, 4])), length)
            fresh = np.empty(3)
            drive_arc(legs[leg, :3], legs[leg, 3], part, fresh)
            poses.append(fresh)
        first = stop
    out = np.empty((len(poses), 3))
    for i in range(len(poses)):
        copy_row(out[i], poses[i])
    return out, np.array(pivots, dtype=np.int64), np.array(cusps, dtype=np.int64)
