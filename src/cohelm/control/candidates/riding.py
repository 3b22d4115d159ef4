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
from cohelm.control.candidates.scene import SPACING, Body, Crowd, Hulls, Road, Scene, Walls
from cohelm.maps.distance import sample
from cohelm.robots.contact import nearest_on_spine

_LOOKAHEAD = 1.0
"""Homing aims at the path so far ahead, m."""
_AIM = 2.0
"""At the end the robot should face the path so far ahead, m."""
_GAIN = 2.5
"""Of homing's turn rate, 1/s."""
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
    heading: float
    bearing: float
    turning: float
    change: float
    hit: float
    standing: float
    fade: Floats
    """(N+1,) share at which what is predicted for each step counts."""
    margin: Floats
    """(N+1,) gap to people below which it is a hit, m."""
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


@njit(cache=True)
def ride(  # noqa: PLR0917  # a kernel takes what it works on one by one
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
    road, body, step, steps = scene.road, scene.body, scene.step, scene.steps
    cost, contact = 0.0, np.inf
    poses[0] = body.start
    due[:] = 0.0
    before = body.now.copy()
    wanted = np.empty_like(before)
    last = float(road.samples.shape[0] - 1)
    along, aside = _project(road, poses[0, 0], poses[0, 1], 0.0)
    free = 0.0
    final = road.wanted[steps]
    for k in range(steps):
        _want(scene, base, push, k, poses[k], along, wanted)
        cost += _limited(scene, wanted, before, k, prices)
        inputs[k] = before
        _advance(body.translating, poses[k], before, step, poses[k + 1])
        pose = poses[k + 1]
        speed = math.hypot(before[0], before[1]) if body.translating > 1 else abs(before[0])
        along, aside = _project(road, pose[0], pose[1], along)
        cos, sin = math.cos(pose[2]), math.sin(pose[2])
        at = int(min(along / SPACING, last))
        facing = cos * road.heading[at, 0] + sin * road.heading[at, 1]
        lag = max(road.wanted[k + 1] - along, 0.0)
        cost += prices.late * lag / (road.pace * steps)
        cost += step * (prices.aside * aside * aside + prices.heading * (1.0 - facing))
        free -= speed * step
        if free <= 0.0:
            free, touch, price = _walls(scene.walls, body.discs, body.around, pose, prices)
            cost += step * price
            if touch:
                contact = min(contact, (k + 1) * step)
                braking = speed / body.fall[0]
                if k <= braking + 1.0:
                    cost += _BLOCKED * (2.0 - k / steps)
                # it would stop short of the wall: from here on the time is lost
                stop = along - 0.5 * speed * step * braking
                for j in range(k + 1, steps):
                    lag = max(road.wanted[j + 1] - stop, 0.0)
                    cost += prices.late * lag / (road.pace * steps)
                lag = math.hypot(max(final - stop, 0.0), aside)
                cost += prices.lag * lag / road.pace + prices.bearing * 0.5
                return Ride(cost, contact, k)
        price, touch = _people(scene.crowd, body.capsule, body, pose, k + 1, step, prices, due)
        if touch:
            contact = min(contact, (k + 1) * step)
        if scene.hulls.support.shape[0]:
            price += (
                prices.fade[k + 1] * prices.hull * _inside(scene.hulls, pose, k + 1, body.capsule)
            )
        cost += step * price * (prices.standing if speed < _STANDING else 1.0)
        left = (steps - k - 1) * step * body.top_speed
        if cost + prices.lag * max(final - along - left, 0.0) / road.pace > limit:
            return Ride(np.inf, contact, steps)
    lag = math.hypot(max(final - along, 0.0), aside)
    cost += prices.lag * lag / road.pace
    cost += prices.bearing * _off_course(scene, poses[steps], along)
    return Ride(cost if cost <= limit else np.inf, contact, steps)


@njit(cache=True, inline="always")
def _want(
    scene: Scene,
    base: Floats,
    push: Floats,
    k: int,
    pose: Floats,
    along: float,
    wanted: Floats,
) -> None:
    """The inputs that the arc asks for at step ``k``."""
    body, share = scene.body, k / scene.steps
    known = base.shape[0]
    if share >= push[8] or (known > 0 and k >= known):
        _home(scene, push[4] if known == 0 else 1.0, pose, along, wanted)
        return
    part = 0 if share < push[6] else (2 if share < push[7] else 4)
    speed, turn = push[part], push[part + 1]
    if known > 0:
        wanted[:] = base[k]
        wanted[0] += speed * body.top_speed
        wanted[1] += turn * body.high[1]
        return
    if body.translating == 1:
        wanted[0] = speed * (scene.road.pace if speed > 0.0 else -body.low[0])
        wanted[1] = turn * body.high[1]
        return
    course = math.atan2(scene.road.samples[0, 3], scene.road.samples[0, 2]) + turn * math.pi
    _towards(scene, pose, along, course, speed * scene.road.pace, wanted)


@njit(cache=True)
def _home(scene: Scene, share: float, pose: Floats, along: float, wanted: Floats) -> None:
    """Back to the path: towards the point of it that lies ``_LOOKAHEAD`` ahead."""
    road, body = scene.road, scene.body
    speed = min(max(share, 0.0), 1.0) * road.pace
    last = road.samples.shape[0] - 1
    at = min(int((along + _LOOKAHEAD) / SPACING), last)
    dx, dy = road.samples[at, 0] - pose[0], road.samples[at, 1] - pose[1]
    # nobody drives past the end of the way
    room = max(road.wanted[scene.steps] - along, 0.0) / scene.step
    speed = min(speed, room)
    if body.translating > 1:
        _towards(scene, pose, along, math.atan2(dy, dx), speed, wanted)
        return
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
    error = math.atan2(left, ahead)
    wanted[0] = speed * max(math.cos(error), 0.0)
    wanted[1] = min(max(_GAIN * error, body.low[1]), body.high[1])


@njit(cache=True)
def _towards(  # noqa: PLR0917  # a kernel takes plain values
    scene: Scene, pose: Floats, along: float, course: float, speed: float, wanted: Floats
) -> None:
    """Velocity over the floor in a map direction, while turning to the path's wanted heading."""
    road = scene.road
    at = int(min(along / SPACING, road.samples.shape[0] - 1.0))
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    hx, hy = road.heading[at, 0], road.heading[at, 1]
    wanted[0] = speed * math.cos(course - pose[2])
    wanted[1] = speed * math.sin(course - pose[2])
    wanted[2] = 0.5 * _GAIN * math.atan2(cos * hy - sin * hx, cos * hx + sin * hy)


@njit(cache=True)
def _limited(scene: Scene, wanted: Floats, before: Floats, k: int, prices: Prices) -> float:
    """Bring ``before`` as near to ``wanted`` as the limits let it; returns what that costs.

    The first step takes half: the wheels are given that time by the next decision.
    """
    body = scene.body
    half = 0.5 if k == 0 else 1.0
    joint = body.translating if body.translating > 1 else 0
    square = 0.0
    for i in range(wanted.shape[0]):
        wanted[i] = min(max(wanted[i], body.low[i]), body.high[i])
        square += wanted[i] * wanted[i] if i < joint else 0.0
    shorter = min(1.0, body.top_speed / math.sqrt(square)) if square > 0.0 else 1.0
    share = 1.0
    for i in range(joint):
        wanted[i] *= shorter
        change = wanted[i] - before[i]
        most = half * (body.rise[i] if change > 0.0 else body.fall[i])
        if abs(change) > most:
            share = min(share, most / abs(change))
    changed = 0.0
    for i in range(wanted.shape[0]):
        if i < joint:
            change = share * (wanted[i] - before[i])
        else:
            change = min(max(wanted[i] - before[i], -half * body.fall[i]), half * body.rise[i])
        before[i] += change
        changed += change * change
    turn = before[wanted.shape[0] - 1]
    return prices.change * changed + scene.step * prices.turning * turn * turn


@njit(cache=True, inline="always")
def _advance(translating: int, pose: Floats, u: Floats, step: float, out: Floats) -> None:
    """One step of the unicycle or of the holonomic robot."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    if translating > 1:
        out[0] = pose[0] + step * (cos * u[0] - sin * u[1])
        out[1] = pose[1] + step * (sin * u[0] + cos * u[1])
        out[2] = pose[2] + step * u[2]
    else:
        out[0] = pose[0] + step * u[0] * cos
        out[1] = pose[1] + step * u[0] * sin
        out[2] = pose[2] + step * u[1]


@njit(cache=True)
def _project(road: Road, x: float, y: float, along: float) -> tuple[float, float]:
    """(arc length on the path, signed distance from it), sought from the last arc length on."""
    last = road.samples.shape[0] - 1
    at = min(int(along / SPACING), last)
    t = 0.0
    for _ in range(last):
        dx, dy = x - road.samples[at, 0], y - road.samples[at, 1]
        t = dx * road.samples[at, 2] + dy * road.samples[at, 3]
        if t > SPACING and at < last:
            at += 1
        elif t < 0.0 and at > 0:
            ex, ey = x - road.samples[at - 1, 0], y - road.samples[at - 1, 1]
            if ex * road.samples[at - 1, 2] + ey * road.samples[at - 1, 3] > SPACING:
                break  # outside a bend: between the two
            at -= 1
        else:
            break
    dx, dy = x - road.samples[at, 0], y - road.samples[at, 1]
    side = road.samples[at, 2] * dy - road.samples[at, 3] * dx
    return max(at * SPACING + min(max(t, 0.0), SPACING), 0.0), side


@njit(cache=True)
def _off_course(scene: Scene, pose: Floats, along: float) -> float:
    """1 − cos of the angle between the heading and the way ahead; 0 at the end of the way.

    Who moves any way needs no heading: only the wanted one counts.
    """
    road = scene.road
    last = road.samples.shape[0] - 1
    at = min(int((along + _AIM) / SPACING), last)
    if scene.body.translating > 1:
        x, y = road.heading[at, 0], road.heading[at, 1]
    else:
        x, y = road.samples[at, 0] - pose[0], road.samples[at, 1] - pose[1]
        norm = max(math.hypot(x, y), 1e-9)
        x, y = x / norm, y / norm
        if (
            road.heading[at, 0] * road.samples[at, 2] + road.heading[at, 1] * road.samples[at, 3]
            < 0
        ):
            x, y = -x, -y
    return 1.0 - (math.cos(pose[2]) * x + math.sin(pose[2]) * y)


@njit(cache=True)
def _walls(
    walls: Walls, discs: Floats, around: float, pose: Floats, prices: Prices
) -> tuple[float, bool, float]:
    """(how far the robot may go before it must look again, whether it touches, price a second)."""
    room = sample(walls.distance, walls.resolution, walls.X_MG, pose[0], pose[1])[0] - around
    room -= prices.clearance
    if room > 0.0:
        return room, False, 0.0
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    nearest = np.inf
    for j in range(discs.shape[0]):
        x = pose[0] + cos * discs[j, 0] - sin * discs[j, 1]
        y = pose[1] + sin * discs[j, 0] + cos * discs[j, 1]
        gap = sample(walls.distance, walls.resolution, walls.X_MG, x, y)[0] - discs[j, 2]
        if gap < walls.margin[j]:
            return 0.0, True, 0.0
        nearest = min(nearest, gap)
    close = max(prices.clearance - nearest, 0.0) / max(prices.clearance, 1e-6)
    return 0.0, False, prices.wall * close * close


@njit(cache=True)
def _people(  # noqa: PLR0917  # a kernel takes what it works on one by one
    crowd: Crowd,
    capsule: Floats,
    body: Body,
    pose: Floats,
    k: int,
    step: float,
    prices: Prices,
    due: Floats,
) -> tuple[float, bool]:
    """(price a second of people at step ``k``, whether one is touched).

    ``due`` tells of each when next to look: nobody comes nearer than his and the robot's speed let
    him.
    """
    price, touched = 0.0, False
    margin = prices.margin[k]
    widest = max(margin, crowd.reach if prices.space > 0.0 else 0.0)
    widest = max(widest, prices.margin[prices.margin.shape[0] - 1])
    for i in range(crowd.states.shape[0]):
        if k < due[i]:
            continue
        x, y = crowd.states[i, k, 0], crowd.states[i, k, 1]
        dx, dy = x - pose[0], y - pose[1]
        apart = math.sqrt(dx * dx + dy * dy) - body.around - crowd.radius[i] - widest
        if apart > 0.0:
            due[i] = k + 1 + int(apart / (step * (crowd.fastest[i] + body.top_speed + 0.01)))
            continue
        d, nx, ny, _, _, _ = nearest_on_spine(capsule, pose, x, y)
        gap = d - capsule[4] - crowd.radius[i]
        likely = crowd.weight[i] * prices.fade[k]
        if gap < 0.0 and crowd.weight[i] > _CREDIBLE:
            touched = True
        if gap < margin:
            price += likely * prices.hit * (margin - gap) ** 2
        if gap < crowd.reach and prices.space > 0.0:
            s = crowd.states[i, k]
            ahead = -(nx * s[2] + ny * s[3])
            squared = ahead * ahead
            q = (s[4] if ahead > 0.0 else s[5]) * squared + s[6] * (1.0 - squared)
            reach = crowd.scale / q if crowd.printed else math.sqrt(crowd.scale / q)
            reach = max(reach, crowd.floor)
            if gap < reach:
                price += likely * prices.space * ((reach - gap) / reach) ** 2
    return price, touched


@njit(cache=True)
def _inside(hulls: Hulls, pose: Floats, k: int, capsule: Floats) -> float:
    """Sum of squared depths of the robot's middle, grown by its half width, in hulls; m²."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    mx, my = 0.5 * (capsule[0] + capsule[2]), 0.5 * (capsule[1] + capsule[3])
    x, y = pose[0] + cos * mx - sin * my, pose[1] + sin * mx + cos * my
    total = 0.0
    for g in range(hulls.support.shape[0]):
        dx, dy = x - hulls.disc[g, k, 0], y - hulls.disc[g, k, 1]
        reach = hulls.disc[g, k, 2] + capsule[4]
        if dx * dx + dy * dy >= reach * reach:
            continue
        depth = np.inf
        for j in range(hulls.normal.shape[0]):
            inner = hulls.support[g, k, j] - x * hulls.normal[j, 0] - y * hulls.normal[j, 1]
            depth = min(depth, inner + capsule[4])
            if depth <= 0.0:
                break
        if depth > 0.0:
            total += depth * depth
    return total
