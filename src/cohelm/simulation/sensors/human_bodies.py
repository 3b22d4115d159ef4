"""Human bodies for 3-D sensors: a head, a torso, and two legs that swing with the distance walked.

Lengths are shares of the body's height after Drillis and Contini (1966), rounded: hip at 0.53,
shoulder at 0.82, half the shoulders' breadth 0.13 (0.14 with the arms); a step is 0.41 of the
height, as in pedometers. Radii of limbs are assumed. A body stays within its disc, which therefore
limits breadth and step.
"""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value

STEP_LENGTH = 0.41
"""Share of the body's height."""
FULL_STEPS = 0.8
"""Speed above which steps have their full length, in proportion below, m/s (assumed)."""

PARTS = 4
"""Head, torso, left leg, right leg."""
NUMBERS = 11
"""Numbers of a part; see :func:`parts_of`."""

_HALF_WIDTH = 0.14
_HIP, _CROTCH, _SHOULDER = 0.53, 0.47, 0.83


@value
class HumanBodies:
    """n people in the map frame."""

    position: Annotated[Floats, Shape("n 2")]
    """Centres of the discs, m."""
    heading: Annotated[Floats, Shape("n")]
    """Direction faced, rad."""
    walked: Annotated[Floats, Shape("n")]
    """Distance walked, m, which determines the phase of the stride."""
    speed: Annotated[Floats, Shape("n")]
    """m/s; of standing people both legs are below the hips."""
    height: Annotated[Floats, Shape("n")]
    """Over the floor, m."""
    radius: Annotated[Floats, Shape("n")]
    """Radius of the disc that contains the body, m."""
    kind: Annotated[Integers, Shape("n")] | None = None
    """Outline in planar scans, a :class:`~.planar_bodies.BodyKind` each; None: discs."""

    @staticmethod
    def standing(position: Floats, heading: float = 0.0, height: float = 1.7) -> HumanBodies:
        """Return standing people of one height and heading (rad) at positions (n, 2), m."""
        n = len(position)
        return HumanBodies(
            position=position,
            heading=np.full(n, heading),
            walked=np.zeros(n),
            speed=np.zeros(n),
            height=np.full(n, height),
            radius=np.full(n, 0.25),
        )

    @property
    def swing(self) -> Floats:
        """Distance (n,) of the left foot ahead of the hip, and of the right one behind it, m."""
        half = np.minimum(_breadth(self), self.radius)
        leg = _ANKLE * half
        limit = np.sqrt(np.maximum((self.radius - leg) ** 2 - (_APART * half) ** 2, 0.0))
        length = STEP_LENGTH * self.height
        reach = np.minimum(length / 2.0, limit) * np.minimum(self.speed / FULL_STEPS, 1.0)
        return np.asarray(reach * np.sin(math.pi * self.walked / length))


_ANKLE, _THIGH, _APART = 0.24, 0.36, 0.36
"""Radii of a leg at ankle and hip, and its distance from the middle, as shares of half the body's
breadth."""


def parts_of(bodies: HumanBodies, standing: Floats) -> Floats:
    """Bodies as sheared elliptic cones, (n, PARTS, NUMBERS); standing: (n,) heights of feet, m.

    Numbers of a part: (x, y) of its axis at height z_0; (k_x, k_y), shear of the axis per metre;
    z_0 and z_1; (u_x, u_y), direction of the first semi-axis; 1/a and 1/b, inverses of the
    semi-axes at z_0; m, their relative growth per metre.
    """
    b = np.minimum(_breadth(bodies), bodies.radius)
    head = np.minimum(0.41 * b, 0.057 * bodies.height)
    u = np.stack([np.cos(bodies.heading), np.sin(bodies.heading)], axis=-1)
    aside = np.stack([-u[:, 1], u[:, 0]], axis=-1)
    z, h = standing, bodies.height
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
    """One part of all n bodies, (n, NUMBERS); width: relative size of its lower and upper end."""
    (a, b), (low, high) = semi_axes, width
    growth = (high - low) / low / (z[1] - z[0])
    columns = (*at.T, *shear.T, *z, *u.T, 1.0 / (low * a), 1.0 / (low * b), growth)
    out = np.zeros((len(at), NUMBERS))
    out[:] = np.stack(np.broadcast_arrays(*columns), axis=-1)
    return out


def _breadth(bodies: HumanBodies) -> Floats:
    return np.asarray(_HALF_WIDTH * bodies.height)
