"""A robot: footprint, limits, actuation and sensor mounts, read from one YAML file.

Sensors are planar scanners, 3-D LiDARs and depth cameras.
"""

from __future__ import annotations

import math
from functools import cached_property
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from cohelm.arrays import Booleans, Floats, read_only
from cohelm.config import Model, load, nearest
from cohelm.errors import ConfigError
from cohelm.geometry import distance_to_polygon
from cohelm.plugins import build, names
from cohelm.robots.chassis import Chassis
from cohelm.robots.kinematics import InputBounds, Kinematics

_Metres = Annotated[float, Field(ge=-5.0, le=5.0)]
_Radians = Annotated[float, Field(ge=-2.0 * math.pi, le=2.0 * math.pi)]
Pose6 = tuple[
    _Metres, _Metres, Annotated[float, Field(gt=0.0, le=5.0)], _Radians, _Radians, _Radians
]
"""X_RS: x, y and height z over the floor, m; then roll, pitch, yaw about the fixed axes, rad."""

_Turn = Annotated[float, Field(ge=0.0, le=360.0)]
_Elevation = Annotated[float, Field(ge=-90.0, le=90.0)]


class LaserMount(Model):
    """A planar laser scanner on the robot; the defaults are assumed."""

    name: str = "laser"
    """Unique name."""
    pose: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """X_RL: x, y in m, yaw in rad."""
    beams: int = Field(360, ge=2, le=20_000)
    """Ranges per sweep."""
    field_of_view_deg: float = Field(360.0, gt=0.0, le=360.0)
    """Centred on the sensor's x axis."""
    range_max: float = Field(10.0, gt=0.0, le=200.0)
    """m."""
    rate: float = Field(10.0, ge=0.1, le=100.0)
    """Sweeps per second."""
    noise: float = Field(0.01, ge=0.0, le=1.0)
    """Standard deviation of a range, m."""
    dropout: float = Field(0.005, ge=0.0, lt=1.0)
    """Share of beams lost."""


class BlindSector(Model):
    """Directions in which a LiDAR is occluded, for instance by the chair and its rider."""

    azimuth_deg: tuple[_Turn, _Turn]
    """From and to, counter-clockwise from the sensor's x axis; [350, 10] is straight ahead."""
    elevation_deg: tuple[_Elevation, _Elevation] = (-90.0, 90.0)
    """Lowest and highest."""

    @model_validator(mode="after")
    def _has_a_width(self) -> Self:
        if self.azimuth_deg[0] == self.azimuth_deg[1]:
            raise ValueError("azimuth_deg: [from, to] must differ; [0, 360] is all round")
        if not self.elevation_deg[0] < self.elevation_deg[1]:
            raise ValueError("elevation_deg must be [lowest, highest] with lowest < highest")
        return self

    def hides(self, azimuth: Floats, elevation: Floats) -> Booleans:
        """Mask of the directions (...,), rad, in this sector, its borders included."""
        first, last = self.azimuth_deg
        # rounding: an azimuth may be a sum of steps that ends next to a border
        turned = np.round(np.degrees(azimuth) % 360.0, 9) % 360.0
        within = (turned >= first) & (turned <= last)
        if first > last:
            within = (turned >= first) | (turned <= last)
        low, high = self.elevation_deg
        height = np.round(np.degrees(elevation), 9)
        hidden: Booleans = within & (height >= low) & (height <= high)
        return hidden


