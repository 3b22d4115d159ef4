"""Rides in thought: what becomes of a way if the hand steers for it.

Each follows the hand's own law for some seconds, with the chair's box against the things in sight
and the people where they walk.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from cohelm.arrays import Floats

SPACING = 0.1
"""Between points of the wanted way, m."""
STEPS = 24
"""Of each ride in thought."""
GEARS = np.array(
    [
        # share, look ahead, step (s), turns first
        [1.0, 1.0, 0.18, 0.0],
        [0.5, 0.7, 0.25, 0.0],
        [0.25, 0.5, 0.30, 0.0],
        [0.25, 0.5, 0.30, 1.0],
    ]
)
"""In which ways are driven: shares of the hand's deflection forward and of its look ahead, the step
in thought, and whether the chair turns to the way first, on the spot."""
TURNED = 0.2
"""In the last gear the chair goes on when its way is no farther aside than this, rad."""

_HAND = 0.4
"""From seeing to standing, beside the braking itself, s."""
_RISES, _FALLS, _TURNS = 0.8, 1.0, 2.5
"""How fast the chair is reckoned to change its speed, m/s², and its turning, rad/s²."""
_GAP = (0.03, 0.10)
"""Nearer than this to a thing or a person is not driven, m …"""
EASE = (0.2, 0.45)
"""… and nearer than this is not liked, m …"""
_UNEASE = (2.0, 1.5)
"""… by as much as this loss of way, at full speed all the time, m."""
_HORIZON = 3.0
"""For how long people are reckoned to walk on as they do, s."""
_BLOCKED = 1.0
"""A way that ends at something now counts as this loss of way, m; less the later it does."""
_AWAY = 0.3
"""A metre beside the wanted way counts as this loss of way, m."""
_OTHER = 0.2
"""A metre beside the way driven now counts as this loss of way, m."""
_GOOD = 0.3
"""Where a ride counts no more against it than this, no slower one is thought of, m."""
_LEAST = 0.05
"""A way that gets on by less is not worth driving, m."""
_THERE = 0.15
"""So near to its end a way is done, m."""
_ENDS = 0.5
"""Nearer than this to its end only the distance to the end counts, and no way is beside it, m."""


@njit(cache=True)
def bearing(way: Floats, pose: Floats, at: int, beside: float, lookahead: float) -> float:
    """Where a hand steers that is at a way's point ``at``, rad to the left.

    Args:
        way: (m, 4) as (x, y, and the unit vector to its left), ``SPACING`` apart, m.
        pose: of the chair, (3,).
        at: number of the way's point that the chair is at.
        beside: how far to the left of the way the hand steers, m.
        lookahead: how far ahead of the chair it looks along the way, m.
    """
    k = min(at + round(lookahead / SPACING), len(way) - 1)
    beside *= min((len(way) - 1 - k) * SPACING / _ENDS, 1.0)
    dx = way[k, 0] + beside * way[k, 2] - pose[0]
    dy = way[k, 1] + beside * way[k, 3] - pose[1]
    return float((math.atan2(dy, dx) - pose[2] + math.pi) % (2.0 * math.pi) - math.pi)


@njit(cache=True)
def _gap(box: Floats, x: float, y: float) -> float:
    """From a box (x, y low, x, y high) to a point; negative within."""
    ex, ey = max(box[0] - x, x - box[2]), max(box[1] - y, y - box[3])
    if ex > 0.0 and ey > 0.0:
        return math.sqrt(ex * ex + ey * ey)
    return float(max(ex, ey))


@njit(cache=True)
def _gaps(
    points: Floats, people: Floats, box: Floats, pose: Floats, moment: float
) -> tuple[float, float]:
    """To the nearest thing and to the nearest person, m; no more than ``EASE``."""
    c, s = math.cos(pose[2]), math.sin(pose[2])
    thing, person = EASE
    for i in range(len(points)):
        dx, dy = points[i, 0] - pose[0], points[i, 1] - pose[1]
        ahead = c * dx + s * dy
        if box[0] - thing < ahead < box[2] + thing:
            thing = min(thing, _gap(box, ahead, c * dy - s * dx))
    if moment <= _HORIZON:
        for i in range(len(people)):
            dx = people[i, 0] + moment * people[i, 2] - pose[0]
            dy = people[i, 1] + moment * people[i, 3] - pose[1]
            person = min(person, _gap(box, c * dx + s * dy, c * dy - s * dx) - people[i, 4])
    return thing, person


@njit(cache=True)
def _after(way: Floats, pose: Floats, at: int) -> int:
    """Number of the way's point that a chair is at which was at ``at`` before."""
    while at < len(way) - 1:
        dx, dy = way[at + 1, 0] - way[at, 0], way[at + 1, 1] - way[at, 1]
        along = (pose[0] - way[at, 0]) * dx + (pose[1] - way[at, 1]) * dy
        if along < 0.5 * (dx * dx + dy * dy):
            break
        at += 1
    return at


