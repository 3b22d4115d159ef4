"""People as upright bodies: a head, a torso, and two legs that swing as far as was walked.

Lengths are shares of the body's height after Drillis and Contini (1966), rounded: hip at 0.53,
shoulder at 0.82, half the shoulders' breadth 0.13 (0.14 with the arms); a step is 0.41 of the
height, as pedometers take it. Radii of limbs are assumed. A body keeps within its disc: where the
disc is narrower than the body, or shorter than half a step, it counts.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.simulation.sensors.scenery import LEVEL, Floor

STEP_LENGTH = 0.41
"""Share of the body's height."""
FULL_STEPS = 0.8
"""From this speed on steps have their full length, below it they shorten with it, m/s (assumed)."""

PARTS = 4
"""Head, torso, left leg, right leg."""
NUMBERS = 11
"""Of a part; see :func:`parts_of`."""

_HALF_WIDTH = 0.14
_HIP, _CROTCH, _SHOULDER = 0.53, 0.47, 0.83


@value
class Bodies:
    """n people as a sensor meets them, in the map frame."""

    position: Annotated[Floats, Shape("n 2")]
    """Of the discs' centres, m."""
    heading: Annotated[Floats, Shape("n")]
    """Faced, rad."""
    walked: Annotated[Floats, Shape("n")]
    """How far each has walked, m: it says where in their stride the legs are."""
    speed: Annotated[Floats, Shape("n")]
    """m/s; who stands has both legs below the hips."""
    height: Annotated[Floats, Shape("n")]
    """Over the floor, m."""
    radius: Annotated[Floats, Shape("n")]
    """Of the disc that the whole body keeps in, m."""

    @staticmethod
    def standing(position: Floats, heading: float = 0.0, height: float = 1.7) -> Bodies:
        """People of one height who stand at positions (n, 2), m, and face one way, rad."""
        n = len(position)
        return Bodies(
            position=position,
            heading=np.full(n, heading),
            walked=np.zeros(n),
            speed=np.zeros(n),
            height=np.full(n, height),
            radius=np.full(n, 0.25),
        )

    @property
    def swing(self) -> Floats:
        """How far (n,) the left foot is ahead of the hip, the right one behind it, m."""
        half = np.minimum(_breadth(self), self.radius)
        leg = _ANKLE * half
        room = np.sqrt(np.maximum((self.radius - leg) ** 2 - (_APART * half) ** 2, 0.0))
        length = STEP_LENGTH * self.height
        reach = np.minimum(length / 2.0, room) * np.minimum(self.speed / FULL_STEPS, 1.0)
        return np.asarray(reach * np.sin(math.pi * self.walked / length))


_ANKLE, _THIGH, _APART = 0.24, 0.36, 0.36
"""Radii of a leg below and at the hip, and its distance from the middle, as shares of half the
body's breadth."""


def parts_of(bodies: Bodies, floor: Floor = LEVEL) -> Floats:
    """The bodies as sheared elliptic cones, (n, PARTS, NUMBERS).

    The numbers of one: its axis passes (x, y) at height z_0 and moves by (k_x, k_y) a metre up to
    z_1; the first semi-axis of its ellipse lies along (u_x, u_y); 1/a and 1/b are the semi-axes'
    inverses at z_0, and m is by what share of that they grow a metre.
    """
    b = np.minimum(_breadth(bodies), bodies.radius)
    head = np.minimum(0.41 * b, 0.057 * bodies.height)
    u = np.stack([np.cos(bodies.heading), np.sin(bodies.heading)], axis=-1)
    aside = np.stack([-u[:, 1], u[:, 0]], axis=-1)
    z, h = floor.height(bodies.position), bodies.height
    swing = bodies.swing[:, None] * u
    apart = (_APART * b)[:, None] * aside
    at = bodies.position
    none = np.zeros_like(at)
    hip = (_HIP * h)[:, None]
    torso = (z + _CROTCH * h, z + _SHOULDER * h)
    rows = (
        _part(at, none, (z + _SHOULDER * h, z + h), u, (head, 0.8 * head), (1.0, 1.0)),
        _part(at, none, torso, u, (0.5 * b, b), (0.85, 1.0)),
        *(
            _part(
                at + side * (apart + swing),
                -side * swing / hip,
                (z, z + _HIP * h),
                u,
                (_THIGH * b, _THIGH * b),
                (_ANKLE / _THIGH, 1.0),
            )
            for side in (1.0, -1.0)
        ),
    )
    return np.stack(rows, axis=1)


def _part(
    at: Floats,
    shear: Floats,
    z: tuple[Floats, Floats],
    u: Floats,
    semi_axes: tuple[Floats, Floats],
    width: tuple[float, float],
) -> Floats:
    """One part of all n bodies, (n, NUMBERS); width: of both its ends, as shares of the axes."""
    (a, b), (low, high) = semi_axes, width
    growth = (high - low) / low / (z[1] - z[0])
    columns = (*at.T, *shear.T, *z, *u.T, 1.0 / (low * a), 1.0 / (low * b), growth)
    out = np.zeros((len(at), NUMBERS))
    out[:] = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return out


def _breadth(bodies: Bodies) -> Floats:
    return np.asarray(_HALF_WIDTH * bodies.height)
