"""Chair of the twin in its world: MuJoCo moves it, and people and walls touch it."""

from __future__ import annotations

import copy
import math
from dataclasses import replace
from typing import Any

import numpy as np

from cohelm.arrays import Booleans, Floats
from cohelm.geometry import wrap_angle
from cohelm.messages import Inertial
from cohelm.platforms.twin.contacts import ContactLog, contact_forces
from cohelm.platforms.twin.model import TwinModel, build_model
from cohelm.platforms.twin.motors import (
    BRAKE_TORQUE,
    chassis_of,
    control_wheels,
    motors_at_rest,
    twist_of_wheels,
)
from cohelm.platforms.twin.people import places_of, walk_on
from cohelm.platforms.twin.sensors import BodyCasting
from cohelm.simulation import Contacts, Crowd, CrowdStep, WorldSetup, is_standing
from cohelm.simulation.drivetrain import DriveCommand
from cohelm.simulation.sensing import Casting
from cohelm.simulation.sensors.human_bodies import HumanBodies
from cohelm.simulation.sensors.static_scene import StaticScene
from cohelm.simulation.simulated_chair import Grip

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
        self._twin.people_state()[0][:] = places_of(bodies, self._setup.relief.floor)
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
        places = places_of(bodies, self._setup.relief.floor)
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
        floor = self._setup.relief.floor
        data = self._twin.data
        slope = floor.slope(pose[:2])
        up = np.array([-slope[0], -slope[1], 1.0]) / math.hypot(1.0, *slope)
        ahead = np.array([math.cos(pose[2]), math.sin(pose[2]), 0.0])
        ahead -= (ahead @ up) * up
        ahead /= np.linalg.norm(ahead)
        R = np.stack([ahead, np.cross(up, ahead), up], axis=-1)
        data.qpos[:3] = (*pose[:2], float(floor.height(pose[:2])))
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
        away[:] = places_of(bodies, self._setup.relief.floor)
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
