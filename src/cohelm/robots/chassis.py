"""Mechanics of a wheeled chair for the MuJoCo twin: wheels, casters, suspension, masses, motors.

The planar simulation and the planners ignore all of this. Lengths are in the robot's frame, whose
origin lies on the floor under the middle of the drive axle (REP-103). The defaults are a mid-wheel
drive chair for adults that fits the base of the Quantum Q6 Edge 2.0. No data sheet gives most of
these values: they are assumed, in the range of such chairs, and say so.
"""

from __future__ import annotations

from typing import Self

from pydantic import Field, model_validator

from cohelm.config import Model


class DriveWheels(Model):
    """Two driven wheels on one axle, fixed to the base."""

    radius: float = Field(0.178, gt=0.02, le=0.5)
    """m (assumed: tyres of 14 in., common on such chairs)."""
    width: float = Field(0.06, gt=0.005, le=0.3)
    """Width of the tyre on the floor, m (assumed)."""
    track: float = Field(0.53, gt=0.05, le=2.0)
    """Distance between the wheels' middles, m (assumed: base of 0.61 m less a tyre and a guard)."""
    mass: float = Field(9.0, gt=0.0, le=100.0)
    """Of one wheel with hub, kg (assumed)."""
    friction: float = Field(0.8, ge=0.05, le=2.0)
    """Tyre on dry vinyl floor, without unit (assumed: rubber, 0.6 to 1.0)."""
    scrub: float = Field(0.01, ge=0.0, le=0.05)
    """Effective radius of the patch on the floor, m: turning on the spot takes friction · load ·
    radius (two thirds of the radius of a disc under even pressure; 15 mm is assumed)."""
    rolling_resistance: float = Field(0.015, ge=0.0, le=0.2)
    """Share of the load (assumed: solid tyres on smooth floor, 0.01 to 0.02)."""
    load: float = Field(0.55, gt=0.1, lt=1.0)
    """Share of the weight on level floor (assumed); the suspension is preloaded for it."""


class Casters(Model):
    """Two swivelling casters on one cross line, each on a vertical spring."""

    axis: tuple[float, float]
    """Swivel axis of the left one: x, and distance y from the middle, m."""
    radius: float = Field(0.076, gt=0.01, le=0.3)
    """m (assumed: wheels of 6 in., common on such chairs)."""
    width: float = Field(0.045, gt=0.005, le=0.2)
    """m (assumed)."""
    trail: float = Field(0.05, ge=0.0, le=0.3)
    """Distance of the wheel's axle behind the swivel axis, m (assumed: 0.04 to 0.06)."""
    mass: float = Field(1.5, gt=0.0, le=30.0)
    """Of fork and wheel, kg (assumed)."""
    swivel_friction: float = Field(0.4, ge=0.0, le=20.0)
    """Dry friction of the swivel bearing, N m (assumed)."""
    swivel_damping: float = Field(0.05, ge=0.0, le=20.0)
    """N m s/rad (assumed)."""
    friction: float = Field(0.7, ge=0.0, le=2.0)
    """Tyre on floor, without unit (assumed)."""
    rolling_resistance: float = Field(0.02, ge=0.0, le=0.2)
    """Share of the load (assumed)."""
    stiffness: float = Field(15000.0, gt=100.0, le=1e6)
    """Of one spring, N/m (assumed: 20 mm under the static load)."""
    damping: float = Field(1000.0, ge=0.0, le=1e5)
    """Of one damper, N s/m (assumed: about 0.4 of critical)."""
    travel: float = Field(0.06, gt=0.0, le=0.3)
    """Way of the wheel up and down from its place on level floor, m (assumed)."""


class Masses(Model):
    """Masses and their centres."""

    base: float = Field(118.0, gt=1.0, le=1000.0)
    """Chair with batteries and seat, without the wheels, kg: 140 kg together (assumed)."""
    base_centre: tuple[float, float, float] = (-0.02, 0.0, 0.28)
    """m (assumed: batteries low between the wheels)."""
    rider: float = Field(75.0, ge=0.0, le=300.0)
    """kg (assumed; a test dummy of ISO 7176-11 has 75 or 100 kg)."""
    rider_centre: tuple[float, float, float] = (0.04, 0.0, 0.72)
    """m (assumed: 0.2 m over the seat)."""