class LidarMount(Model):
    """A spinning LiDAR with several rings about the sensor's z axis; the defaults are assumed."""

    name: str = "lidar"
    """Unique name."""
    pose: Pose6 = (0.0, 0.0, 1.3, 0.0, 0.0, 0.0)
    """X_RS: x, y, height over the floor, m; roll, pitch, yaw, rad (REP-103: pitch > 0 looks
    down)."""
    rings: int = Field(32, ge=1, le=128)
    """Beams in a column, evenly spread over ``elevation_deg``."""
    azimuths: int = Field(1024, ge=4, le=4096)
    """Firings per turn, the first one backwards."""
    elevation_deg: tuple[_Elevation, _Elevation] = (-25.0, 15.0)
    """Elevation of the lowest and the highest ring: the vertical field of view."""
    range_min: float = Field(0.3, ge=0.0, le=10.0)
    """Smallest range with a return, m."""
    range_max: float = Field(10.0, gt=0.0, le=200.0)
    """m."""
    rate: float = Field(10.0, ge=0.1, le=100.0)
    """Sweeps per second."""
    noise: float = Field(0.02, ge=0.0, le=1.0)
    """Standard deviation of a range, m."""
    dropout: float = Field(0.005, ge=0.0, lt=1.0)
    """Share of returns lost."""
    blind: tuple[BlindSector, ...] = ()
    """Occluded directions."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        low, high = self.elevation_deg
        if not (low < high or (low == high and self.rings == 1)):
            raise ValueError("elevation_deg must be [lowest, highest] with lowest < highest")
        _check_reach(self.range_min, self.range_max)
        return self

    def rays(self) -> Floats:
        """Unit vectors (azimuths, rings, 3) in the sensor's frame, lowest ring first."""
        azimuth, elevation = self._angles()
        level = np.cos(elevation)
        x, y = level * np.cos(azimuth), level * np.sin(azimuth)
        return np.stack([x, y, np.broadcast_to(np.sin(elevation), x.shape)], axis=-1)

    def hidden(self) -> Booleans:
        """Mask of the rays (azimuths, rings) in a blind sector."""
        azimuth, elevation = self._angles()
        out = np.zeros((self.azimuths, self.rings), dtype=np.bool_)
        for sector in self.blind:
            out |= sector.hides(azimuth, elevation)
        return out

    @property
    def floor_from(self) -> float:
        """Distance ahead of the axle from which it sees the floor, m; +inf: nowhere."""
        return _floor_from(self.pose, -self.elevation_deg[0])

    def deviation(self, distance: Floats) -> Floats:
        """Standard deviation of ranges (...,), m."""
        return np.full_like(distance, self.noise)

    def _angles(self) -> tuple[Floats, Floats]:
        """(azimuths, 1) and (1, rings), rad."""
        turn = 2.0 * math.pi
        azimuth = turn * np.arange(self.azimuths) / self.azimuths - math.pi
        low, high = np.radians(self.elevation_deg)
        return azimuth[:, None], np.linspace(low, high, self.rings)[None, :]


