"""Chair of the twin in its world: MuJoCo moves it, and people and walls touch it.

The model holds chair, building and people; the sensors are rays of MuJoCo from the moving body.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats, Integers, replace
from cohelm.geometry import wrap_angle
from cohelm.maps import OccupancyGrid
from cohelm.messages import Inertial, PointCloud, Scan
from cohelm.platforms.twin.building import CEILING, PEOPLE, SEEN, add_building
from cohelm.platforms.twin.chair import add_chair
from cohelm.platforms.twin.contacts import ContactLog, ContactTable, contact_forces, contact_table
from cohelm.platforms.twin.motors import (
    BRAKE_TORQUE,
    chassis_of,
    control_wheels,
    motors_at_rest,
    twist_of_wheels,
)
from cohelm.platforms.twin.people import (
    JOINTS,
    PersonGeoms,
    add_people,
    person_table,
    places_of,
    soften,
    walk_on,
)
from cohelm.robots import CloudMount, LaserMount
from cohelm.simulation import Contacts, Crowd, CrowdStep, WorldSetup, is_standing
from cohelm.simulation.drivetrain import DriveCommand
from cohelm.simulation.sensing import Casting
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.laser import beam_angles, measured_scan
from cohelm.simulation.sensors.point_cloud import measured_cloud, rays_of, rotation_of
from cohelm.simulation.sensors.static_scene import StaticScene
from cohelm.simulation.simulated_chair import Grip

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


HIDDEN = 5
"""Group of bodies that nothing sees."""
_SEEN = np.array([group in {SEEN, PEOPLE, CEILING} for group in range(6)], dtype=np.uint8)


class BodyCasting:
    """Rays from the chair's body as it stands: with its roll and pitch, at its own height.

    A planar scanner that looks down with the body meets the floor; glass and the chair itself are
    seen by no sensor.

    Args:
        mujoco: the module.
        model: with all bodies.
        data: their state now.
        table: geometries of people.
        visible: (n,) mask of people who can be seen.
        height: of planar scanners over the floor, m.
    """

    def __init__(  # the four values of MuJoCo belong together
        self,
        mujoco: Any,
        model: Any,
        data: Any,
        table: PersonGeoms,
        visible: Booleans,
        height: float,
    ) -> None:
        self._mujoco, self._model, self._data = mujoco, model, data
        self._table, self._visible, self._height = table, visible, height

    def scan(self, mount: LaserMount, *, time: float, rng: np.random.Generator) -> Scan:
        """See :meth:`cohelm.simulation.sensing.Casting.scan`."""
        x, y, yaw = mount.pose
        angles = beam_angles(mount) + yaw
        rays = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
        ranges = self._cast(np.array([x, y, self._height]), rays, mount.range_max)
        return measured_scan(mount, ranges, time=time, rng=rng)

    def cloud(self, mount: CloudMount, *, time: float, rng: np.random.Generator) -> PointCloud:
        """See :meth:`cohelm.simulation.sensing.Casting.cloud`."""
        x, y, z, roll, pitch, yaw = mount.pose
        rays = rays_of(mount)[0] @ rotation_of(roll, pitch, yaw).T
        distance = self._cast(np.array([x, y, z]), rays, mount.range_max)
        return measured_cloud(mount, distance, time=time, rng=rng)

    def _cast(self, origin: Floats, rays: Floats, reach: float) -> Floats:
        """Distance (b,) along rays (b, 3) from an origin (3,), chair's frame, m; +inf: none."""
        chair = self._data.body("chair")
        R_MR = chair.xmat.reshape(3, 3)
        count = len(rays)
        distance, geoms = np.empty(count), np.empty(count, dtype=np.int32)
        with self._unseen():
            self._mujoco.mj_multiRay(
                self._model,
                self._data,
                chair.xpos + R_MR @ origin,
                (rays @ R_MR.T).ravel(),
                _SEEN,
                True,
                -1,
                geoms,
                distance,
                None,
                count,
                reach,
            )
        return np.where((distance < 0.0) | (distance > reach), math.inf, distance)

    @contextmanager
    def _unseen(self) -> Iterator[None]:
        """Hide people who are not visible."""
        hidden = self._table.hidden(self._visible)
        self._model.geom_group[hidden] = HIDDEN
        try:
            yield
        finally:
            self._model.geom_group[hidden] = PEOPLE