class Motors(Model):
    """Motors, and their speed controller."""

    torque: float = Field(110.0, gt=0.0, le=2000.0)
    """Maximum torque of one wheel, N m (assumed: a slope of 10° with 136 kg takes 40 N m each,
    and an edge of 5 cm twice that)."""
    bandwidth: float = Field(6.0, gt=0.1, le=50.0)
    """Of the speed controller, Hz (assumed)."""
    integral: float = Field(6.0, ge=0.0, le=50.0)
    """Integral action as share of the proportional one, 1/s (assumed)."""


class ChairBody(Model):
    """Parts that touch people and walls, as boxes over the footprint."""

    ground_clearance: float = Field(0.075, gt=0.0, le=0.5)
    """Under the base, m (assumed: 3 in.)."""
    deck: float = Field(0.40, gt=0.0, le=2.0)
    """Height of the base's top, m (assumed)."""
    nose: float = Field(0.45, ge=-2.0, le=5.0)
    """x of the base's front; the footrests reach on from there to the footprint's front, m."""
    seat: float | None = Field(0.52, gt=0.0, le=2.0)
    """Height of the seat, m (assumed); None: no seat and no rider's body."""
    armrest: float = Field(0.72, gt=0.0, le=2.0)
    """Height of the armrests, m (assumed)."""
    footrest: tuple[float, float] = (0.10, 0.20)
    """Lowest and highest point of the footrests, m (assumed)."""
    footrest_width: float = Field(0.42, gt=0.0, le=2.0)
    """m (assumed)."""
    eyes: float = Field(1.25, gt=0.0, le=3.0)
    """Height of the rider's eyes, m (assumed)."""


class Chassis(Model):
    """Mechanics of a chair: driven wheels with casters ahead of them, behind them, or both."""

    drive: DriveWheels = DriveWheels()
    front: Casters | None = Casters(axis=(0.39, 0.22))
    """None: rear casters only, a front-wheel drive."""
    rear: Casters | None = Casters(axis=(-0.33, 0.22))
    """None: front casters only, a rear-wheel drive."""
    masses: Masses = Masses()
    motors: Motors = Motors()
    body: ChairBody = ChairBody()
    laser_height: float = Field(0.30, gt=0.0, le=3.0)
    """Height of planar scanners over the floor, m (assumed: over the footrests, under the seat)."""

    @model_validator(mode="after")
    def _stands_on_its_wheels(self) -> Self:
        front, rear = self.caster_loads
        for load, casters in ((front, self.front), (rear, self.rear)):
            if casters is not None and load <= 0.0:
                raise ValueError(
                    "the casters ahead or behind carry nothing: move the masses or lower drive.load"
                )
        if self.front is None and self.rear is None:
            raise ValueError("give casters in front, in the rear, or both")
        return self

    @property
    def total_mass(self) -> float:
        """Mass of chair and rider, kg."""
        casters = [each for each in (self.front, self.rear) if each is not None]
        wheels = 2.0 * self.drive.mass + sum(2.0 * each.mass for each in casters)
        return self.masses.base + self.masses.rider + wheels

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of mass of chair and rider on level floor: x and height, m."""
        m = self.masses
        parts = [
            (m.base, m.base_centre[0], m.base_centre[2]),
            (m.rider, m.rider_centre[0], m.rider_centre[2]),
            (2.0 * self.drive.mass, 0.0, self.drive.radius),
        ]
        parts += [
            (2.0 * each.mass, each.axis[0] - each.trail, each.radius)
            for each in (self.front, self.rear)
            if each is not None
        ]
        total = self.total_mass
        return sum(w * x for w, x, _ in parts) / total, sum(w * z for w, _, z in parts) / total

    @property
    def caster_loads(self) -> tuple[float, float]:
        """Share of the weight on both front and on both rear casters, straight ahead.

        With casters on both sides ``drive.load`` decides; with one pair the moments do.
        """
        x = self.centre[0]
        if self.front is not None and self.rear is not None:
            ahead = self.front.axis[0] - self.front.trail
            behind = self.rear.axis[0] - self.rear.trail
            left = 1.0 - self.drive.load
            front = (x - left * behind) / (ahead - behind)
            return front, left - front
        if self.front is not None:
            return x / (self.front.axis[0] - self.front.trail), 0.0
        if self.rear is not None:
            return 0.0, x / (self.rear.axis[0] - self.rear.trail)
        return 0.0, 0.0