class DepthCameraMount(Model):
    """A depth camera along the sensor's x axis; the defaults are assumed.

    Field of view of common stereo cameras; the image is downsampled as drivers do.
    """

    name: str = "depth"
    """Unique name."""
    pose: Pose6 = (0.4, 0.0, 0.7, 0.0, 0.35, 0.0)
    """X_RS: x, y, height over the floor, m; roll, pitch, yaw, rad (REP-103: pitch > 0 looks
    down)."""
    columns: int = Field(106, ge=2, le=1280)
    """Pixels per row."""
    rows: int = Field(60, ge=2, le=960)
    """Pixels per column."""
    field_of_view_deg: tuple[
        Annotated[float, Field(gt=0.0, lt=170.0)], Annotated[float, Field(gt=0.0, lt=170.0)]
    ] = (87.0, 58.0)
    """Horizontal and vertical."""
    range_min: float = Field(0.2, ge=0.0, le=10.0)
    """Smallest range with a return, m."""
    range_max: float = Field(10.0, gt=0.0, le=200.0)
    """m."""
    rate: float = Field(15.0, ge=0.1, le=100.0)
    """Frames per second."""
    noise: float = Field(0.0015, ge=0.0, le=1.0)
    """Standard deviation of a range divided by its square, 1/m: the disparity error is a share of a
    pixel."""
    dropout: float = Field(0.02, ge=0.0, lt=1.0)
    """Share of pixels lost."""

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        _check_reach(self.range_min, self.range_max)
        return self

    def rays(self) -> Floats:
        """Unit vectors (columns, rows, 3) in the sensor's frame, leftmost and lowest first."""
        across, upright = (math.tan(math.radians(view) / 2.0) for view in self.field_of_view_deg)
        left = across * (1.0 - (2.0 * np.arange(self.columns) + 1.0) / self.columns)
        up = upright * ((2.0 * np.arange(self.rows) + 1.0) / self.rows - 1.0)
        left, up = np.meshgrid(left, up, indexing="ij")
        rays = np.stack([np.ones_like(left), left, up], axis=-1)
        return np.asarray(rays / np.linalg.norm(rays, axis=-1, keepdims=True))

    def hidden(self) -> Booleans:
        """Mask of the rays (columns, rows): none is hidden."""
        return np.zeros((self.columns, self.rows), dtype=np.bool_)

    @property
    def floor_from(self) -> float:
        """Distance ahead of the axle from which it sees the floor, m; +inf: nowhere."""
        if abs(self.pose[5]) > math.pi / 2.0:
            return math.inf
        return _floor_from(self.pose, self.field_of_view_deg[1] / 2.0)

    def deviation(self, distance: Floats) -> Floats:
        """Standard deviation of ranges (...,), m; grows with their square."""
        return self.noise * distance * distance


CloudMount = LidarMount | DepthCameraMount
"""Any sensor of point clouds."""


def _floor_from(pose: Pose6, below_deg: float) -> float:
    """Distance at which the lowest ray of a mount meets the floor ahead, m."""
    angle = pose[4] + math.radians(below_deg)
    if angle <= 0.0:
        return math.inf
    return pose[0] + pose[2] / math.tan(min(angle, math.pi / 2.0))


def _check_reach(least: float, most: float) -> None:
    if not least < most:
        raise ValueError("range_min must be less than range_max")


NO_DROP_PROTECTION = "no drop protection: no sensor of it sees stairs, kerbs and edges of the floor"
"""What is said of a robot that does not see the floor."""
_NEAR_FLOOR = 3.0
"""Distance ahead within which a sensor must see the floor, m."""
_FARTHEST_CORNER = 5.0
_THINNEST = 0.05
_TIGHTEST = 0.1  # m, curves of a robot whose axle lies at its edge


