"""People of the twin: bodies of capsules whose legs step, moved by the crowd model.

A body follows its place in the crowd exactly while nothing touches it. In a contact it is a mass
that is pushed, and walks on with a limited force; the crowd goes on from where it is then.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Booleans, Floats, Integers, Shape, value
from cohelm.platforms.twin.body_regions import REGIONS
from cohelm.platforms.twin.building import PEOPLE
from cohelm.simulation import FloorRelief
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.planar_bodies import BodyKind, outline_of

TOUCHED = 4
"""Bit of contact between chair and people, who do not touch each other or walls."""
PUSH = 200.0
"""Maximum force with which a walking person goes on against a chair, N (assumed: a push with the
body, a quarter of the weight)."""
_GRIP = 4.0
"""Rate at which a pushed person regains the intended velocity, 1/s (assumed)."""
_BODY_MASS = 25.0
"""Mass by the square of the height, kg/m²."""
_ANCHOR = 500.0
"""Inertia that keeps joints, which the crowd moves, as they are in a contact, kg or kg m²."""
_IMPEDANCE = 0.05
"""Impedance of contacts with people; see :func:`soften`."""
_DAMPING = 0.2
"""Share of critical damping in the compliance of a body (assumed)."""
_HIP, _KNEE, _SHOULDER = 0.53, 0.28, 0.83
_AID_TOP = 0.5
_COLOURS = ((0.25, 0.45, 0.70, 1.0), (0.70, 0.40, 0.25, 1.0), (0.35, 0.55, 0.35, 1.0))
_SKIN = (0.85, 0.70, 0.58, 1.0)
_TROUSERS = (0.22, 0.22, 0.28, 1.0)
JOINTS = ("x", "y", "z", "yaw", "left", "right")
"""Joints of a person, in the order of their coordinates."""


def add_people(spec: Any, mujoco: Any, bodies: HumanBodies) -> None:
    """Add n people to a model, with their joints at 0.

    Args:
        spec: ``mujoco.MjSpec`` to extend.
        mujoco: the module.
        bodies: heights, radii and outlines.
    """
    kinds = np.zeros(len(bodies.height)) if bodies.kind is None else bodies.kind
    for i, height in enumerate(bodies.height):
        kind = BodyKind(int(kinds[i]))
        breadth = min(0.14 * float(height), float(bodies.radius[i]))
        _add_person(spec, mujoco, i, float(height), breadth, kind)


def follow(data: Any, first: tuple[int, int], bodies: HumanBodies, relief: FloorRelief) -> None:
    """Put people, whose joints begin at ``first`` in positions and velocities, in their places."""
    n = len(bodies.height)
    at = data.qpos[first[0] : first[0] + 6 * n].reshape(n, 6)
    at[:] = places_of(bodies, relief)


def places_of(bodies: HumanBodies, relief: FloorRelief) -> Floats:
    """Coordinates (n, 6) of people's joints: x, y, z, yaw and both hips."""
    present = np.abs(bodies.position).max(axis=1, initial=0.0) < 1e5
    z = np.where(present, relief.heights(np.where(present[:, None], bodies.position, 0.0)), 0.0)
    walks = np.ones(len(z), dtype=bool)
    if bodies.kind is not None:
        walks = ~np.isin(bodies.kind, [BodyKind.SEATED, BodyKind.WHEELCHAIR])
    stride = np.where(walks, np.arctan2(bodies.swing, _HIP * bodies.height), 0.0)
    return np.column_stack([bodies.position, z, bodies.heading, -stride, stride])


@value
class PersonGeoms:
    """Geometries of people in a model with g geometries and n people."""

    owner: Annotated[Integers, Shape("g")]
    """Index of the person; −1: none."""
    geoms: Annotated[Integers, Shape("p")]
    """Those of people."""

    def hidden(self, visible: Booleans) -> Integers:
        """Geometries of people who are not visible; (n,) mask."""
        return self.geoms[~visible[self.owner[self.geoms]]]


