"""The kernel: one arc ridden through the scene and priced on the way, in seconds.

Prices add up and none is negative, so that an arc is given up as soon as it is dearer than the best
one by more than a spread; what is kept does not depend on the order.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit

from cohelm.arrays import Floats
from cohelm.control.candidates.encounters import (
    body_gap,
    depth_in_hulls,
    space_entered,
    wall_price,
)
from cohelm.control.candidates.scene import SPACING, Scene
from cohelm.robots.contact import BRISK

_LOOKAHEAD = round(1.0 / SPACING)
"""Homing aims at the path so far ahead: 1 m, in samples."""
_AIM = round(2.0 / SPACING)
"""At the end the robot should face the path so far ahead: 2 m, in samples."""
_GAIN = 2.5
"""Of homing's turn rate, 1/s."""
_FULL = 2.0 * math.pi
_STANDING = 0.05
"""A robot slower than this stands, m/s."""
_BLOCKED = 1e4
"""The price of a wall that can no longer be avoided: beyond all others."""
_CREDIBLE = 0.05
"""A future less likely than this is no predicted contact."""


class Prices(NamedTuple):
    """What counts how much; see ``Arcs``."""

    lag: float
    late: float
    aside: float
    bearing: float
    turning: float
    change: float
    hit: float
    standing: float
    fade: Floats
    """(N+1,) share at which what is predicted for each step counts."""
    margin: Floats
    """(N+1,) gap to people below which it is a hit, m."""
    still: float
    """The same of who stands, m."""
    doubt: float
    """What the deviation of a prediction adds to that, without unit."""
    greatest: float
    """Bound of both, m."""
    space: float
    hull: float
    wall: float
    clearance: float
    """Gap to walls below which they cost, m."""


class Ride(NamedTuple):
    """What came of an arc."""

    cost: float
    contact: float
    """When a body or a wall is first touched, s; else +inf."""
    stopped: int
    """The step at which a wall is met; N where none is."""


