"""A planar laser scanner: rays, range noise and dropouts."""

from __future__ import annotations

import math

import numpy as np

from cohelm.arrays import Floats
from cohelm.geometry import compose
from cohelm.maps import OccupancyGrid
from cohelm.messages import Scan
from cohelm.robots import LaserMount
from cohelm.simulation.sensors.grid_raycast import cast
from cohelm.simulation.wall_geometry import walls_of


def sweep(
    mount: LaserMount,
    grid: OccupancyGrid,
    people: Floats,
    X_MR: Floats,
    *,
    time: float,
    rng: np.random.Generator,
) -> Scan:
    """Simulate one sweep; the chair that carries the scanner is not detected.

    Only occupied cells reflect; unknown ones do not. The number of random draws is constant.

    Args:
        mount: the scanner on the robot.
        grid: true obstacles.
        people: (n, 3) bodies as (x, y, radius), map frame, m.
        X_MR: (3,) the robot's true pose.
        time: of the sweep, s.
        rng: for noise and dropouts.
    """
    ranges = cast(
        walls_of(grid, unknown=False).solid,
        grid.resolution,
        grid.X_MG,
        people,
        compose(X_MR, np.asarray(mount.pose, dtype=float)),
        beam_angles(mount),
        mount.range_max,
    )
    return measured_scan(mount, ranges, time=time, rng=rng)


def beam_angles(mount: LaserMount) -> Floats:
    """Directions (b,) of the beams in the sensor's frame, rad."""
    first, increment = _directions(mount)
    return first + increment * np.arange(mount.beams, dtype=np.float64)


def measured_scan(
    mount: LaserMount, ranges: Floats, *, time: float, rng: np.random.Generator
) -> Scan:
    """Add noise and dropouts to true ranges (b,), m; +inf: no return."""
    first, increment = _directions(mount)
    noise = mount.noise * rng.standard_normal(mount.beams)
    lost = rng.random(mount.beams) < mount.dropout
    seen = np.clip(ranges + noise, 0.0, mount.range_max)
    return Scan(
        time=time,
        mount=np.asarray(mount.pose, dtype=float),
        angle_min=first,
        angle_increment=increment,
        range_max=mount.range_max,
        ranges=np.where(lost, np.nan, np.where(np.isinf(ranges), np.inf, seen)),
    )


def _directions(mount: LaserMount) -> tuple[float, float]:
    """(first angle, increment), rad; a full turn does not repeat its first beam at the end."""
    view = math.radians(mount.field_of_view_deg)
    gaps = mount.beams if mount.field_of_view_deg == 360.0 else mount.beams - 1
    return -view / 2.0, view / gaps
