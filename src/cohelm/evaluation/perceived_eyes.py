"""The people of a film as bodies, and the LiDAR that sees them."""

from __future__ import annotations

import numpy as np

from cohelm.arrays import Annotated, Floats, Shape, value
from cohelm.evaluation.perceived import Instant
from cohelm.maps import FREE, OccupancyGrid
from cohelm.messages import PointCloud
from cohelm.recordings import Trajectories
from cohelm.robots import LidarMount
from cohelm.simulation.chance import generator
from cohelm.simulation.sensors.cloud import sweep_cloud
from cohelm.simulation.sensors.figures import Bodies
from cohelm.simulation.sensors.scenery import Scenery

HEIGHT = (1.70, 0.08)
"""Mean and standard deviation of people's heights, m (assumed)."""
RADIUS = 0.25
"""Of everybody's disc, m."""
FACES = 0.2
"""Least speed at which people face where they go, m/s; below, where they last went."""
_MARGIN = 12.0  # of floor about everybody, m
_CELL = 0.5


@value
class Cast:
    """What the bodies of n people in k sightings are like; both as in ``Trajectories``."""

    walked: Annotated[Floats, Shape("k")]
    """Since each person's first sighting, m."""
    heading: Annotated[Floats, Shape("k")]
    """rad."""
    height: Annotated[Floats, Shape("n")]
    """m."""


def cast_of(trajectories: Trajectories, seed: int) -> Cast:
    """The bodies of a film's people; heights are drawn from ``seed``."""
    n, first = len(trajectories.id), trajectories.first
    whose = np.repeat(np.arange(n), np.diff(first))
    step = np.hypot(*np.diff(trajectories.position, axis=0, prepend=np.zeros((1, 2))).T)
    total = np.cumsum(step)
    velocity = trajectories.velocity
    moving = np.hypot(velocity[:, 0], velocity[:, 1]) >= FACES
    last = np.where(moving, np.arange(len(whose)), first[whose])
    last = np.maximum.accumulate(last)
    height = HEIGHT[0] + HEIGHT[1] * generator(seed, "bodies").standard_normal(n)
    return Cast(
        walked=total - total[first[whose]],
        heading=np.arctan2(velocity[last, 1], velocity[last, 0]),
        height=np.clip(height, 1.45, 1.95),
    )


def bodies_at(trajectories: Trajectories, cast: Cast, instant: Instant) -> Bodies:
    """The bodies of those who are there."""
    who = np.searchsorted(trajectories.id, instant.id)
    time = instant.observation.time
    at = np.maximum(trajectories.last_before(time), trajectories.first[:-1])[who]
    speed = np.hypot(instant.velocity[:, 0], instant.velocity[:, 1])
    course = np.arctan2(instant.velocity[:, 1], instant.velocity[:, 0])
    since = np.hypot(*(instant.position - trajectories.position[at]).T)
    return Bodies(
        position=instant.position,
        heading=np.where(speed >= FACES, course, cast.heading[at]),
        walked=cast.walked[at] + since,
        speed=speed,
        height=cast.height[who],
        radius=np.full(len(who), RADIUS),
    )


class LidarEyes:
    """A LiDAR among the people of a film, on an open and level floor.

    Its chance is its own: two with one seed see the same.

    Args:
        trajectories: the film.
        seed: of noise and bodies, ≥ 0.
        mount: the sensor; None: the usual one.
    """

    def __init__(
        self, trajectories: Trajectories, seed: int, mount: LidarMount | None = None
    ) -> None:
        self.mount = mount or LidarMount()
        self._film, self._cast = trajectories, cast_of(trajectories, seed)
        self._scenery = Scenery(grid=_open_floor(trajectories))
        self._rng = generator(seed, "lidar 0")

    def __call__(self, instant: Instant) -> tuple[PointCloud, Floats]:
        """The cloud, and the share of each person (n,) that the sensor sees."""
        sweep = sweep_cloud(
            self.mount,
            self._scenery,
            bodies_at(self._film, self._cast, instant),
            instant.pose,
            time=instant.observation.time,
            rng=self._rng,
        )
        return sweep.cloud, sweep.visible


def _open_floor(trajectories: Trajectories) -> OccupancyGrid:
    low = trajectories.position.min(axis=0) - _MARGIN
    size = trajectories.position.max(axis=0) + _MARGIN - low
    columns, rows = np.ceil(size / _CELL).astype(int)
    return OccupancyGrid(
        data=np.full((rows, columns), FREE, dtype=np.int8),
        resolution=_CELL,
        X_MG=np.array([*low, 0.0]),
    )