@njit(cache=True)
def _gained(way: Floats, pose: Floats, at: int) -> tuple[float, float]:
    """How far along the way and how far beside it a chair is that is at its point ``at``, m."""
    end = len(way) - 1
    if (end - at) * SPACING < _ENDS:
        left = math.hypot(way[end, 0] - pose[0], way[end, 1] - pose[1])
        return end * SPACING - left, 0.0
    dx, dy = pose[0] - way[at, 0], pose[1] - way[at, 1]
    return at * SPACING + dx * way[at, 3] - dy * way[at, 2], abs(dx * way[at, 2] + dy * way[at, 3])


@njit(cache=True)
def _ride(  # noqa: PLR0913, PLR0917  # a kernel takes them one by one
    way: Floats,
    points: Floats,
    people: Floats,
    twist: Floats,
    box: Floats,
    hand: Floats,
    full: Floats,
    beside: float,
    gear: Floats,
    least: tuple[float, float],
) -> tuple[float, float, float, float]:
    """(way gained, m, when something is met, s (+∞: never), unease, m, and m beside at the end)."""
    share, lookahead, dt, turns = gear
    top, pose = hand[0] * full[0], np.zeros(3)
    v, w, at, moment, unease = twist[0], twist[2], 0, 0.0, 0.0
    before, away = _gained(way, pose, 0)
    gained = before
    for k in range(STEPS):
        aside = bearing(way, pose, at, beside, lookahead * hand[2])
        if gained > (len(way) - 1) * SPACING - _THERE:
            unease += top * (moment - STEPS * GEARS[0, 2])  # the sooner the better
            break
        forward = share * top * max(math.cos(aside), 0.0)
        if turns > 0.0 and abs(aside) > TURNED:
            forward = 0.0
        turn = min(max(hand[1] * aside, -1.0), 1.0) * full[1]
        v += min(max(forward - v, -_FALLS * dt), _RISES * dt)
        w += min(max(turn - w, -_TURNS * dt), _TURNS * dt)
        half = pose[2] + 0.5 * w * dt
        pose[0] += v * dt * math.cos(half)
        pose[1] += v * dt * math.sin(half)
        pose[2] += w * dt
        moment = (k + 1) * dt
        thing, person = _gaps(points, people, box, pose, moment)
        if thing < least[0] or person < least[1]:
            return gained - before, moment, unease / (k + 1), away
        pace = min(abs(v) / top, 1.0) / STEPS
        unease += pace * _UNEASE[0] * (1.0 - thing / EASE[0]) ** 2
        unease += pace * _UNEASE[1] * (1.0 - person / EASE[1]) ** 2
        at = _after(way, pose, at)
        gained, away = _gained(way, pose, at)
    return gained - before, np.inf, unease, away


@njit(cache=True)
def rehearsed(  # noqa: PLR0913, PLR0917  # a kernel takes them one by one
    way: Floats,
    points: Floats,
    people: Floats,
    twist: Floats,
    box: Floats,
    hand: Floats,
    full: Floats,
    beside: Floats,
    driven: float,
) -> tuple[int, float]:
    """(number of the gear, how far beside the way) of the ride in thought that counts most.

    Args:
        way: the wanted one, (m, 4); see ``bearing``.
        points: things, (n, 2), m.
        people: (p, 5) as (x, y, v_x, v_y, radius), m and m/s.
        twist: of the chair, (3,).
        box: about its outline, (x, y low, x, y high), m.
        hand: deflection forward, aside for each radian, and look ahead, m.
        full: what full deflection means, (m/s, rad/s).
        beside: how far to the left of the way the others lie, (b,), m.
        driven: how far the one that is driven now does, m.

    Returns:
        −1 for the gear where there is none to drive. Where the chair is nearer to something than is
        driven otherwise, it may leave.
    """
    thing, person = _gaps(points, people, box, np.zeros(3), 0.0)
    least = (min(_GAP[0], thing - 0.005), min(_GAP[1], person - 0.01))
    best, chosen, most, against = -1, 0.0, -np.inf, np.inf
    for k in range(len(GEARS)):
        needed = _HAND + GEARS[k, 0] * hand[0] * full[0] / _FALLS
        for other in beside:
            gained, met, unease, away = _ride(
                way, points, people, twist, box, hand, full, other, GEARS[k], least
            )
            if met < needed or gained < _LEAST:
                continue
            loss = unease + _AWAY * away + _OTHER * abs(other - driven)
            if met < np.inf:
                loss += _BLOCKED * (1.0 - met / (STEPS * GEARS[k, 2])) + _GOOD
            if gained - loss > most:
                best, chosen, most, against = k, other, gained - loss, loss
        if against <= _GOOD:
            break
    return best, chosen
