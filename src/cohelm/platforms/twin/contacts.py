"""Contacts of the twin's chair with people and walls: forces, energies and durations."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cohelm.arrays import Annotated, Floats, Integers, Shape, value
from cohelm.platforms.twin.body_regions import REGIONS
from cohelm.platforms.twin.people import PersonGeoms
from cohelm.simulation import Touch

WALL = -1
"""Stands for walls and objects among indices of people."""
FREE_STEPS = 20
"""Motion steps without force after which a contact is over; a later one is another."""


@value
class ContactTable:
    """Geometries of a model with g geometries that count as contacts of the chair."""

    chair: Annotated[Integers, Shape("g")]
    """1 for the chair's parts."""
    other: Annotated[Integers, Shape("g")]
    """Index of the person, −1 for walls and objects, −2 for floor and chair."""
    names: tuple[str, ...]
    """Name of each geometry."""


def contact_table(model: Any, people: PersonGeoms) -> ContactTable:
    """Sort the geometries of a model."""
    names = tuple(model.geom(i).name for i in range(model.ngeom))
    chair = model.body_rootid[model.geom_bodyid] == model.body("chair").id
    floor = np.array([name.startswith("floor") for name in names])
    other = np.where(people.owner >= 0, people.owner, np.where(chair | floor, -2, WALL))
    return ContactTable(chair=chair.astype(np.int64), other=other, names=names)


@value
class ContactForce:
    """Force between the chair and one geometry at one instant."""

    person: int
    """−1: a wall."""
    part: str
    chair_part: str
    force: float
    """Along the normal, N."""
    normal: Annotated[Floats, Shape("3")]
    """From the chair to the other body."""


def contact_forces(mujoco: Any, model: Any, data: Any, table: ContactTable) -> list[ContactForce]:
    """Forces of the chair's contacts with people and walls now; empty without any.

    Points of contact between the same two parts are one contact, whose forces add up.
    """
    if data.ncon == 0:
        return []
    pairs = data.contact.geom
    is_chair, other = table.chair[pairs], table.other[pairs]
    rows = np.flatnonzero((is_chair.sum(axis=1) == 1) & (other.max(axis=1) >= WALL))
    found: dict[tuple[int, int], ContactForce] = {}
    wrench = np.zeros(6)
    for row in rows:
        mujoco.mj_contactForce(model, data, int(row), wrench)
        if wrench[0] <= 0.0:
            continue
        side = int(is_chair[row].argmax())
        mine, theirs = int(pairs[row, side]), int(pairs[row, 1 - side])
        sign = 1.0 if side == 0 else -1.0
        person, before = int(table.other[theirs]), found.get((mine, theirs))
        found[mine, theirs] = ContactForce(
            person=person,
            part=table.names[theirs].split("_")[2] if person >= 0 else "wall",
            chair_part=table.names[mine],
            force=float(wrench[0]) + (0.0 if before is None else before.force),
            normal=sign * data.contact.frame[row, :3],
        )
    return list(found.values())


@dataclass(slots=True)
class _Open:
    """Contact that has not ended."""

    touch: Touch
    idle: int = 0


@dataclass(slots=True)
class ContactLog:
    """Contacts so far, one for each pair of a person's part and a part of the chair."""

    _open: dict[tuple[int, str, str], _Open] = field(default_factory=dict)

    def add(
        self,
        forces: list[ContactForce],
        time: float,
        closing: dict[int, Floats],
        speed: float,
    ) -> None:
        """Add the forces of one motion step.

        Args:
            forces: of :func:`contact_forces`.
            time: s.
            closing: velocity (2,) of the chair relative to each person before the step, m/s.
            speed: of the chair before the step, m/s.
        """
        for each in self._open.values():
            each.idle += 1
        for force in forces:
            key = (force.person, force.part, force.chair_part)
            relative = closing.get(force.person, np.zeros(2))
            now = Touch(
                time=time,
                person=force.person,
                part=force.part,
                chair_part=force.chair_part,
                force=force.force,
                energy=_energy(force),
                speed=max(float(relative @ force.normal[:2]), 0.0),
                chair_speed=speed,
            )
            known = self._open.get(key)
            if known is None:
                self._open[key] = _Open(now)
            else:
                known.idle = 0
                known.touch = _stronger(known.touch, now)

    def touches(self) -> tuple[Touch, ...]:
        """Contacts of this control step with their maxima so far; then forget those that ended."""
        active = tuple(each.touch for each in self._open.values())
        self._open = {key: each for key, each in self._open.items() if each.idle < FREE_STEPS}
        return active


def _energy(force: ContactForce) -> float:
    """Energy in the spring of a body region, F²/2k, J."""
    if force.person < 0:
        return 0.0
    return force.force**2 / (2.0 * REGIONS[force.part].stiffness)


def _stronger(first: Touch, now: Touch) -> Touch:
    """Touch with the maxima of both, and the beginning of the first."""
    return Touch(
        time=first.time,
        person=first.person,
        part=first.part,
        chair_part=first.chair_part,
        force=max(first.force, now.force),
        energy=max(first.energy, now.energy),
        speed=first.speed,
        chair_speed=first.chair_speed,
    )
