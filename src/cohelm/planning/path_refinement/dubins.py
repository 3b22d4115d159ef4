"""Arcs and straight lines: poses along them, and those that lead to a pose (Dubins, 1957)."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.kernels import CACHED


@njit(**CACHED)
def drive_arc(pose: Floats, kappa: float, length: float, out: Floats) -> None:
    """Write the pose after an arc of curvature ``kappa`` (1/m) and a length (m) into ``out``."""
    turn = kappa * length
    half = 0.5 * turn
    chord = length * (math.sin(half) / half if abs(half) > 1e-9 else 1.0)
    out[0] = pose[0] + chord * math.cos(pose[2] + half)
    out[1] = pose[1] + chord * math.sin(pose[2] + half)
    out[2] = pose[2] + turn


@njit(**CACHED)
def dubins_words(pose: Floats, goal: Floats, radius: float) -> Floats:
    """Words (w, 3, 2) of (curvature, length): arc, line, arc to a pose; arc, line to a point.

    With centres of turning circles c, side σ = 1 left and −1 right, and headings φ of the line of
    length L: c₂ − c₁ = e^{iφ} L on the same side, e^{iφ} (L − 2iσ₁r) across; to a point,
    p − c₁ = e^{iφ} (L − iσ₁r). A goal whose heading is NaN is a point.
    """
    to_point = math.isnan(goal[2])
    out = np.full((4, 3, 2), np.inf)
    for w in range(2 if to_point else 4):
        # Sides of the first and the last circle: LL, RR, LR, RL.
        first = 1.0 if w % 2 == 0 else -1.0
        second = first if w < 2 else -first
        dx = goal[0] - (pose[0] - first * radius * math.sin(pose[2]))
        dy = goal[1] - (pose[1] + first * radius * math.cos(pose[2]))
        aside = first * radius
        if not to_point:
            dx -= second * radius * math.sin(goal[2])
            dy += second * radius * math.cos(goal[2])
            aside = 0.0 if w < 2 else 2.0 * first * radius
        square = dx * dx + dy * dy - aside * aside
        if square < 0.0:
            continue
        line = math.sqrt(square)
        phi = math.atan2(dy, dx) + math.atan2(aside, line)
        out[w, 0] = first / radius, radius * _full(first * (phi - pose[2]))
        out[w, 1] = 0.0, line
        out[w, 2] = second / radius, 0.0
        if not to_point:
            out[w, 2, 1] = radius * _full(second * (goal[2] - phi))
    return out


@njit(**CACHED)
def _full(angle: float) -> float:
    """``angle`` in [0, 2π); a full turn except for rounding becomes 0."""
    turn = angle % (2.0 * math.pi)
    return turn if turn < 2.0 * math.pi - 1e-7 else 0.0