def person_table(model: Any, people: int) -> PersonGeoms:
    """Find the geometries of each person by their names."""
    owner = np.full(model.ngeom, -1, dtype=np.int64)
    bodies = {f"person_{i}_{part}" for i in range(people) for part in ("trunk", "left", "right")}
    for name in bodies:
        body = model.body(name)
        first, count = int(body.geomadr[0]), int(body.geomnum[0])
        owner[first : first + count] = int(name.split("_")[1])
    return PersonGeoms(owner=owner, geoms=np.flatnonzero(owner >= 0))


def soften(model: Any, table: PersonGeoms, chair: int) -> None:
    """Give people's geometries the stiffness of their body regions.

    A contact's force is (stiffness · depth + damping · speed) · d / (A d + Â (1 − d)) / d, where A
    is the inverse of the reduced mass, Â MuJoCo's estimate of it, and d the impedance (MuJoCo,
    "Solver parameters", direct form). With a small d the force no longer depends on A, so that two
    legs are two springs side by side; stiffness and damping are then those of the region times Â.
    A capsule touches the chair's boxes at two points, each of which therefore has half of them.

    Args:
        model: compiled, changed in place.
        table: geometries of people.
        chair: index of the chair's body.
    """
    chair_mass = float(model.body_subtreemass[chair])
    for geom in table.geoms:
        region = REGIONS[model.geom(int(geom)).name.split("_")[2]]
        person = float(model.body_subtreemass[model.body(f"person_{table.owner[geom]}_trunk").id])
        reduced = person * chair_mass / (person + chair_mass)
        damping = 2.0 * _DAMPING * np.sqrt(region.stiffness * reduced)
        inverse = (
            model.body_invweight0[model.geom_bodyid[geom], 0] + model.body_invweight0[chair, 0]
        )
        half = inverse / 2.0
        model.geom_solref[geom] = (-region.stiffness * half, -damping * half)
        model.geom_solimp[geom] = (_IMPEDANCE, _IMPEDANCE, 0.001, 0.5, 2.0)
        model.geom_priority[geom] = 2


def walk_on(at: Floats, moving: Floats, target: Floats, velocity: Floats, mass: Floats) -> Floats:
    """Force (k, 2) with which touched people go on towards their places, at most :data:`PUSH`.

    Args:
        at, moving: (k, 2) true position and velocity.
        target, velocity: (k, 2) of the crowd.
        mass: (k,) kg.
    """
    wanted = _GRIP * (target - at) + (velocity - moving)
    force = _GRIP * mass[:, None] * wanted
    size = np.hypot(force[:, 0], force[:, 1])
    return np.asarray(force * np.minimum(PUSH / np.maximum(size, 1e-9), 1.0)[:, None])


def _add_person(
    spec: Any, mujoco: Any, i: int, height: float, breadth: float, kind: BodyKind
) -> None:
    """Trunk with two legs; the trunk carries the mass of what it pushes too."""
    j = mujoco.mjtJoint
    mass = _BODY_MASS * height**2
    trunk = spec.worldbody.add_body(name=f"person_{i}_trunk", gravcomp=1.0)
    for name, axis in (("x", [1, 0, 0]), ("y", [0, 1, 0])):
        trunk.add_joint(name=f"person_{i}_{name}", type=j.mjJNT_SLIDE, axis=axis)
    trunk.add_joint(name=f"person_{i}_z", type=j.mjJNT_SLIDE, axis=[0, 0, 1], armature=_ANCHOR)
    trunk.add_joint(name=f"person_{i}_yaw", axis=[0, 0, 1], armature=_ANCHOR)
    seated = kind in {BodyKind.SEATED, BodyKind.WHEELCHAIR}
    colour = _COLOURS[i % len(_COLOURS)]
    hip = 0.47 if seated else _HIP * height
    shoulder = _SHOULDER * height
    parts = _Parts(mujoco, i)
    parts.ellipsoid(
        trunk, "torso", (0.5 * breadth, breadth), (hip - 0.03, shoulder), colour, mass=0.5 * mass
    )
    half = max(breadth - 0.10, 0.03)
    parts.capsule(
        trunk, "pelvis", (0.0, -half, hip), (0.0, half, hip), 0.10, colour, mass=0.2 * mass
    )
    head = min(0.41 * breadth, 0.057 * height)
    parts.ellipsoid(trunk, "head", (head, 0.8 * head), (shoulder, height), _SKIN, mass=0.06 * mass)
    # Without mass: it joins two ellipsoids that touch in a point, for eyes and LiDARs.
    neck = ((0.0, 0.0, shoulder - 0.03), (0.0, 0.0, shoulder + 0.05))
    parts.capsule(trunk, "head", *neck, 0.6 * head, _SKIN, mass=0.0)
    _add_legs(parts, trunk, height, breadth, hip, seated=seated, mass=mass)
    # Legs come first in an outline, what is pushed or sat on after them.
    for x, y, radius in outline_of(kind, 0.0, breadth)[2:]:
        parts.capsule(trunk, "aid", (x, y, radius), (x, y, _AID_TOP), radius, _TROUSERS, mass=0.1)


