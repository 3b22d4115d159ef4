"""Chair of the twin: MJCF generated from a robot file."""

from __future__ import annotations

from typing import Any

from cohelm.platforms.twin.motors import chassis_of, speed_gain
from cohelm.robots import Robot
from cohelm.robots.chassis import Casters, ChairBody, Chassis

GRAVITY = 9.81
"""m/s²."""
CHAIR_GROUP = 2
"""Group of the chair's bodies, which its own sensors do not see."""
_RIDER = (0.45, 0.40, 0.30, 1.0)
_FRAME = (0.20, 0.22, 0.25, 1.0)
_SEAT = (0.12, 0.30, 0.45, 1.0)
_TYRE = (0.08, 0.08, 0.08, 1.0)
_FLOOR = 1
_SOLID = 2
_SOFT = 4
"""Bits of contact: floor and wheels; bodies and walls; people."""


def add_chair(spec: Any, mujoco: Any, robot: Robot) -> None:
    """Add a robot's chair to a model, at rest at the origin with all wheels on the floor.

    Args:
        spec: ``mujoco.MjSpec`` to extend.
        mujoco: the module.
        robot: with its chassis.
    """
    chassis = chassis_of(robot)
    chair = spec.worldbody.add_body(name="chair")
    chair.add_freejoint(name="chair")
    _add_masses(chair, mujoco, chassis)
    _add_bodies(chair, mujoco, chassis.body, robot)
    weight = chassis.total_mass * GRAVITY
    front, rear = chassis.caster_loads
    for side, sign in (("left", 1.0), ("right", -1.0)):
        _add_drive_wheel(chair, mujoco, chassis, side, sign, (1.0 - front - rear) / 2.0 * weight)
        for place, casters, load in (("front", chassis.front, front), ("rear", chassis.rear, rear)):
            if casters is not None:
                _add_caster(chair, mujoco, casters, f"{place}_{side}", sign, load / 2.0 * weight)
    for side in ("left", "right"):
        limit = chassis.motors.torque
        motor = spec.add_actuator(
            name=side,
            target=f"drive_{side}",
            trntype=mujoco.mjtTrn.mjTRN_JOINT,
            forcelimited=True,
            forcerange=[-limit, limit],
        )
        motor.set_to_velocity(kv=speed_gain(chassis))
    chair.add_site(name="imu", pos=[0.0, 0.0, chassis.drive.radius])
    spec.add_sensor(
        name="accelerometer",
        type=mujoco.mjtSensor.mjSENS_ACCELEROMETER,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="imu",
    )
    spec.add_sensor(
        name="gyro",
        type=mujoco.mjtSensor.mjSENS_GYRO,
        objtype=mujoco.mjtObj.mjOBJ_SITE,
        objname="imu",
    )


def _add_masses(chair: Any, mujoco: Any, chassis: Chassis) -> None:
    """Base and rider as boxes of even density, which touch nothing."""
    m = chassis.masses
    boxes = [(m.base, m.base_centre, (0.30, 0.22, 0.15))]
    if m.rider > 0.0:
        boxes.append((m.rider, m.rider_centre, (0.20, 0.18, 0.30)))
    for mass, centre, half in boxes:
        chair.add_geom(
            type=mujoco.mjtGeom.mjGEOM_BOX,
            size=half,
            pos=centre,
            mass=mass,
            contype=0,
            conaffinity=0,
            group=5,
        )