@njit(cache=True, error_model="numpy")
def ride(  # noqa: PLR0912, PLR0915, PLR0917  # one loop: calls that pass all of it on are dear
    scene: Scene,
    prices: Prices,
    base: Floats,
    push: Floats,
    limit: float,
    inputs: Floats,
    poses: Floats,
    due: Floats,
) -> Ride:
    """Ride one arc; given up with cost +inf where it is dearer than ``limit``.

    Args:
        scene: to ride through.
        prices: of what happens.
        base: (L, m) inputs; after them the arc leads back to the path. L = 0: the arc is what
            ``push`` says.
        push: (9,) row of ``table``; added to ``base`` where there is one.
        limit: dearer arcs are given up, s.
        inputs: (N, m), filled as far as the arc was ridden.
        poses: (N+1, 3), filled likewise.
        due: (P,) scratch.
    """
    step, steps = scene.step, scene.steps
    samples, heading, reference = scene.road.samples, scene.road.heading, scene.road.wanted
    pace = scene.road.pace
    low, high, rise, fall = scene.body.low, scene.body.high, scene.body.rise, scene.body.fall
    translating, top_speed = scene.body.translating, scene.body.top_speed
    capsule, discs, around = scene.body.capsule, scene.body.discs, scene.body.around
    crowd, hulls, walls = scene.crowd, scene.hulls, scene.walls
    states, weight, radius, fastest = crowd.states, crowd.weight, crowd.radius, crowd.fastest
    margins, fade = prices.margin, prices.fade
    reach = crowd.reach if prices.space > 0.0 else 0.0
    widest = max(prices.greatest, reach)
    m, known, last = inputs.shape[1], base.shape[0], samples.shape[0] - 1
    fastest_own = min(top_speed, pace)
    joint = translating if translating > 1 else 0
    cost, contact, free, final = 0.0, np.inf, 0.0, reference[steps]
    lag_price, late = prices.lag / pace, prices.late / (pace * steps)
    poses[0] = scene.body.start
    due[:] = 0.0
    x, y, angle = poses[0, 0], poses[0, 1], poses[0, 2]
    middle, soonest = angle, 0.0
    cos, sin = math.cos(angle), math.sin(angle)  # of the middle of the last step
    at, along, aside = _project(samples, x, y, 0)
    course = math.atan2(samples[0, 3], samples[0, 2])
    for k in range(steps):
        # what the arc asks for
        share = k / steps
        wanted = inputs[k]
        if share >= push[8] or (known > 0 and k >= known):
            ahead = min(at + _LOOKAHEAD, last)
            dx, dy = samples[ahead, 0] - x, samples[ahead, 1] - y
            speed = min(max(push[4], 0.0), 1.0) if known == 0 else 1.0
            speed = min(speed * pace, max(final - along, 0.0) / step)
            if joint:
                towards = math.atan2(dy, dx) - angle
                wanted[0], wanted[1] = speed * math.cos(towards), speed * math.sin(towards)
            else:
                error = math.atan2(dy, dx) - angle
                error -= _FULL * round(error / _FULL)
                wanted[0] = speed * max(math.cos(error), 0.0)
                wanted[1] = _GAIN * error
            turns = joint > 0
        else:
            part = 0 if share < push[6] else (2 if share < push[7] else 4)
            speed, turn = push[part], push[part + 1]
            turns = joint > 0 and known == 0
            if known > 0:
                wanted[:] = base[k]
                wanted[0] += speed * pace
                wanted[1] += turn * high[1]
            elif joint:
                wanted[0] = speed * pace * math.cos(course + turn * math.pi - angle)
                wanted[1] = speed * pace * math.sin(course + turn * math.pi - angle)
            else:
                wanted[0] = speed * (pace if speed > 0.0 else -low[0])
                wanted[1] = turn * high[1]
        if turns:  # who moves any way turns to the wanted heading meanwhile
            error = math.atan2(heading[at, 1], heading[at, 0]) - angle
            wanted[2] = 0.5 * _GAIN * (error - _FULL * round(error / _FULL))
        # as far as the limits allow it; the first step takes half, as decisions come before its end
        half = 0.5 if k == 0 else 1.0
        square = 0.0
        for i in range(m):
            most = min(high[i], pace) if i == 0 else high[i]
            wanted[i] = min(max(wanted[i], low[i]), most)
            square += wanted[i] * wanted[i] if i < joint else 0.0
        shorter = min(1.0, fastest_own / math.sqrt(square)) if square > 0.0 else 1.0
        part_of = 1.0
        for i in range(joint):
            wanted[i] *= shorter
            change = wanted[i] - (inputs[k - 1, i] if k > 0 else scene.body.now[i])
            most = half * (rise[i] if change > 0.0 else fall[i])
            if abs(change) > most:
                part_of = min(part_of, most / abs(change))
        for i in range(m):
            before = inputs[k - 1, i] if k > 0 else scene.body.now[i]
            change = wanted[i] - before
            if i < joint:
                change *= part_of
            else:
                change = min(max(change, -half * fall[i]), half * rise[i])
            wanted[i] = before + change
            cost += prices.change / step * change * change
        # one step of the unicycle, or of who moves any way
        speed, turn = abs(wanted[0]), wanted[m - 1]
        if angle + scene.blur * turn != middle:
            middle = angle + scene.blur * turn
            cos, sin = math.cos(middle), math.sin(middle)
        x += step * wanted[0] * cos
        y += step * wanted[0] * sin
        if joint:
            x -= step * sin * wanted[1]
            y += step * cos * wanted[1]
            speed = math.hypot(wanted[0], wanted[1])
        angle += step * turn
        poses[k + 1, 0], poses[k + 1, 1], poses[k + 1, 2] = x, y, angle
        # how it gets on
        at, along, aside = _project(samples, x, y, at)
        lag = max(reference[k + 1] - along, 0.0)
        cost += late * lag
        cost += step * (prices.turning * turn * turn + prices.aside * aside * aside)
        # walls
        free -= speed * step
        if free <= 0.0:
            free, touch, price = wall_price(walls, discs, around, x, y, angle, prices.clearance)
            cost += step * prices.wall * price
            if touch:
                contact = min(contact, (k + 1) * step)
                braking = speed / fall[0]
                if k <= braking + 1.0:
                    cost += _BLOCKED * (2.0 - k / steps)
                # it would stop short of the wall: from here on the time is lost
                stop = along - 0.5 * speed * step * braking
                for j in range(k + 1, steps):
                    cost += late * max(reference[j + 1] - stop, 0.0)
                    poses[j + 1] = poses[k + 1]
                lag = math.hypot(max(final - stop, 0.0), aside)
                return Ride(cost + lag_price * lag + 0.5 * prices.bearing, contact, k)
        # people
        price = 0.0
        if k + 1 >= soonest:
            soonest = np.inf
        for i in range(states.shape[0] if soonest == np.inf else 0):
            if k + 1 < due[i]:
                soonest = min(soonest, due[i])
                continue
            dx, dy = states[i, k + 1, 0] - x, states[i, k + 1, 1] - y
            apart = math.sqrt(dx * dx + dy * dy) - around - radius[i] - widest
            if apart > 0.0:  # nobody comes nearer than his and the robot's speed let him
                due[i] = k + 2 + int(apart / (step * (fastest[i] + top_speed + 0.01)))
                soonest = min(soonest, due[i])
                continue
            soonest = 0.0
            gap, nx, ny = body_gap(capsule, angle, dx, dy)
            gap -= radius[i]
            likely = weight[i] * fade[k + 1]
            if gap < 0.0 and weight[i] > _CREDIBLE:
                contact = min(contact, (k + 1) * step)
            # of who stands only the deviation grows
            margin = (margins[k + 1] - prices.still) * min(fastest[i] / BRISK, 1.0)
            margin += prices.still + prices.doubt * states[i, k + 1, 7]
            margin = min(margin, prices.greatest)
            if gap < margin:
                price += likely * prices.hit * (margin - gap) * (margin - gap)
            if gap < reach:
                price += likely * prices.space * space_entered(crowd, states[i, k + 1], gap, nx, ny)
        if hulls.support.shape[0]:
            price += fade[k + 1] * prices.hull * depth_in_hulls(hulls, capsule, x, y, angle, k + 1)
        cost += step * price * (prices.standing if speed < _STANDING else 1.0)
        # nobody is faster than the reference's pace, so that what is lost is never made good
        lost = max(final - along - (steps - k - 1) * step * pace, 0.0)
        if cost + (lag_price + late * (steps - k - 1)) * lost > limit:
            return Ride(np.inf, contact, steps)
    cost += lag_price * math.hypot(max(final - along, 0.0), aside)
    cost += prices.bearing * _off_course(samples, heading, joint, x, y, angle, at)
    return Ride(cost if cost <= limit else np.inf, contact, steps)


