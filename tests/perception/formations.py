"""People who stand or walk together, and people who only look like it; made at random."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cohelm.arrays import Floats, Integers
from cohelm.messages import People
from cohelm.perception import Affinity, GroupDetector

TICK = 0.1
Scene = tuple[Floats, Floats]
"""Where n people stand (n, 2), m, and where they look (n,), rad."""


def people(
    time: float, position: npt.ArrayLike, heading: npt.ArrayLike, velocity: npt.ArrayLike = 0.0
) -> People:
    """As a tracker tells them that is sure of them to within 5 cm and 0.1 m/s."""
    place = np.reshape(np.asarray(position, dtype=float), (-1, 2))
    n = len(place)
    speed = np.broadcast_to(np.asarray(velocity, dtype=float), place.shape)
    return People(
        time=time,
        id=np.arange(n),
        mean=np.concatenate([place, speed], axis=1),
        covariance=np.tile(np.diag([0.05, 0.05, 0.1, 0.1]) ** 2, (n, 1, 1)),
        heading=np.broadcast_to(np.asarray(heading, dtype=float), n),
        radius=np.full(n, 0.25),
        confidence=np.ones(n),
    )


def watch(
    position: npt.ArrayLike,
    heading: npt.ArrayLike,
    velocity: npt.ArrayLike = 0.0,
    *,
    rng: np.random.Generator,
    duration: float = 4.0,
    detector: GroupDetector | None = None,
) -> Integers:
    """``Groups.member`` at every tick (k, n), seen with 3 cm and 0.05 m/s of noise."""
    detector = detector or Affinity()
    memory = None
    start = np.asarray(position, dtype=float)
    speed = np.broadcast_to(np.asarray(velocity, dtype=float), start.shape)
    out = []
    for k in range(round(duration / TICK)):
        here = start + speed * k * TICK + 0.03 * rng.standard_normal(start.shape)
        seen = people(k * TICK, here, heading, speed + 0.05 * rng.standard_normal(start.shape))
        groups, memory = detector.group(seen, memory)
        out.append(groups.member)
    return np.array(out)


def circle(n: int) -> Callable[[np.random.Generator], Scene]:
    """``n`` people about a middle that they look at, 0.8 to 1.1 m from each other."""

    def make(rng: np.random.Generator) -> Scene:
        radius = max(0.5, rng.uniform(0.8, 1.05) / (2.0 * np.sin(np.pi / n)))
        angle = 2.0 * np.pi * (np.arange(n) / n + rng.uniform())
        place = radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        place += rng.normal(0.0, 0.07, (n, 2))
        return place, np.arctan2(-place[:, 1], -place[:, 0]) + rng.normal(0.0, 0.3, n)

    return make


def face_to_face(rng: np.random.Generator) -> Scene:
    """Vis-à-vis, 0.8 to 1.5 m."""
    place = np.array([[0.0, 0.0], [rng.uniform(0.8, 1.5), 0.0]])
    return place, np.array([0.0, np.pi]) + rng.normal(0.0, 0.3, 2)


def corner(rng: np.random.Generator) -> Scene:
    """The L-shape: both look at a point before them at right angles."""
    away = rng.uniform(0.5, 0.8)
    place = np.array([[0.0, 0.0], [away, away]])
    return place, np.array([0.0, -np.pi / 2]) + rng.normal(0.0, 0.3, 2)


def abreast(rng: np.random.Generator) -> Scene:
    """Side by side, looking the same way."""
    return np.array([[0.0, 0.0], [0.0, rng.uniform(0.55, 0.85)]]), rng.normal(0.0, 0.2, 2)


def queue(rng: np.random.Generator) -> Scene:
    """Four in file, each looking at the next one's back."""
    along = rng.uniform(0.7, 1.1, 4).cumsum()
    return np.stack([along, rng.normal(0.0, 0.05, 4)], axis=-1), rng.normal(0.0, 0.2, 4)


def back_to_back(rng: np.random.Generator) -> Scene:
    """Two who look away from each other."""
    place = np.array([[0.0, 0.0], [rng.uniform(0.6, 1.2), 0.0]])
    return place, np.array([np.pi, 0.0]) + rng.normal(0.0, 0.3, 2)


def strangers(rng: np.random.Generator) -> Scene:
    """Three in a row, 1.8 to 3 m from each other, who look anywhere."""
    along = np.concatenate([[0.0], rng.uniform(1.8, 3.0, 2).cumsum()])
    return np.stack([along, np.zeros(3)], axis=-1), rng.uniform(-np.pi, np.pi, 3)