def _add_legs(
    parts: _Parts,
    trunk: Any,
    height: float,
    breadth: float,
    hip: float,
    *,
    seated: bool,
    mass: float,
) -> None:
    """Two legs that swing about the hips; those of a seated person are bent."""
    for side, sign in (("left", 1.0), ("right", -1.0)):
        y = sign * max(0.36 * breadth, 0.07)
        leg = trunk.add_body(name=f"person_{parts.person}_{side}", pos=[0.0, y, hip], gravcomp=1.0)
        leg.add_joint(name=f"person_{parts.person}_{side}", axis=[0, 1, 0], armature=_ANCHOR)
        thick, thin = 0.36 * breadth, 0.26 * breadth
        knee = -(_HIP - _KNEE) * height
        if seated:
            parts.capsule(leg, "thigh", (0, 0, 0), (0.3, 0, 0), thick, _TROUSERS, mass=0.08 * mass)
            parts.capsule(
                leg, "shank", (0.3, 0, 0), (0.3, 0, -0.4), thin, _TROUSERS, mass=0.04 * mass
            )
        else:
            parts.capsule(leg, "thigh", (0, 0, 0), (0, 0, knee), thick, _TROUSERS, mass=0.08 * mass)
            parts.capsule(
                leg, "shank", (0, 0, knee), (0, 0, thin - hip), thin, _TROUSERS, mass=0.04 * mass
            )


class _Parts:
    """Geometries of one person."""

    def __init__(self, mujoco: Any, person: int) -> None:
        self._mujoco, self.person, self._count = mujoco, person, 0

    def capsule(
        self,
        body: Any,
        part: str,
        start: tuple[float, float, float],
        end: tuple[float, float, float],
        radius: float,
        colour: tuple[float, ...],
        *,
        mass: float,
    ) -> None:
        """Capsule between two points of the body's frame."""
        body.add_geom(
            type=self._mujoco.mjtGeom.mjGEOM_CAPSULE,
            fromto=[*start, *end],
            size=[radius, 0.0, 0.0],
            **self._options(part, colour, mass),
        )

    def ellipsoid(
        self,
        body: Any,
        part: str,
        semi_axes: tuple[float, float],
        z: tuple[float, float],
        colour: tuple[float, ...],
        *,
        mass: float,
    ) -> None:
        """Upright ellipsoid from a height to another."""
        body.add_geom(
            type=self._mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            pos=[0.0, 0.0, (z[0] + z[1]) / 2.0],
            size=[*semi_axes, (z[1] - z[0]) / 2.0],
            **self._options(part, colour, mass),
        )

    def _options(self, part: str, colour: tuple[float, ...], mass: float) -> dict[str, Any]:
        self._count += 1
        return {
            "name": f"person_{self.person}_{part}_{self._count}",
            "mass": mass,
            "rgba": colour,
            "group": PEOPLE,
            "contype": 0,
            "conaffinity": TOUCHED,
            "friction": [0.4, 0.0, 0.0],
        }