@njit(cache=True, error_model="numpy")
def _project(samples: Floats, x: float, y: float, at: int) -> tuple[int, float, float]:
    """(sample, arc length, signed distance) of the nearest point of the path near a sample."""
    last, t, back = samples.shape[0] - 1, 0.0, False
    while True:
        t = (x - samples[at, 0]) * samples[at, 2] + (y - samples[at, 1]) * samples[at, 3]
        if t > SPACING and at < last and not back:
            at += 1
        elif t < 0.0 and at > 0:
            at -= 1
            back = True  # never forth again: outside a bend it would not end
        else:
            break
    aside = samples[at, 2] * (y - samples[at, 1]) - samples[at, 3] * (x - samples[at, 0])
    return at, at * SPACING + min(max(t, 0.0), SPACING), aside


@njit(cache=True, error_model="numpy")
def _off_course(  # noqa: PLR0917  # a kernel takes plain values
    samples: Floats,
    heading: Floats,
    joint: int,
    x: float,
    y: float,
    angle: float,
    at: int,
) -> float:
    """1 − cos of the angle between the heading and the way ahead.

    Who moves any way needs no heading: only the wanted one counts.
    """
    cos, sin = math.cos(angle), math.sin(angle)
    ahead = min(at + _AIM, samples.shape[0] - 1)
    if joint:
        return float(1.0 - (cos * heading[ahead, 0] + sin * heading[ahead, 1]))
    dx, dy = samples[ahead, 0] - x, samples[ahead, 1] - y
    norm = max(math.hypot(dx, dy), 1e-9)
    if heading[at, 0] * samples[at, 2] + heading[at, 1] * samples[at, 3] < 0.0:
        norm = -norm  # the way is to be driven backwards
    return float(1.0 - (cos * dx + sin * dy) / norm)
