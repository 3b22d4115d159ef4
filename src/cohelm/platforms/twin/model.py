"""Model of a world in MuJoCo: chair, building and people, with what is needed to move them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Floats, Integers
from cohelm.maps import OccupancyGrid
from cohelm.platforms.twin.building import add_building
from cohelm.platforms.twin.chair import add_chair
from cohelm.platforms.twin.contacts import ContactTable, contact_table
from cohelm.platforms.twin.people import JOINTS, PersonGeoms, add_people, person_table, soften
from cohelm.simulation import WorldSetup
from cohelm.simulation.sensors.human_bodies import HumanBodies

_WIDTH, _HEIGHT = 1280, 720
"""Largest picture, pixels."""


@dataclass(frozen=True, slots=True)
class TwinModel:
    """Model and state of MuJoCo, and where its parts are."""

    model: Any
    data: Any
    people: int
    persons: PersonGeoms
    contacts: ContactTable
    drive_dofs: Integers
    """(2,) degrees of freedom of the left and the right drive wheel."""
    rolling: Floats
    """(2,) dry friction of the drive wheels, N m."""
    masses: Floats
    """(n,) kg."""
    chair_size: tuple[int, int]
    """Coordinates and degrees of freedom of the chair, which come first."""

    def people_state(self) -> tuple[Floats, Floats, Floats]:
        """Coordinates, velocities and applied forces of people, views of (n, 6)."""
        nq, nv = self.chair_size
        shape = (self.people, len(JOINTS))
        data = self.data
        return (
            data.qpos[nq:].reshape(shape),
            data.qvel[nv:].reshape(shape),
            data.qfrc_applied[nv:].reshape(shape),
        )

    def take_chair(self, old: TwinModel) -> None:
        """Copy the chair's state and that of people who were there from an older model."""
        nv = self.chair_size[1]
        old_q, old_v = old.data.qpos, old.data.qvel
        count = min(len(old_q), len(self.data.qpos))
        self.data.qpos[:count] = old_q[:count]
        self.data.qvel[: min(len(old_v), len(self.data.qvel))] = old_v[: len(self.data.qvel)]
        self.data.qacc_warmstart[:nv] = old.data.qacc_warmstart[:nv]


def build_model(
    mujoco: Any, setup: WorldSetup, grid: OccupancyGrid, bodies: HumanBodies
) -> TwinModel:
    """Build the model of a world; the chair lies at the origin, people at their joints' zeros.

    Args:
        mujoco: the module.
        setup: world.
        grid: true obstacles now.
        bodies: all people.
    """
    spec = mujoco.MjSpec()
    _set_solver(spec, mujoco)
    add_chair(spec, mujoco, setup.robot)
    add_people(spec, mujoco, bodies)
    add_building(spec, mujoco, setup, grid)
    model = spec.compile()
    n = len(bodies.height)
    persons = person_table(model, n)
    soften(model, persons, model.body("chair").id)
    wheels = [int(model.joint(f"drive_{side}").dofadr[0]) for side in ("left", "right")]
    trunks = [model.body(f"person_{i}_trunk").id for i in range(n)]
    return TwinModel(
        model=model,
        data=mujoco.MjData(model),
        people=n,
        persons=persons,
        contacts=contact_table(model, persons),
        drive_dofs=np.array(wheels),
        rolling=model.dof_frictionloss[wheels].copy(),
        masses=model.body_subtreemass[trunks].copy(),
        chair_size=(model.nq - n * len(JOINTS), model.nv - n * len(JOINTS)),
    )


def _set_solver(spec: Any, mujoco: Any) -> None:
    """Elliptic friction cones with stiff friction: tyres creep less on slopes."""
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = 10.0
    visual = spec.visual.global_
    visual.offwidth, visual.offheight = _WIDTH, _HEIGHT
    spec.visual.headlight.ambient = [0.45, 0.45, 0.45]
    spec.visual.headlight.diffuse = [0.45, 0.45, 0.45]
    spec.visual.headlight.specular = [0.05, 0.05, 0.05]
    spec.visual.map.znear = 0.005
    spec.stat.extent = 20.0