def _add_bodies(chair: Any, mujoco: Any, b: ChairBody, robot: Robot) -> None:
    """Boxes that touch people and walls, within the footprint."""
    low, high = robot.outline.min(axis=0), robot.outline.max(axis=0)
    half_width = (high[1] - low[1]) / 2.0
    nose = min(max(b.nose, low[0] + 0.05), high[0])
    boxes = {"base": ((low[0], nose), half_width, (b.ground_clearance, b.deck), _FRAME)}
    if nose < high[0]:
        boxes["footrests"] = ((nose, high[0]), b.footrest_width / 2.0, b.footrest, _FRAME)
    if b.seat is not None:
        back = low[0] + 0.10
        boxes["seat"] = ((back, nose), 0.24, (b.deck, b.seat), _SEAT)
        boxes["backrest"] = ((back - 0.08, back), 0.22, (b.seat, b.seat + 0.55), _SEAT)
        boxes["lap"] = ((back, nose), 0.20, (b.seat, b.seat + 0.15), _RIDER)
        boxes["torso"] = ((back, back + 0.24), 0.20, (b.seat + 0.15, b.seat + 0.60), _RIDER)
        boxes["shanks"] = ((nose, nose + 0.14), 0.17, (b.footrest[1], b.seat + 0.10), _RIDER)
        boxes["arms"] = ((back, nose - 0.10), 0.29, (b.armrest - 0.06, b.armrest), _FRAME)
    for name, ((x0, x1), width, (z0, z1), colour) in boxes.items():
        chair.add_geom(
            name=name,
            type=mujoco.mjtGeom.mjGEOM_BOX,
            pos=[(x0 + x1) / 2.0, (low[1] + high[1]) / 2.0, (z0 + z1) / 2.0],
            size=[(x1 - x0) / 2.0, width, (z1 - z0) / 2.0],
            mass=0.0,
            contype=_SOLID | _SOFT,
            conaffinity=_SOLID,
            friction=[0.3, 0.0, 0.0],
            group=CHAIR_GROUP,
            rgba=colour,
        )
    if b.seat is not None:
        chair.add_geom(
            name="head",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[0.11, 0.0, 0.0],
            pos=[low[0] + 0.22, 0.0, b.eyes],
            mass=0.0,
            contype=_SOLID | _SOFT,
            conaffinity=_SOLID,
            group=CHAIR_GROUP,
            rgba=_RIDER,
        )


def _add_drive_wheel(
    chair: Any, mujoco: Any, chassis: Chassis, side: str, sign: float, load: float
) -> None:
    d = chassis.drive
    wheel = chair.add_body(name=f"drive_{side}", pos=[0.0, sign * d.track / 2.0, d.radius])
    wheel.add_joint(
        name=f"drive_{side}",
        axis=[0.0, 1.0, 0.0],
        frictionloss=d.rolling_resistance * load * d.radius,
        armature=0.05,
        solimp_friction=[0.9999, 0.9999, 0.001, 0.5, 2.0],  # a parking brake does not creep
    )
    # A crowned tyre has one point of contact. The two points of a cylinder would let the effective
    # track jump by the tyre's width, since either may stick while the other slides.
    wheel.add_geom(
        name=f"drive_{side}",
        type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
        size=[d.radius, d.width / 2.0, d.radius],
        mass=d.mass,
        contype=_FLOOR | _SOLID | _SOFT,
        conaffinity=_FLOOR | _SOLID,
        condim=4,
        friction=[d.friction, d.friction * d.scrub, 0.0],
        priority=1,
        group=CHAIR_GROUP,
        rgba=_TYRE,
    )


def _add_caster(
    chair: Any, mujoco: Any, casters: Casters, name: str, sign: float, load: float
) -> None:
    """Add a spring, a swivel and a wheel; all three at their places on level floor under load.

    The wheel is a sphere to the solver: one point of contact, exact on edges of boxes.
    """
    c = casters
    inert = {"mass": 0.2, "inertia": [1e-3, 1e-3, 1e-3], "explicitinertial": True}
    arm = chair.add_body(name=f"arm_{name}", pos=[c.axis[0], sign * c.axis[1], c.radius], **inert)
    arm.add_joint(
        name=f"spring_{name}",
        type=mujoco.mjtJoint.mjJNT_SLIDE,
        axis=[0.0, 0.0, 1.0],
        stiffness=[c.stiffness, 0.0, 0.0],
        springref=-load / c.stiffness,
        damping=[c.damping, 0.0, 0.0],
        limited=True,
        range=[-c.travel, c.travel],
    )
    fork = arm.add_body(
        name=f"fork_{name}",
        mass=0.3 * c.mass,
        ipos=[-0.5 * c.trail, 0.0, 0.0],
        inertia=[2e-3, 2e-3, 2e-3],
        explicitinertial=True,
    )
    fork.add_joint(
        name=f"swivel_{name}",
        axis=[0.0, 0.0, 1.0],
        frictionloss=c.swivel_friction,
        damping=[c.swivel_damping, 0.0, 0.0],
    )
    wheel = fork.add_body(name=f"caster_{name}", pos=[-c.trail, 0.0, 0.0])
    wheel.add_joint(
        name=f"roll_{name}",
        axis=[0.0, 1.0, 0.0],
        frictionloss=c.rolling_resistance * load * c.radius,
    )
    wheel.add_geom(
        name=f"caster_{name}",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[c.radius, 0.0, 0.0],
        mass=0.7 * c.mass,
        contype=_FLOOR,
        conaffinity=_FLOOR,
        friction=[c.friction, 0.0, 0.0],
        priority=1,
        group=CHAIR_GROUP,
        rgba=_TYRE,
    )
