"""Sensor mounts: planar scanners, 3-D LiDARs and depth cameras."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from pydantic import Field, model_validator

from cohelm.arrays import Booleans, Floats
from cohelm.config import Model

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

    def deviation(self, distance: Floats) -> Floats:
        """Standard deviation of ranges (...,), m; grows with their square."""
        return self.noise * distance * distance


CloudMount = LidarMount | DepthCameraMount
"""Any sensor of point clouds."""


def _check_reach(least: float, most: float) -> None:
    if not least < most:
        raise ValueError("range_min must be less than range_max")