class Robot(Model):
    """Description of a robot, shared by planners and simulator."""

    name: str
    kinematics: str = "unicycle"
    """The motion model, an entry point of ``cohelm.kinematics``."""
    footprint: tuple[tuple[float, float], ...]
    """Corners (x, y) about the drive axle's centre, counter-clockwise, m."""
    max_speed: float = Field(gt=0.0, le=10.0)
    """Forward, m/s."""
    max_reverse_speed: float = Field(0.0, ge=0.0, le=10.0)
    """m/s."""
    max_turn_rate: float = Field(gt=0.0, le=10.0)
    """rad/s."""
    minimum_turning_radius: float | None = Field(None, gt=0.0, le=20.0)
    """Minimum radius of curves in paths, m (Nav2's name). None: the inscribed radius, because a
    chair that turns about a point within itself turns on the spot instead."""
    max_acceleration: float = Field(ge=0.05, le=20.0)
    """m/s²."""
    max_deceleration: float = Field(ge=0.05, le=20.0)
    """Comfort braking, m/s²."""
    emergency_deceleration: float = Field(ge=0.05, le=20.0)
    """Emergency braking that still keeps the rider seated, m/s²."""
    max_turn_acceleration: float = Field(ge=0.05, le=50.0)
    """rad/s²."""
    max_jerk: float = Field(1.5, gt=0.0, le=1000.0)
    """Comfortable change of the linear acceleration, m/s³; emergency braking ignores it."""
    max_step_up: float = Field(0.04, ge=0.0, le=0.5)
    """Highest step that the wheels may climb, m (assumed; so for steps down)."""
    max_step_down: float = Field(0.04, ge=0.0, le=0.5)
    """Deepest step that they may take down, m; sensors tell none below 0.025 from noise."""
    max_slope_deg: float = Field(6.0, ge=0.0, le=30.0)
    """Steepest slope along the heading, degrees (assumed; handbooks of chairs allow 5 to 7.5)."""
    actuation_lag: float = Field(0.0, ge=0.0, le=1.0)
    """Time constant from command to wheels, s."""
    lasers: tuple[LaserMount, ...] = (LaserMount(),)
    """Planar scanners."""
    lidars: tuple[LidarMount, ...] = ()
    depth_cameras: tuple[DepthCameraMount, ...] = ()
    chassis: Chassis | None = None
    """Mechanics for the MuJoCo twin; nothing else reads them. None: no twin of this robot."""
    source: str = ""
    """Source of the figures, and which of them are assumed."""

    @field_validator("footprint")
    @classmethod
    def _footprint_is_a_polygon(cls, corners: tuple[Any, ...]) -> tuple[Any, ...]:
        points = np.asarray(corners, dtype=float)
        if len(points) < 3:
            raise ValueError("needs at least three corners")
        if not np.isfinite(points).all():
            raise ValueError("has a corner that is not a number")
        if np.abs(points).max() > _FARTHEST_CORNER:
            raise ValueError(f"has a corner beyond {_FARTHEST_CORNER:g} m of the drive axle")
        x, y = points.T
        area = 0.5 * float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))
        if abs(area) < 1e-4:
            raise ValueError("encloses no area")
        if np.ptp(points, axis=0).min() < _THINNEST:
            raise ValueError(f"is thinner than {_THINNEST:g} m")
        if distance_to_polygon(points, 0.0, 0.0) > 0.0:
            raise ValueError("does not contain the drive axle's centre (0, 0)")
        return corners if area > 0.0 else corners[::-1]

    @field_validator("kinematics")
    @classmethod
    def _kinematics_is_installed(cls, name: str) -> str:
        known = names("kinematics")
        if name not in known:
            raise ValueError("no motion model of that name" + nearest(name, known))
        return name

    @model_validator(mode="after")
    def _sensors_have_unique_names(self) -> Self:
        given = [mount.name for mount in self.cloud_mounts]
        if given:  # planar scanners alone are identified by their order
            given += [mount.name for mount in self.lasers]
        double = next((name for name in given if given.count(name) > 1), None)
        if double is not None:
            raise ValueError(f"two sensors are called {double!r}; names must be unique")
        return self

    @model_validator(mode="after")
    def _brakes_agree(self) -> Self:
        if self.emergency_deceleration < self.max_deceleration:
            raise ValueError("emergency_deceleration must not be below max_deceleration")
        return self

    def __eq__(self, other: object) -> bool:
        """Check that all fields agree; derived values agree then as well."""
        return isinstance(other, Robot) and self.model_dump() == other.model_dump()

    def __hash__(self) -> int:
        """Hash of all fields."""
        return hash(self.model_dump_json())

    @cached_property
    def motion_model(self) -> Kinematics:
        """The motion model named by ``kinematics``."""
        model: Kinematics = build("kinematics", self.kinematics)
        return model

    @property
    def cloud_mounts(self) -> tuple[CloudMount, ...]:
        """All mounts of point cloud sensors, LiDARs first."""
        return (*self.lidars, *self.depth_cameras)

    @property
    def sees_floor(self) -> bool:
        """True if a sensor sees the floor near enough ahead to stop before an edge."""
        return any(mount.floor_from <= _NEAR_FLOOR for mount in self.cloud_mounts)

    @cached_property
    def outline(self) -> Floats:
        """The footprint's corners, (k, 2), m."""
        return read_only(np.array(self.footprint, dtype=float))

    @cached_property
    def limits(self) -> Floats:
        """(v_max, v_reverse, ω_max, a_max, a_brake, α_max) for :meth:`Kinematics.bounds`."""
        return read_only(
            np.array(
                [
                    self.max_speed,
                    self.max_reverse_speed,
                    self.max_turn_rate,
                    self.max_acceleration,
                    self.max_deceleration,
                    self.max_turn_acceleration,
                ]
            )
        )

    @cached_property
    def input_bounds(self) -> InputBounds:
        """Bounds of the inputs and of their change per second."""
        return InputBounds(*map(read_only, self.motion_model.bounds(self.limits)))

    @cached_property
    def wheels(self) -> Floats:
        """Places (k, 2) of wheels and casters on the floor, m; the corners without a chassis."""
        if self.chassis is None:
            return self.outline
        half, pairs = self.chassis.drive.track / 2.0, [self.chassis.front, self.chassis.rear]
        left = [(0.0, half), *(pair.axis for pair in pairs if pair is not None)]
        return read_only(np.array([*left, *((x, -y) for x, y in left)]))

    @cached_property
    def discs(self) -> Floats:
        """Discs (c, 3) of (x, y, radius) on the long axis that cover the footprint, m.

        The bounding rectangle is cut across its longer side into equal pieces. Each disc passes
        through the corners of its piece; their number keeps the overhang at the sides under 3 cm.
        """
        low, high = self.outline.min(axis=0), self.outline.max(axis=0)
        size = high - low
        along = int(np.argmax(size))
        length, width = size[along], size[1 - along]
        count = 1
        while np.hypot(length / count, width) / 2.0 > width / 2.0 + 0.03:
            count += 1
        discs = np.empty((count, 3))
        discs[:, along] = low[along] + length * (np.arange(count) + 0.5) / count
        discs[:, 1 - along] = low[1 - along] + width / 2.0
        discs[:, 2] = np.hypot(length / count, width) / 2.0
        return read_only(discs)

    @cached_property
    def capsule(self) -> Floats:
        """(x_a, y_a, x_b, y_b, radius): the spine through the discs' centres, their radius, m."""
        first, last = self.discs[0], self.discs[-1]
        return read_only(np.array([*first[:2], *last[:2], first[2]]))

    @cached_property
    def inscribed_radius(self) -> float:
        """Distance from the drive axle's centre to the nearest edge, m."""
        return -float(distance_to_polygon(self.outline, 0.0, 0.0))

    @cached_property
    def max_curvature(self) -> float:
        """Largest curvature of a path that the robot follows without stopping to turn, 1/m."""
        return 1.0 / (self.minimum_turning_radius or max(self.inscribed_radius, _TIGHTEST))

    @cached_property
    def circumscribed_radius(self) -> float:
        """Distance from the drive axle's centre to the farthest corner, m."""
        return float(np.hypot(*self.outline.T).max())


def robot_names() -> tuple[str, ...]:
    """Names of the robots that are included in cohelm."""
    return tuple(
        sorted(
            f.name.removesuffix(".yaml") for f in _shipped().iterdir() if f.name.endswith(".yaml")
        )
    )


def load_robot(name_or_file: str | Path) -> Robot:
    """Load a robot by its name, or from a YAML file.

    Raises:
        ConfigError: with the file and the dotted key, or with the known names.
    """
    text = str(name_or_file)
    if text in robot_names():
        return load(Robot, Path(str(_shipped() / f"{text}.yaml")))
    if text.endswith((".yaml", ".yml")) or "/" in text:
        return load(Robot, Path(text))
    raise ConfigError(
        f"no robot is called {text!r}{nearest(text, robot_names())} (or give a .yaml file)"
    )


def _shipped() -> Any:
    return files("cohelm.robots")
