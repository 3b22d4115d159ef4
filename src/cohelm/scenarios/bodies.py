"""Outlines of a scenario's pedestrians, also with a wheelchair, a walker or a trolley."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.scenarios.pedestrian_spec import CrowdSpec
from cohelm.simulation import Crowd
from cohelm.simulation.sensors.planar_bodies import RADIUS, SPEEDS, STATURES, BodyKind


def draw_kinds(spec: CrowdSpec, count: int, rng: np.random.Generator) -> Integers | None:
    """Outlines (count,), a ``BodyKind`` each: those given, the others drawn; None: all discs."""
    names = {kind.name.lower(): kind for kind in BodyKind}
    given = [each.body for each in spec.pedestrians][:count]
    if not spec.bodies and not any(given):
        return None
    share_of: dict[str, float] = dict(spec.bodies.items())
    shares = [share_of.get(name, 0.0) for name in names]
    shares[BodyKind.DISC] += max(1.0 - sum(shares), 0.0)
    kinds = rng.choice(len(names), size=count, p=np.array(shares) / sum(shares))
    for i, body in enumerate(given):
        if body is not None:
            kinds[i] = names[body]
    return np.asarray(kinds, dtype=np.int64)


def with_bodies(crowd: Crowd, kinds: Integers | None) -> Crowd:
    """Crowd with the sizes and highest speeds of its outlines (n,); seated people stay."""
    if kinds is None:
        return crowd
    radius, speed = crowd.radius.copy(), crowd.preferred_speed.copy()
    waypoints, target = crowd.waypoints.copy(), crowd.target.copy()
    for i, kind in enumerate(map(BodyKind, kinds.tolist())):
        if kind is BodyKind.DISC:
            continue
        radius[i] = RADIUS[kind]
        speed[i] = min(speed[i], SPEEDS.get(kind, speed[i])) or speed[i]
        if kind is BodyKind.SEATED:
            waypoints[i, 1:], target[i] = np.nan, 0
            waypoints[i, 0] = crowd.position[i]
    return replace(crowd, radius=radius, preferred_speed=speed, waypoints=waypoints, target=target)


def statures_of(kinds: Integers | None, statures: Floats) -> Floats:
    """Heights (n,), m: those of lower outlines are scaled from the drawn ones into their range."""
    if kinds is None:
        return statures
    out = statures.copy()
    low, high = statures.min(initial=np.inf), statures.max(initial=-np.inf)
    for i, kind in enumerate(map(BodyKind, kinds.tolist())):
        if kind in STATURES:
            share = (statures[i] - low) / max(high - low, 1e-9)
            out[i] = STATURES[kind][0] + share * (STATURES[kind][1] - STATURES[kind][0])
    return out