TIME_STEP = 0.002
"""Upper bound of MuJoCo's step, s."""
_SETTLING = 1.0
"""Time that the chair has to sink into its springs before the ride, s."""


class TwinChair:
    """Chair with wheels, casters, suspension and motors; see ``SimulatedChair``.

    Args:
        mujoco: the module.
        setup: world.
    """

    def __init__(self, mujoco: Any, setup: WorldSetup) -> None:
        self._mujoco, self._setup = mujoco, setup
        self._robot, self._chassis = setup.robot, chassis_of(setup.robot)
        self._motors = motors_at_rest(setup.robot)
        self._log = ContactLog()
        self._time = 0.0
        self._grid = setup.grid
        self._pushed = np.zeros(len(setup.crowd.radius), dtype=np.bool_)
        self._untouched = np.full(len(setup.crowd.radius), np.inf)
        self._walked_into_us = np.zeros(len(setup.crowd.radius), dtype=np.bool_)
        bodies = _bodies_at_start(setup)
        self._twin = build_model(mujoco, setup, setup.grid, bodies)
        self._place(setup.start)
        self._settle(bodies)

    @property
    def twin(self) -> TwinModel:
        """Model and state of MuJoCo, for films and checks; never for the navigator."""
        return self._twin

    @property
    def eyes(self) -> float:
        """Height of the rider's eyes over the floor, m."""
        return self._chassis.body.eyes

    def show(self, pose: Floats, bodies: HumanBodies) -> None:
        """Put chair and people in places for a picture, without any motion."""
        self._place(pose)
        self._twin.people_state()[0][:] = places_of(bodies, self._setup.relief)
        self._mujoco.mj_forward(self._twin.model, self._twin.data)

    @property
    def pose(self) -> Floats:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        q = self._twin.data.qpos
        return np.array([q[0], q[1], _yaw(q[3:7])])

    @property
    def twist(self) -> Floats:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        v = self._twin.data.qvel
        yaw = _yaw(self._twin.data.qpos[3:7])
        c, s = math.cos(yaw), math.sin(yaw)
        up = self._rotation()[2]
        return np.array([c * v[0] + s * v[1], c * v[1] - s * v[0], float(up @ v[3:6])])

    @property
    def wheel_twist(self) -> Floats:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        return twist_of_wheels(self._chassis, self._wheel_speeds())

    @property
    def inertial(self) -> Inertial:
        """Reading of the inertial unit now, without errors."""
        data, R = self._twin.data, self._rotation()
        return Inertial(
            time=self._time,
            acceleration=data.sensor("accelerometer").data.copy(),
            turn_rate=data.sensor("gyro").data.copy(),
            tilt=np.array([math.atan2(R[2, 1], R[2, 2]), -math.asin(R[2, 0])]),
        )

    def branch(self) -> TwinChair:
        """See ``SimulatedChair``; the model is shared until the building changes."""
        out = copy.copy(self)
        out._log = copy.deepcopy(self._log)
        out._twin = replace(self._twin, data=copy.copy(self._twin.data))
        for name in ("_pushed", "_untouched", "_walked_into_us"):
            setattr(out, name, getattr(self, name).copy())
        return out

    def carry(self, pose: Floats) -> None:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        old = self.pose
        self._place(pose)
        turn = pose[2] - old[2]
        c, s = math.cos(turn), math.sin(turn)
        v = self._twin.data.qvel
        v[0], v[1] = c * v[0] - s * v[1], s * v[0] + c * v[1]
        self._mujoco.mj_forward(self._twin.model, self._twin.data)

    def begin(self, step: CrowdStep) -> None:
        """Begin a control step; obstacles or people that are new give a new model."""
        n = len(step.before.radius)
        if step.grid is not self._grid or n != self._twin.people:
            fresh = build_model(self._mujoco, self._setup, step.grid, step.people(0.0))
            fresh.take_chair(self._twin)
            self._twin, self._grid = fresh, step.grid
            new = n - len(self._pushed)
            self._pushed = np.append(self._pushed, np.zeros(new, dtype=np.bool_))
            self._untouched = np.append(self._untouched, np.full(new, np.inf))
            self._walked_into_us = np.append(self._walked_into_us, np.zeros(new, dtype=np.bool_))
        self._step = step
        self._hits = np.zeros((2, n), dtype=np.bool_)
        self._hit_wall = False
        self._velocity = np.where(
            (step.before.there & step.after.there)[:, None],
            (step.after.position - step.before.position) / self._setup.control_step,
            0.0,
        )

    def move(self, command: DriveCommand, dt: float, share: float, grip: Grip) -> None:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        model, data = self._twin.model, self._twin.data
        self._motors, wheels = control_wheels(
            self._robot, self._motors, command, dt, self._wheel_speeds(), grip
        )
        data.ctrl[:] = wheels.speed
        model.dof_frictionloss[self._twin.drive_dofs] = (
            BRAKE_TORQUE if wheels.parked else self._twin.rolling
        )
        twist = self.twist
        share_before = share - dt / self._setup.control_step
        self._move_people(self._step.people(max(share_before, 0.0)))
        steps = max(math.ceil(dt / TIME_STEP - 1e-9), 1)
        model.opt.timestep = dt / steps
        self._mujoco.mj_step(model, data, steps)
        self._time += dt
        self._note_contacts(twist, dt)

    def casting(self, scene: StaticScene, bodies: HumanBodies, visible: Booleans) -> Casting:
        """See :class:`cohelm.simulation.SimulatedChair`."""
        self._mujoco.mj_kinematics(self._twin.model, self._twin.data)
        return BodyCasting(
            self._mujoco,
            self._twin.model,
            self._twin.data,
            self._twin.persons,
            visible,
            self._chassis.laser_height,
        )

    def end(self) -> Contacts:
        """End the control step; the crowd goes on from where contacts have pushed it."""
        return Contacts(
            hit_moving=self._hits[0],
            hit_standing=self._hits[1],
            hit_wall=self._hit_wall,
            after=self._pushed_crowd(self._step.after),
            touches=self._log.touches(),
        )

    def _note_contacts(self, twist: Floats, dt: float) -> None:
        """Log the forces after a motion step of ``dt``; twist: (3,) of the chair before it.

        A contact that began while the chair stood stays one, also where it pushes the chair away.
        """
        twin = self._twin
        forces = contact_forces(self._mujoco, twin.model, twin.data, twin.contacts)
        yaw, speed = _yaw(twin.data.qpos[3:7]), math.hypot(twist[0], twist[1])
        c, s = math.cos(yaw), math.sin(yaw)
        mine = np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1]])
        closing = {-1: mine}
        touched = np.zeros(twin.people, dtype=np.bool_)
        for force in forces:
            if force.person < 0:
                self._hit_wall = True
                continue
            touched[force.person] = True
            closing[force.person] = mine - self._velocity[force.person]
        began = touched & (self._untouched >= _APART)
        self._walked_into_us = np.where(began, bool(is_standing(twist)), self._walked_into_us)
        self._hits[0] |= touched & ~self._walked_into_us
        self._hits[1] |= touched & self._walked_into_us
        self._log.add(forces, self._time, closing, speed)
        self._pushed |= touched
        self._untouched = np.where(touched, 0.0, self._untouched + dt)

    def _move_people(self, bodies: HumanBodies) -> None:
        """Put untouched people in their places, and let those who were pushed walk on."""
        twin = self._twin
        if twin.people == 0:
            return
        q, v, applied = twin.people_state()
        places = places_of(bodies, self._setup.relief)
        error = np.hypot(*(places[:, :2] - q[:, :2]).T)
        self._pushed &= (error > _BACK) | (self._untouched < _APART)
        free = ~self._pushed
        q[:, 2:], v[:, 2:] = places[:, 2:], 0.0
        q[free, :2], v[free, :2] = places[free, :2], self._velocity[free]
        applied[:] = 0.0
        if self._pushed.any():
            k = np.flatnonzero(self._pushed)
            applied[k, :2] = walk_on(
                q[k, :2], v[k, :2], places[k, :2], self._velocity[k], twin.masses[k]
            )

    def _pushed_crowd(self, after: Crowd) -> Crowd:
        if not self._pushed.any():
            return after
        q, v, _ = self._twin.people_state()
        position, velocity = after.position.copy(), after.velocity.copy()
        position[self._pushed] = q[self._pushed, :2]
        velocity[self._pushed] = v[self._pushed, :2]
        return replace(after, position=position, velocity=velocity)

    def _place(self, pose: Floats) -> None:
        """Put the chair on the floor at a pose, level with it."""
        relief, data = self._setup.relief, self._twin.data
        slope = relief.floor.slope(pose[:2])
        up = np.array([-slope[0], -slope[1], 1.0]) / math.hypot(1.0, *slope)
        ahead = np.array([math.cos(pose[2]), math.sin(pose[2]), 0.0])
        ahead -= (ahead @ up) * up
        ahead /= np.linalg.norm(ahead)
        R = np.stack([ahead, np.cross(up, ahead), up], axis=-1)
        data.qpos[:3] = (*pose[:2], float(relief.heights(pose[:2])))
        self._mujoco.mju_mat2Quat(data.qpos[3:7], R.ravel())

    def _settle(self, bodies: HumanBodies) -> None:
        """Let the springs settle with the brakes on, without people, then return to the start."""
        twin, data = self._twin, self._twin.data
        twin.model.dof_frictionloss[twin.drive_dofs] = BRAKE_TORQUE
        away = twin.people_state()[0]
        away[:, 0], away[:, 1] = 1e6, 10.0 * np.arange(len(away))
        twin.model.opt.timestep = TIME_STEP
        self._mujoco.mj_step(twin.model, data, round(_SETTLING / TIME_STEP))
        data.qpos[0], data.qpos[1] = self._setup.start[:2]
        data.qvel[: twin.chair_size[1]] = 0.0
        away[:] = places_of(bodies, self._setup.relief)
        self._mujoco.mj_forward(twin.model, data)

    def _wheel_speeds(self) -> Floats:
        return np.asarray(self._twin.data.qvel[self._twin.drive_dofs])

    def _rotation(self) -> Floats:
        R = np.zeros(9)
        self._mujoco.mju_quat2Mat(R, self._twin.data.qpos[3:7])
        return R.reshape(3, 3)


_BACK = 0.01
"""Distance from the place in the crowd within which a pushed person is free again, m …"""
_APART = 0.3
"""… after this time without a touch, s."""


def _bodies_at_start(setup: WorldSetup) -> HumanBodies:
    crowd = setup.crowd
    n = len(crowd.radius)
    return HumanBodies(
        position=crowd.position,
        heading=crowd.heading,
        walked=np.zeros(n),
        speed=np.zeros(n),
        height=np.full(n, 1.7) if setup.statures is None else setup.statures,
        radius=crowd.radius,
        kind=setup.kinds,
    )


def _yaw(quat: Floats) -> float:
    w, x, y, z = quat
    return float(wrap_angle(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))))
